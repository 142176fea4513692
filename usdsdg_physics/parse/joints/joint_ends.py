"""Read the ends of joints: the bodies that they hold together, and the joint's frame in each."""

from __future__ import annotations

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.errors import warn_once
from usdsdg.stage.poses.rotations import compose, decompose
from usdsdg_physics.parse.attributes import has_api, value
from usdsdg_physics.parse.colliders import frame_from_prim
from usdsdg_physics.parse.simulation_owners import has_scene
from usdsdg_physics.parse.units import Units
from usdsdg_physics.scene.records import STATIC


def joint_bodies(prim: Usd.Prim) -> list[str]:
    """Return the paths of the rigid bodies that a joint names, whatever its type."""
    owners = (_owner(prim.GetStage().GetPrimAtPath(path)) for path in _targets(prim))
    return [str(owner.GetPath()) for owner in owners if owner]


def _targets(prim: Usd.Prim) -> list[Sdf.Path]:
    found = []
    for number in (0, 1):
        relation = prim.GetRelationship(f"physics:body{number}")
        found += relation.GetTargets()[:1] if relation else []
    return found


def _owner(prim: Usd.Prim) -> Usd.Prim | None:
    """Return the rigid body at or above the prim that a joint names; None where the nearest is not simulated."""
    while prim and not prim.IsPseudoRoot():
        if has_api(prim, "PhysicsRigidBodyAPI"):
            enabled = value(prim, "physics:rigidBodyEnabled", True) and not prim.IsInstanceProxy()
            return prim if enabled and has_scene(prim) else None
        xformable = UsdGeom.Xformable(prim)
        if xformable and xformable.GetResetXformStack():
            return None
        prim = prim.GetParent()
    return None


def read_end(
    prim: Usd.Prim, number: int, cache: UsdGeom.XformCache, units: Units
) -> tuple[str, tuple[float, ...]] | None:
    """Return the body at an end of a joint, and the joint's frame in its frame: x, y, z [m], rotation (x, y, z, w).

    None, with a warning, where it is not finite.
    """
    relation = prim.GetRelationship(f"physics:body{number}")
    targets = relation.GetTargets() if relation else []
    target = _nearest(prim, number, targets[0]) if targets else None
    owner = _owner(target) if target else None
    to_frame = frame_from_prim(target, owner, cache, units) if target else np.diag([units.meters] * 3 + [1.0])
    if not np.isfinite(to_frame).all():
        return None
    position = value(prim, f"physics:localPos{number}", (0.0, 0.0, 0.0))
    authored = value(prim, f"physics:localRot{number}", None)
    if not np.isfinite([*position, *(_components(authored) if authored is not None else ())]).all():
        warn_once(
            f"{prim.GetPath()}: physics:localPos{number} or physics:localRot{number} is not finite; the joint is left "
            "out. Author finite numbers."
        )
        return None
    rotation = _quat(authored)
    # The frame turns with the prim, and only its origin is scaled.
    placed = compose(rotation=rotation) @ compose(rotation=decompose(to_frame).rotation)
    origin = (np.append(np.asarray(position, np.float64), 1.0) @ to_frame)[:3]
    turned = decompose(placed).rotation
    return str(owner.GetPath()) if owner else STATIC, (*origin.tolist(), *np.asarray(turned).tolist())


def _nearest(joint: Usd.Prim, number: int, path: Sdf.Path) -> Usd.Prim | None:
    """Return the prim that an end of a joint names; as in PhysX the nearest above where there is none.

    None is the world.
    """
    found, stage = path, joint.GetStage()
    while not found.IsAbsoluteRootPath() and not ((prim := stage.GetPrimAtPath(found)) and prim.IsActive()):
        found = found.GetParentPath()
    if found != path:
        place = "the world" if found.IsAbsoluteRootPath() else str(found)
        warn_once(
            f"{joint.GetPath()}: physics:body{number} names {path}, which is no active prim, so as in PhysX {place} "
            f"takes its place, with physics:localPos{number} in it. Name another, or remove the joint."
        )
    return None if found.IsAbsoluteRootPath() else stage.GetPrimAtPath(found)


def _components(rotation: Gf.Quatf) -> tuple[float, ...]:
    return (*rotation.GetImaginary(), rotation.GetReal())


def _quat(rotation: Gf.Quatf | None) -> tuple[float, ...]:
    # In 64 bits, since squares of large and small numbers leave the range of 32.
    components = np.array((0.0, 0.0, 0.0, 0.0) if rotation is None else _components(rotation), np.float64)
    length = float(np.linalg.norm(components))
    return tuple((components / length).tolist()) if length > 0.0 else (0.0, 0.0, 0.0, 1.0)
