"""Shapes that are seen, that collide, or that fall: boxes, spheres, capsules, cylinders, cones and Xforms."""

from __future__ import annotations

from typing import TypeAlias

from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from usdsdg.compat.omni.physx.scripts.physicsUtils.xform_ops import Quaternion, Vector, place
from usdsdg.stage.paths import next_free_path

AnyPath: TypeAlias = str | Sdf.Path

_ORIGIN, _UNTURNED, _WHITE, _ONE = Gf.Vec3f(0.0), Gf.Quatf(1.0), Gf.Vec3f(1.0), Gf.Vec3f(1.0)


def get_stage_next_free_path(stage: Usd.Stage, path: AnyPath, prepend_default_prim: bool) -> str:
    """Return a path that no prim has: this one, below the default prim if wanted, or with a number."""
    return next_free_path(stage, _absolute(path), prepend_default_prim=prepend_default_prim)


# --- shapes that are seen ---
def add_box(
    stage: Usd.Stage,
    path: AnyPath,
    size: Vector | float = _ONE,
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    color: Gf.Vec3f = _WHITE,
) -> Usd.Prim:
    """Add a Cube of size 1 that is scaled by `size` (3,), below the default prim at a path that is free."""
    cube = UsdGeom.Cube.Define(stage, get_stage_next_free_path(stage, path, True))
    cube.CreateSizeAttr(1.0)
    return _finish(cube, Gf.Vec3f(0.5), position, orientation, color, scale=Gf.Vec3f(size))


def add_sphere(
    stage: Usd.Stage,
    path: AnyPath,
    radius: float = 1.0,
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    color: Gf.Vec3f = _WHITE,
) -> Usd.Prim:
    """Add a Sphere; see `add_box`."""
    sphere = UsdGeom.Sphere.Define(stage, get_stage_next_free_path(stage, path, True))
    sphere.CreateRadiusAttr(radius)
    return _finish(sphere, Gf.Vec3f(radius), position, orientation, color)


def add_capsule(
    stage: Usd.Stage,
    path: AnyPath,
    radius: float = 1.0,
    height: float = 1.0,
    axis: str = "Y",
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    color: Gf.Vec3f = _WHITE,
) -> Usd.Prim:
    """Add a Capsule; see `add_box`."""
    return _add_round(stage, path, UsdGeom.Capsule, (radius, height, axis), position, orientation, color)


def add_cylinder(
    stage: Usd.Stage,
    path: AnyPath,
    radius: float = 1.0,
    height: float = 1.0,
    axis: str = "Y",
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    color: Gf.Vec3f = _WHITE,
) -> Usd.Prim:
    """Add a Cylinder; see `add_box`."""
    return _add_round(stage, path, UsdGeom.Cylinder, (radius, height, axis), position, orientation, color)


def add_cone(
    stage: Usd.Stage,
    path: AnyPath,
    radius: float = 1.0,
    height: float = 1.0,
    axis: str = "Y",
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    color: Gf.Vec3f = _WHITE,
) -> Usd.Prim:
    """Add a Cone; see `add_box`."""
    return _add_round(stage, path, UsdGeom.Cone, (radius, height, axis), position, orientation, color)


def add_xform(
    stage: Usd.Stage,
    path: AnyPath,
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    scale: Vector = _ONE,
) -> Usd.Prim:
    """Add an Xform; see `add_box`."""
    xform = UsdGeom.Xform.Define(stage, get_stage_next_free_path(stage, path, True))
    place(xform, position, orientation, scale)
    return xform.GetPrim()


# --- shapes that collide ---
def add_collider_box(
    stage: Usd.Stage,
    path: AnyPath,
    size: Vector | float = _ONE,
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    color: Gf.Vec3f = _WHITE,
) -> Usd.Prim:
    """Add a static box; see `add_box`."""
    return _collide(add_box(stage, path, size, position, orientation, color))


def add_collider_sphere(
    stage: Usd.Stage,
    path: AnyPath,
    radius: float = 1.0,
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    color: Gf.Vec3f = _WHITE,
) -> Usd.Prim:
    """Add a static sphere; see `add_box`."""
    return _collide(add_sphere(stage, path, radius, position, orientation, color))


def add_collider_capsule(
    stage: Usd.Stage,
    path: AnyPath,
    radius: float = 1.0,
    height: float = 1.0,
    axis: str = "Y",
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    color: Gf.Vec3f = _WHITE,
) -> Usd.Prim:
    """Add a static capsule; see `add_box`."""
    return _collide(add_capsule(stage, path, radius, height, axis, position, orientation, color))


def add_collider_cylinder(
    stage: Usd.Stage,
    path: AnyPath,
    radius: float = 1.0,
    height: float = 1.0,
    axis: str = "Y",
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    color: Gf.Vec3f = _WHITE,
) -> Usd.Prim:
    """Add a static cylinder; see `add_box`."""
    return _collide(add_cylinder(stage, path, radius, height, axis, position, orientation, color))


def add_collider_cone(
    stage: Usd.Stage,
    path: AnyPath,
    radius: float = 1.0,
    height: float = 1.0,
    axis: str = "Y",
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    color: Gf.Vec3f = _WHITE,
) -> Usd.Prim:
    """Add a static cone; see `add_box`."""
    return _collide(add_cone(stage, path, radius, height, axis, position, orientation, color))


# --- shapes that fall ---
def add_rigid_box(
    stage: Usd.Stage,
    path: AnyPath,
    size: Vector | float = _ONE,
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    color: Gf.Vec3f = _WHITE,
    density: float = 1.0,
    lin_velocity: Gf.Vec3f = _ORIGIN,
    ang_velocity: Gf.Vec3f = _ORIGIN,
) -> Usd.Prim:
    """Add a box that is a rigid body; see `add_box`.

    Args:
        density: In the stage's units of mass and length; 0 adds a static box.
        lin_velocity: [stage units/s].
        ang_velocity: [degrees/s].
    """
    return _fall(add_box(stage, path, size, position, orientation, color), density, lin_velocity, ang_velocity)


def add_rigid_sphere(
    stage: Usd.Stage,
    path: AnyPath,
    radius: float = 1.0,
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    color: Gf.Vec3f = _WHITE,
    density: float = 1.0,
    lin_velocity: Gf.Vec3f = _ORIGIN,
    ang_velocity: Gf.Vec3f = _ORIGIN,
) -> Usd.Prim:
    """Add a sphere that is a rigid body; see `add_rigid_box`."""
    return _fall(add_sphere(stage, path, radius, position, orientation, color), density, lin_velocity, ang_velocity)


def add_rigid_capsule(
    stage: Usd.Stage,
    path: AnyPath,
    radius: float = 1.0,
    height: float = 1.0,
    axis: str = "Y",
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    color: Gf.Vec3f = _WHITE,
    density: float = 1.0,
    lin_velocity: Gf.Vec3f = _ORIGIN,
    ang_velocity: Gf.Vec3f = _ORIGIN,
) -> Usd.Prim:
    """Add a capsule that is a rigid body; see `add_rigid_box`."""
    prim = add_capsule(stage, path, radius, height, axis, position, orientation, color)
    return _fall(prim, density, lin_velocity, ang_velocity)


def add_rigid_cylinder(
    stage: Usd.Stage,
    path: AnyPath,
    radius: float = 1.0,
    height: float = 1.0,
    axis: str = "Y",
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    color: Gf.Vec3f = _WHITE,
    density: float = 1.0,
    lin_velocity: Gf.Vec3f = _ORIGIN,
    ang_velocity: Gf.Vec3f = _ORIGIN,
) -> Usd.Prim:
    """Add a cylinder that is a rigid body; see `add_rigid_box`."""
    prim = add_cylinder(stage, path, radius, height, axis, position, orientation, color)
    return _fall(prim, density, lin_velocity, ang_velocity)


def add_rigid_cone(
    stage: Usd.Stage,
    path: AnyPath,
    radius: float = 1.0,
    height: float = 1.0,
    axis: str = "Y",
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    color: Gf.Vec3f = _WHITE,
    density: float = 1.0,
    lin_velocity: Gf.Vec3f = _ORIGIN,
    ang_velocity: Gf.Vec3f = _ORIGIN,
) -> Usd.Prim:
    """Add a cone that is a rigid body; see `add_rigid_box`."""
    prim = add_cone(stage, path, radius, height, axis, position, orientation, color)
    return _fall(prim, density, lin_velocity, ang_velocity)


def add_rigid_xform(
    stage: Usd.Stage,
    path: AnyPath,
    position: Vector = _ORIGIN,
    orientation: Quaternion = _UNTURNED,
    scale: Vector = _ONE,
) -> Usd.Prim:
    """Add an Xform that is a rigid body, for colliders below it; see `add_box`."""
    prim = add_xform(stage, path, position, orientation, scale)
    UsdPhysics.RigidBodyAPI.Apply(prim).CreateRigidBodyEnabledAttr(True)
    return prim


# Older names of boxes.
add_cube, add_collider_cube, add_rigid_cube = add_box, add_collider_box, add_rigid_box


def _add_round(
    stage: Usd.Stage,
    path: AnyPath,
    kind: type[UsdGeom.Capsule | UsdGeom.Cylinder | UsdGeom.Cone],
    size: tuple[float, float, str],
    position: Vector,
    orientation: Quaternion,
    color: Gf.Vec3f,
) -> Usd.Prim:
    """Add a shape with a radius, a height and an axis."""
    radius, height, axis = size
    shape = kind.Define(stage, get_stage_next_free_path(stage, path, True))
    shape.CreateRadiusAttr(radius)
    shape.CreateHeightAttr(height)
    shape.CreateAxisAttr(axis)
    half = Gf.Vec3f(radius)
    half["XYZ".index(axis)] = height / 2 + (radius if kind is UsdGeom.Capsule else 0.0)
    return _finish(shape, half, position, orientation, color)


def _finish(
    shape: UsdGeom.Gprim,
    half: Gf.Vec3f,
    position: Vector,
    orientation: Quaternion,
    color: Gf.Vec3f,
    *,
    scale: Gf.Vec3f = _ONE,
) -> Usd.Prim:
    shape.CreateExtentAttr([-half, half])
    shape.CreateDisplayColorAttr([Gf.Vec3f(color)])
    place(shape, position, orientation, scale)
    return shape.GetPrim()


def _collide(prim: Usd.Prim) -> Usd.Prim:
    UsdPhysics.CollisionAPI.Apply(prim)
    return prim


def _fall(prim: Usd.Prim, density: float, linear: Gf.Vec3f, angular: Gf.Vec3f) -> Usd.Prim:
    _collide(prim)
    if density != 0.0:
        body = UsdPhysics.RigidBodyAPI.Apply(prim)
        body.CreateVelocityAttr(Gf.Vec3f(linear))
        body.CreateAngularVelocityAttr(Gf.Vec3f(angular))
        UsdPhysics.MassAPI.Apply(prim).CreateDensityAttr(density)
    return prim


def _absolute(path: AnyPath) -> Sdf.Path:
    return Sdf.Path(str(path)).MakeAbsolutePath(Sdf.Path.absoluteRootPath)
