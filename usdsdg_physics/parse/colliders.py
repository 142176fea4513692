"""Read colliders: CollisionAPI and PhysxCollisionAPI."""

from dataclasses import replace

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.errors import warn_once
from usdsdg.stage.physics.instances import part_name
from usdsdg_physics.parse.attributes import TRIGGER, TRIGGER_STATE, authored, finite, has_api, value
from usdsdg_physics.parse.bodies import read_mass
from usdsdg_physics.parse.shapes.collision_shapes import half_thickness, read_shapes
from usdsdg_physics.parse.shapes.convex_hulls import HullCache
from usdsdg_physics.parse.units import Units
from usdsdg_physics.scene.records import STATIC, Body, Collider, MassSpec, Material, Shape
from usdsdg_physics.scene.rigid_frames import body_from_prim, rigid_pose

# PhysX's contact offset when a collider names none is a few centimeters at human scale.
DEFAULT_GAP = 0.02  # m


def read_collider(
    prim: Usd.Prim,
    owner: Usd.Prim | None,
    material: Material,
    cache: UsdGeom.XformCache,
    units: Units,
    hulls: HullCache,
) -> list[Collider]:
    """Read a prim with CollisionAPI into the frame of its body, or the world's: a collider, or its convex parts.

    Args:
        owner: the rigid body that owns the collider, None for a static collider.
    """
    to_frame = frame_from_prim(prim, owner, cache, units)
    found = colliders_in_frame(prim, to_frame, material, units, hulls, owner=owner)
    return [replace(collider, body=str(owner.GetPath())) for collider in found] if owner else found


def read_moving_collider(
    prim: Usd.Prim, material: Material, cache: UsdGeom.XformCache, units: Units, hulls: HullCache
) -> tuple[Body, list[Collider]]:
    """Read a collider without a body as that of a kinematic body at the same path."""
    matrix, path = np.array(cache.GetLocalToWorldTransform(prim)), str(prim.GetPath())
    constant = body_from_prim(matrix, units.meters)
    pose = rigid_pose(matrix, units.meters)
    rows = tuple(tuple(row) for row in constant.tolist())
    body = Body(path=path, pose=tuple(pose.tolist()), body_from_prim=rows, kinematic=True, is_collider=True)
    found = colliders_in_frame(prim, constant, material, units, hulls, owner=None)
    return body, [replace(collider, body=path) for collider in found]


def colliders_in_frame(
    prim: Usd.Prim,
    to_frame: np.ndarray,
    material: Material,
    units: Units,
    hulls: HullCache,
    *,
    owner: Usd.Prim | None,
) -> list[Collider]:
    """Read a prim with CollisionAPI into a frame, as a static collider or convex parts; none without a shape.

    Args:
        to_frame: row-vector 4x4 from the prim's space [stage units] to the frame [m].
        owner: the rigid body that owns the collider. Where it is the prim itself, its mass is not the collider's.
    """
    shapes = collider_shapes(prim, owner, to_frame, hulls)
    if not shapes:
        return []
    margin = _rest_offset(prim, shapes[0], units)
    offset = finite(authored(prim, "physxCollision:contactOffset"), -1.0) * units.meters
    collider = Collider(
        path=str(prim.GetPath()),
        body=STATIC,
        shape=shapes[0],
        material=material,
        enabled=bool(value(prim, "physics:collisionEnabled", True)),
        gap=max(offset - margin, 0.0) if offset >= 0.0 else DEFAULT_GAP,
        margin=margin,
        mass=MassSpec() if prim == owner else read_mass(prim, units, to_frame),
        trigger=_is_trigger(prim),
        parts=len(shapes),
    )
    return [replace(collider, path=part_name(collider.path, part), shape=shape) for part, shape in enumerate(shapes)]


def collider_shapes(prim: Usd.Prim, owner: Usd.Prim | None, to_frame: np.ndarray, hulls: HullCache) -> list[Shape]:
    """Return the shapes of a collider in the frame of `to_frame`, as of `colliders_in_frame`.

    As in PhysX, triangles collide where nothing but users moves them: meshes of bodies that are not kinematic are
    solids. Those of triggers are, too: what is within them is inside.
    """
    owned = owner is not None
    solid = _is_trigger(prim) or (owned and not value(owner, "physics:kinematicEnabled", False))
    return read_shapes(prim, to_frame, hulls, owned=owned, solid=solid)


def _is_trigger(prim: Usd.Prim) -> bool:
    return has_api(prim, TRIGGER) or has_api(prim, TRIGGER_STATE)


def _rest_offset(prim: Usd.Prim, shape: Shape, units: Units) -> float:
    """Read the distance [m] from the surface of a collider at which others rest."""
    offset = finite(authored(prim, "physxCollision:restOffset"), 0.0) * units.meters
    if offset < 0.0 and (half := half_thickness(shape)) <= -offset:
        warn_once(
            f"{prim.GetPath()}: physxCollision:restOffset is {offset / units.meters:g}, which is below the middle of "
            f"the collider, so others fall through it. Set one above {-half / units.meters:.3g}."
        )
    return offset


def frame_from_prim(prim: Usd.Prim, owner: Usd.Prim | None, cache: UsdGeom.XformCache, units: Units) -> np.ndarray:
    """Return the row-vector 4x4 from a collider's space [stage units] to its body's frame, or the world's [m]."""
    if owner is None:
        matrix = np.array(cache.GetLocalToWorldTransform(prim))
        matrix[:, :3] *= units.meters
        return matrix
    # Local transforms up to the body, so that rounding of its world position does not change its shapes.
    relative = np.eye(4) if prim == owner else np.array(cache.ComputeRelativeTransform(prim, owner)[0])
    return relative @ body_from_prim(np.array(cache.GetLocalToWorldTransform(owner)), units.meters)
