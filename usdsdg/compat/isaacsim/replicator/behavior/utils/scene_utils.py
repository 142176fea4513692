"""`isaacsim.replicator.behavior.utils.scene_utils`: poses, assets, colliders and simulation steps for behaviors."""

from __future__ import annotations

import logging
from collections.abc import Sequence

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdShade

from usdsdg.app.app import get_app
from usdsdg.compat.isaacsim.replicator.behavior.utils.collision_walls import create_collision_walls
from usdsdg.compat.isaacsim.replicator.behavior.utils.rigid_bodies import (
    add_colliders,
    add_rigid_body_dynamics,
    create_physics_material,
    disable_colliders,
    disable_rigid_body_dynamics,
)
from usdsdg.compat.isaacsim.replicator.physics_steps import apply_forces, reset_simulation, simulate
from usdsdg.compat.isaacsim.replicator.prim_poses import (
    set_location,
    set_orientation,
    set_rotation,
    set_scale,
    set_transform_attributes,
    set_transform_matrix,
)
from usdsdg.errors import StageError
from usdsdg.session import stage_context
from usdsdg.session.settings.store import get_settings
from usdsdg.stage import assets, materials
from usdsdg.stage.poses.rotations import euler_from_matrix

__all__ = [
    "add_colliders", "add_rigid_body_dynamics", "apply_forces_and_simulate_async", "calculate_look_at_rotation",
    "create_asset", "create_collision_walls", "create_mdl_material", "create_physics_material", "decompose_rotation",
    "disable_colliders", "disable_rigid_body_dynamics", "disable_simulation_reset_on_stop",
    "get_rotation_op_and_value", "get_world_location", "get_world_rotation",
    "reset_simulation_and_enable_reset_on_stop", "run_simulation_async", "set_location", "set_orientation",
    "set_rotation", "set_rotation_op_and_value", "set_rotation_with_ops", "set_scale", "set_transform_attributes",
    "set_transform_matrix",
]  # fmt: skip

RESET_ON_STOP = "/physics/resetOnStop"

Rotation = float | Gf.Quatf | Gf.Quatd | Gf.Rotation | Gf.Vec3d | Gf.Vec3f

_log = logging.getLogger("usdsdg.script")


# --- poses ---
def get_world_location(prim: Usd.Prim, xform_cache: UsdGeom.XformCache | None = None) -> Gf.Vec3d:
    """Return the position of a prim in the world [stage units]."""
    return (xform_cache or UsdGeom.XformCache()).GetLocalToWorldTransform(prim).ExtractTranslation()


def get_world_rotation(prim: Usd.Prim, xform_cache: UsdGeom.XformCache | None = None) -> Gf.Rotation:
    """Return the rotation of a prim in the world, without its scale and shear."""
    return Gf.Transform((xform_cache or UsdGeom.XformCache()).GetLocalToWorldTransform(prim)).GetRotation()


def get_rotation_op_and_value(prim: Usd.Prim) -> tuple[str, Rotation]:
    """Return the name and value of the first op that rotates a prim; the value of a matrix op is its Gf.Rotation.

    A prim without such an op gets an `xformOp:orient` of identity.
    """
    op = _rotation_op(prim)
    if op is None:
        op = UsdGeom.Xformable(prim).AddOrientOp(UsdGeom.XformOp.PrecisionDouble)
        op.Set(Gf.Quatd(1.0))
    value = op.Get()
    return op.GetOpName(), Gf.Transform(value).GetRotation() if isinstance(value, Gf.Matrix4d) else value


def set_rotation_op_and_value(prim: Usd.Prim, rotation_op: str, rotation_val: Rotation) -> None:
    """Set an op to what `get_rotation_op_and_value` returned; a matrix op keeps its translation and scale."""
    for op in UsdGeom.Xformable(prim).GetOrderedXformOps():
        if op.GetOpName() == rotation_op:
            op.Set(_rotated(op.Get(), rotation_val) if isinstance(rotation_val, Gf.Rotation) else rotation_val)
            return


def set_rotation_with_ops(prim: Usd.Prim, rotation: Gf.Rotation) -> None:
    """Set the first op that rotates a prim, in its own type; a prim without one gets an `xformOp:orient`."""
    op = _rotation_op(prim) or UsdGeom.Xformable(prim).AddOrientOp(UsdGeom.XformOp.PrecisionDouble)
    kind = op.GetOpType()
    if kind == UsdGeom.XformOp.TypeTransform:
        op.Set(_rotated(op.Get(), rotation))
    elif kind == UsdGeom.XformOp.TypeOrient:
        double = op.GetPrecision() == UsdGeom.XformOp.PrecisionDouble
        op.Set(Gf.Quatd(rotation.GetQuat()) if double else Gf.Quatf(rotation.GetQuat()))
    else:
        try:
            op.Set(decompose_rotation(rotation, op.GetOpName().removeprefix("xformOp:rotate")))
        except ValueError as error:
            _log.warning("[%s] %s", prim.GetPath(), error)


def decompose_rotation(rotation: Gf.Rotation, rotation_order: str) -> float | Gf.Vec3f:
    """Return the angles about x, y and z [degrees] of a rotate op of an order; of "X", "Y" or "Z" that about the axis.

    Raises:
        ValueError: there is no such order.
    """
    if rotation_order not in ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX", "X", "Y", "Z"):
        raise ValueError(f"Unsupported rotation_order: {rotation_order!r}")
    order = rotation_order if len(rotation_order) == 3 else "XYZ"
    angles = euler_from_matrix(np.array(Gf.Matrix3d(rotation)), order)
    if len(rotation_order) == 1:
        return float(angles["XYZ".index(rotation_order)])
    return Gf.Vec3f(*angles.tolist())


def calculate_look_at_rotation(
    eye: Gf.Vec3d, target_location: Gf.Vec3d, up_axis: Gf.Vec3d, epsilon: float = 1e-5
) -> Gf.Rotation:
    """Return the world rotation of a camera at `eye` that looks, along its -Z, at a target.

    Where the view is parallel to `up_axis`, the eye is taken `epsilon` aside, which decides the rotation about it.
    """
    eye, target_location, up_axis = Gf.Vec3d(eye), Gf.Vec3d(target_location), Gf.Vec3d(up_axis)
    if Gf.Cross(target_location - eye, up_axis).GetLength() < epsilon:
        aside = next((axis for axis in range(2) if abs(up_axis[axis]) < epsilon), 2)
        eye += epsilon * Gf.Vec3d.Axis(aside)
    return Gf.Matrix4d().SetLookAt(eye, target_location, up_axis).GetInverse().ExtractRotation()


def _rotation_op(prim: Usd.Prim) -> UsdGeom.XformOp | None:
    for op in UsdGeom.Xformable(prim).GetOrderedXformOps():
        if op.GetOpName().startswith("xformOp:rotate") or op.GetOpName() in ("xformOp:orient", "xformOp:transform"):
            return op
    return None


def _rotated(matrix: Gf.Matrix4d, rotation: Gf.Rotation) -> Gf.Matrix4d:
    transform = Gf.Transform(matrix)
    transform.SetRotation(rotation)
    return transform.GetMatrix()


# --- assets and materials ---
def create_asset(stage: Usd.Stage, asset_url: str, prim_path: str) -> Usd.Prim:
    """Define an Xform that references a file, or a URL under the assets root.

    Raises:
        AssetNotFound: there is no such file. AssetUnreadable: it cannot be opened.
    """
    file = assets.resolve_reference(asset_url, prim_path)
    prim = stage.DefinePrim(prim_path, "Xform")
    prim.GetReferences().AddReference(file)
    return prim


def create_mdl_material(mtl_url: str, mtl_name: str, mtl_path: str) -> UsdShade.Material:
    """Define an MDL material of the current stage with inputs for a texture that is projected, scaled and rotated."""
    material = materials.define_mdl(stage_context.current_stage(), mtl_path, mtl_url)
    shader = UsdShade.Shader(material.GetPrim().GetChild("Shader"))
    shader.SetSourceAssetSubIdentifier(mtl_name, "mdl")
    for name in ("diffuse_texture", "project_uvw", "texture_scale", "texture_rotate"):
        shader.CreateInput(name, materials.OMNI_PBR_INPUTS[name])
    return material


# --- simulation steps ---
async def run_simulation_async(sim_steps: int, physx_dt: float, render: bool = True) -> None:
    """Simulate `sim_steps` steps of `physx_dt` seconds; the timeline stays. `render`: an app update after each."""
    for _ in range(sim_steps):
        simulate(physx_dt)
        if render:
            await get_app().next_update_async()


async def apply_forces_and_simulate_async(
    stage_id: int,
    body_ids: Sequence[int],
    forces: Sequence[Sequence[float]],
    positions: Sequence[Sequence[float]],
    sim_steps: int,
    physx_dt: float,
    render: bool = True,
) -> None:
    """Push bodies during one step, then simulate as `run_simulation_async` does.

    Args:
        body_ids: as `PhysicsSchemaTools.sdfPathToInt` gives them.
        forces: world, in the stage's units of mass, length and s⁻².
        positions: world points where the forces act [stage units].

    Raises:
        StageError: `stage_id` is not the current stage's, which is the one that is simulated.
    """
    from pxr import PhysicsSchemaTools

    if stage_id != stage_context.stage_id():
        raise StageError(f"stage {stage_id} is not simulated; the current stage has id {stage_context.stage_id()}")
    apply_forces([str(PhysicsSchemaTools.intToSdfPath(each)) for each in body_ids], forces, positions)
    await run_simulation_async(sim_steps, physx_dt, render)


def disable_simulation_reset_on_stop() -> None:
    """Keep what `run_simulation_async` has done when the simulation is reset."""
    get_settings().set(RESET_ON_STOP, False)


def reset_simulation_and_enable_reset_on_stop() -> None:
    """End the simulation, with bodies where they are, and restore poses on stop again.

    Without `disable_simulation_reset_on_stop` before it, it only warns.
    """
    if get_settings().get(RESET_ON_STOP) is not False:
        _log.warning("reset_simulation: call disable_simulation_reset_on_stop before the simulation")
        return
    reset_simulation(restore=False)
    get_settings().set(RESET_ON_STOP, True)
