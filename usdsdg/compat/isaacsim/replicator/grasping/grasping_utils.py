"""`isaacsim.replicator.grasping.grasping_utils`: physics scenes, steps, joints, and configuration files of grasps."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from typing import Any

from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from usdsdg.app.app import get_app
from usdsdg.compat.isaacsim.replicator.behavior.utils.scene_utils import apply_forces_and_simulate_async
from usdsdg.compat.isaacsim.replicator.grasping import sampler_utils
from usdsdg.compat.isaacsim.replicator.grasping.joints import (
    apply_joint_pregrasp_state,
    apply_joint_pregrasp_states,
    get_gripper_joint_states,
    get_gripper_joints_info,
    get_joint_state,
    populate_joint_pregrasp_states_from_current,
    set_joint_drive_parameters,
    set_joint_state,
)
from usdsdg.compat.isaacsim.replicator.grasping.yaml_files import read_yaml_config, write_yaml_config
from usdsdg.compat.isaacsim.replicator.physics_steps import reset_simulation, simulate
from usdsdg.errors import ArgumentError, warn_once
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.physics import scenes

__all__ = [
    "advance_timeline_async", "apply_joint_pregrasp_state", "apply_joint_pregrasp_states",
    "clear_isolated_simulation_owners", "create_or_get_physics_scene", "duplicate_prim",
    "find_first_mesh_in_hierarchy", "generate_grasp_poses_from_config", "get_gripper_joint_states",
    "get_gripper_joints_info", "get_joint_state", "get_physics_scene", "isolate_prims_to_scene",
    "populate_joint_pregrasp_states_from_current", "read_yaml_config", "remove_physics_scene",
    "remove_rigid_body_simulation_owner", "reset_physics_simulation", "set_joint_drive_parameters", "set_joint_state",
    "set_rigid_body_simulation_owner", "simulate_physics_async", "simulate_physics_with_forces_async",
    "stop_timeline", "write_yaml_config",
]  # fmt: skip

_log = logging.getLogger("usdsdg.script")


# --- physics scenes ---
def get_physics_scene(stage: Usd.Stage, path: str) -> UsdPhysics.Scene | None:
    """Return the PhysicsScene at a path; None, with a warning, where there is none."""
    prim = stage.GetPrimAtPath(path) if Sdf.Path.IsValidPathString(path) else None
    if not prim or not prim.IsA(UsdPhysics.Scene):
        _log.warning("there is no PhysicsScene at %s", path)
        return None
    return UsdPhysics.Scene(prim)


def create_or_get_physics_scene(stage: Usd.Stage, path: str) -> UsdPhysics.Scene | None:
    """Return the PhysicsScene at a path, defined if there is no prim; None, with a warning, where another prim is."""
    return get_physics_scene(stage, path) if stage.GetPrimAtPath(path) else UsdPhysics.Scene.Define(stage, path)


def remove_physics_scene(stage: Usd.Stage, physics_scene_path: str) -> bool:
    """Remove the prim at a path; return whether there was one."""
    if not stage.GetPrimAtPath(physics_scene_path):
        _log.warning("there is no PhysicsScene at %s", physics_scene_path)
        return False
    return stage.RemovePrim(physics_scene_path)


def set_rigid_body_simulation_owner(
    prims: list[Usd.Prim] | Usd.Prim, physics_scene_prim: UsdPhysics.Scene, include_descendants: bool = True
) -> list[Usd.Prim]:
    """Add a PhysicsScene to the owners of rigid bodies; return the bodies that did not have it."""
    path, changed = physics_scene_prim.GetPath(), []
    for prim, owners in _owners(prims, include_descendants):
        if path not in owners.GetTargets():
            owners.AddTarget(path)
            changed.append(prim)
    return changed


def remove_rigid_body_simulation_owner(
    prims: list[Usd.Prim] | Usd.Prim, physics_scene_prim: UsdPhysics.Scene, include_descendants: bool = True
) -> list[Usd.Prim]:
    """Remove a PhysicsScene from the owners of rigid bodies; return the bodies that had it."""
    path, changed = physics_scene_prim.GetPath(), []
    for prim, owners in _owners(prims, include_descendants):
        if path in owners.GetTargets():
            owners.SetTargets([target for target in owners.GetTargets() if target != path])
            changed.append(prim)
    return changed


def isolate_prims_to_scene(prims_to_isolate: list[Usd.Prim], physics_scene: UsdPhysics.Scene) -> list[Usd.Prim]:
    """Make a PhysicsScene the owner of the rigid bodies at and below prims, and return these.

    A warning says that all bodies are simulated together nevertheless.
    """
    warn_once("grasping: bodies are not isolated; all of the stage are simulated together, in the first PhysicsScene")
    return set_rigid_body_simulation_owner(prims_to_isolate, physics_scene)


def clear_isolated_simulation_owners(rigid_body_prims: list[Usd.Prim], physics_scene: UsdPhysics.Scene | None) -> None:
    """Undo `isolate_prims_to_scene`."""
    if physics_scene:
        remove_rigid_body_simulation_owner(rigid_body_prims, physics_scene)


def _owners(prims: list[Usd.Prim] | Usd.Prim, include_descendants: bool) -> list[tuple[Usd.Prim, Usd.Relationship]]:
    """Return the rigid bodies among prims, or also below them, each with the relationship to its PhysicsScenes."""
    roots = prims if isinstance(prims, list) else [prims]
    found = [each for root in roots for each in (Usd.PrimRange(root) if include_descendants else [root])]
    return [
        (prim, UsdPhysics.RigidBodyAPI(prim).CreateSimulationOwnerRel())
        for prim in found
        if prim.HasAPI(UsdPhysics.RigidBodyAPI)
    ]


# --- simulation ---
async def simulate_physics_async(
    num_frames: int, step_dt: float, physics_scene: UsdPhysics.Scene | None = None, render: bool = False
) -> None:
    """Take `num_frames` steps of `step_dt` seconds beside the timeline; `render`: an app update after each.

    All bodies of the stage are simulated; a warning says so where `physics_scene` is not the first PhysicsScene.

    Raises:
        ArgumentError: (a ValueError) a number is not positive.
    """
    _check_steps(num_frames, step_dt, physics_scene)
    for _ in range(num_frames):
        simulate(step_dt)
        if render:
            await get_app().next_update_async()
    await get_app().next_update_async()


async def simulate_physics_with_forces_async(
    stage_id: int,
    body_ids: list[int],
    forces: list[tuple[float, float, float]],
    positions: list[tuple[float, float, float]],
    sim_steps: int,
    physx_dt: float,
    physics_scene: UsdPhysics.Scene | None = None,
    render: bool = True,
) -> None:
    """Push bodies during one step, and simulate as `simulate_physics_async` does.

    Args:
        body_ids: as `PhysicsSchemaTools.sdfPathToInt` gives them.
        forces: world, in the stage's units of mass, length and s⁻².
        positions: world points where the forces act [stage units].
    """
    _check_steps(sim_steps, physx_dt, physics_scene)
    await apply_forces_and_simulate_async(stage_id, body_ids, forces, positions, sim_steps, physx_dt, render)
    await get_app().next_update_async()


def _check_steps(steps: int, step_dt: float, physics_scene: UsdPhysics.Scene | None) -> None:
    if not (steps > 0 and step_dt > 0):
        raise ArgumentError(f"grasping: {steps} steps of {step_dt} s; both must be positive.")
    first = scenes.physics_scene(current_stage())
    if physics_scene and physics_scene.GetPrim() != first:
        warn_once(
            f"{physics_scene.GetPath()}: bodies are simulated in the first PhysicsScene, {first and first.GetPath()}"
        )


def reset_physics_simulation() -> None:
    """End the simulation; bodies and joints return to where they were before it."""
    reset_simulation()


async def advance_timeline_async(num_frames: int, render: bool = False) -> None:
    """Play the timeline for `num_frames` updates, then pause it. There is no playing without updates.

    Raises:
        ArgumentError: (a ValueError) the number is not positive.
    """
    if num_frames <= 0:
        raise ArgumentError(f"grasping: num_frames is {num_frames}; it must be positive.")
    get_timeline().play()
    for _ in range(num_frames):
        await get_app().next_update_async()
    get_timeline().pause()


def stop_timeline() -> None:
    """Stop the timeline; bodies and joints return to where they were before."""
    get_timeline().stop()


# --- prims and poses ---
def find_first_mesh_in_hierarchy(prim: Usd.Prim) -> UsdGeom.Mesh | None:
    """Return the first mesh at or below a prim, also inside instances; None, with a warning, where there is none."""
    for each in Usd.PrimRange(prim, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)):
        if each.IsA(UsdGeom.Mesh):
            return UsdGeom.Mesh(each)
    _log.warning("there is no mesh at or below %s", prim.GetPath())
    return None


def duplicate_prim(stage: Usd.Stage, source_prim_path: str, destination_prim_path: str) -> Usd.Prim | None:
    """Copy a prim of the root layer; return None, with a warning, where it cannot be or the destination is taken."""
    paths = [Sdf.Path(path) for path in (source_prim_path, destination_prim_path) if Sdf.Path.IsValidPathString(path)]
    layer = stage.GetRootLayer()
    if len(paths) < 2 or not layer.GetPrimAtPath(paths[0]) or stage.GetPrimAtPath(paths[1]):
        _log.warning("%s is not copied to %s: a path is wrong or taken", source_prim_path, destination_prim_path)
        return None
    Sdf.CreatePrimInLayer(layer, paths[1].GetParentPath())
    Sdf.CopySpec(layer, paths[0], layer, paths[1])
    return stage.GetPrimAtPath(paths[1])


def generate_grasp_poses_from_config(
    object_prim: Usd.Prim, config: Mapping[str, Any]
) -> Sequence[tuple[Gf.Vec3d, Gf.Quatd]] | None:
    """Return antipodal poses in the object's frame; None, with a warning, where it has no mesh or for another sampler.

    Raises:
        ArgumentError: (a ValueError) the configuration is wrong.
    """
    mesh = find_first_mesh_in_hierarchy(object_prim) if object_prim else None
    if mesh is None:
        return None
    if (kind := config.get("sampler_type", "antipodal")) != "antipodal":
        _log.warning("there is no sampler %r, only 'antipodal'", kind)
        return None
    seed = config.get("random_seed")
    settings = {**config, "mesh_prim": mesh, "random_seed": None if seed == -1 else seed}
    return list(zip(*sampler_utils.generate_grasp_poses(settings)))
