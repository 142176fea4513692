"""Masses, forces, materials, joints and collision groups of prims."""

from __future__ import annotations

from pxr import Gf, Sdf, Usd, UsdPhysics, UsdShade

from usdsdg.compat.omni.physx.scripts.physicsUtils.shapes import AnyPath, get_stage_next_free_path
from usdsdg.stage.schemas import physx


def add_density(stage: Usd.Stage, path: AnyPath, value: float) -> UsdPhysics.MassAPI:
    """Author the density of a prim, in the stage's units of mass and length."""
    api = UsdPhysics.MassAPI.Apply(stage.GetPrimAtPath(str(path)))
    api.CreateDensityAttr(value)
    return api


def add_mass(stage: Usd.Stage, path: AnyPath, mass: float = 1.0) -> UsdPhysics.MassAPI:
    """Author the mass of a prim, in the stage's unit."""
    api = UsdPhysics.MassAPI.Apply(stage.GetPrimAtPath(str(path)))
    api.CreateMassAttr(mass)
    return api


def add_force_torque(
    stage: Usd.Stage,
    path: AnyPath,
    force: Gf.Vec3f = Gf.Vec3f(0.0),  # noqa: B008 - as in the original, and nobody changes it
    torque: Gf.Vec3f = Gf.Vec3f(0.0),  # noqa: B008
    mode: str = "acceleration",
    isEnabled: bool = True,
    isWorldSpace: bool = False,
) -> physx.PhysxForceAPI:
    """Let a force and a torque act on a prim at every step.

    Args:
        mode: Whether they are an "acceleration" or a "force".
        isWorldSpace: Whether they are in the world's axes, not in those of the prim.
    """
    api = physx.PhysxForceAPI.Apply(stage.GetPrimAtPath(str(path)))
    api.CreateForceAttr().Set(force)
    api.CreateTorqueAttr().Set(torque)
    api.CreateModeAttr().Set(mode)
    api.CreateForceEnabledAttr().Set(isEnabled)
    api.CreateWorldFrameEnabledAttr().Set(isWorldSpace)
    return api


def add_physics_material_to_prim(stage: Usd.Stage, prim: Usd.Prim, materialPath: AnyPath) -> None:
    """Bind a material for physics to a prim; materials of prims below are stronger."""
    material = UsdShade.Material(stage.GetPrimAtPath(str(materialPath)))
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, UsdShade.Tokens.weakerThanDescendants, "physics")


def add_joint_fixed(
    stage: Usd.Stage,
    jointPath: AnyPath,
    actor0: AnyPath | None,
    actor1: AnyPath | None,
    localPos0: Gf.Vec3f,
    localRot0: Gf.Quatf,
    localPos1: Gf.Vec3f,
    localRot1: Gf.Quatf,
    breakForce: float,
    breakTorque: float,
) -> UsdPhysics.FixedJoint:
    """Add a fixed joint between two prims, or a prim and the world, below the default prim at a path that is free."""
    joint = UsdPhysics.FixedJoint.Define(stage, get_stage_next_free_path(stage, jointPath, True))
    if actor0:
        joint.CreateBody0Rel().SetTargets([Sdf.Path(str(actor0))])
    if actor1:
        joint.CreateBody1Rel().SetTargets([Sdf.Path(str(actor1))])
    joint.CreateLocalPos0Attr(localPos0)
    joint.CreateLocalRot0Attr(localRot0)
    joint.CreateLocalPos1Attr(localPos1)
    joint.CreateLocalRot1Attr(localRot1)
    joint.CreateBreakForceAttr(breakForce)
    joint.CreateBreakTorqueAttr(breakTorque)
    return joint


# --- collision groups ---
def add_collision_to_collision_group(stage: Usd.Stage, collisionPath: AnyPath, collisionGroupPath: AnyPath) -> None:
    """Put a collider into a collision group."""
    if (includes := _includes(stage, collisionGroupPath)) is not None:
        includes.AddTarget(Sdf.Path(str(collisionPath)))


def remove_collision_from_collision_group(
    stage: Usd.Stage, collisionPath: AnyPath, collisionGroupPath: AnyPath
) -> None:
    """Take a collider out of a collision group."""
    if (includes := _includes(stage, collisionGroupPath)) is not None:
        includes.RemoveTarget(Sdf.Path(str(collisionPath)))


def is_in_collision_group(stage: Usd.Stage, collisionPath: AnyPath, collisionGroupPath: AnyPath) -> bool:
    """Whether a collider is in a collision group."""
    includes = _includes(stage, collisionGroupPath)
    return includes is not None and Sdf.Path(str(collisionPath)) in includes.GetTargets()


def _includes(stage: Usd.Stage, path: AnyPath) -> Usd.Relationship | None:
    group = UsdPhysics.CollisionGroup(stage.GetPrimAtPath(str(path)))
    return group.GetCollidersCollectionAPI().CreateIncludesRel() if group else None
