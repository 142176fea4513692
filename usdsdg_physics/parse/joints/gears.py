"""Read gears and racks: joints of PhysX that couple the motion of two other joints."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.errors import warn_once
from usdsdg.stage.poses.rotations import rotated
from usdsdg_physics.parse.attributes import finite, value
from usdsdg_physics.parse.units import Units
from usdsdg_physics.scene.records import STATIC, Joint, Mimic
from usdsdg_physics.scene.rigid_frames import rigid_pose

GEAR, RACK = "PhysxPhysicsGearJoint", "PhysxPhysicsRackAndPinionJoint"


@dataclass(frozen=True)
class _Gear:
    path: str
    first: str  # joint
    second: str
    gearing: float  # of the motion of the second body by that of the first, in SI units
    bodies: tuple[str, str]  # that turn or slide
    is_rack: bool


def is_gear(prim: Usd.Prim) -> bool:
    """Return whether a joint couples two others."""
    return str(prim.GetTypeName()) in (GEAR, RACK)


def coupled_bodies(prim: Usd.Prim) -> tuple[str, str]:
    """Return the paths that a gear names as its bodies, "" for none."""
    return _target(prim, "physics:body0"), _target(prim, "physics:body1")


def couple(
    gears: Collection[Usd.Prim], joints: Mapping[str, Joint], cache: UsdGeom.XformCache, units: Units
) -> dict[str, Joint]:
    """Return the joints, of which those in gear follow others from where they are.

    PhysX couples the motion of the bodies, joints measure that of their second body. So a hinge or slide of which the
    body in gear is the first one counts the other way.
    """
    joints = dict(joints)
    for prim in gears:
        if not value(prim, "physics:jointEnabled", True):
            continue
        gear, stage = _read(prim, units), prim.GetStage()
        ends = [joints.get(path) for path in (gear.first, gear.second)]
        if any(joint is None or len(joint.axes) != 1 for joint in ends) or not gear.gearing:
            warn_once(
                f"{gear.path} couples no two joints of one axis each that are simulated ({gear.first or 'none'}, "
                f"{gear.second or 'none'}), so these move independently. Name them, and give a ratio other than 0."
            )
            continue
        first, second = ends
        if first is None or second is None:
            continue
        gearing = gear.gearing * _direction(first, gear.bodies[0]) * _direction(second, gear.bodies[1])
        if gear.is_rack:
            gearing *= _side(_placed(first, stage, cache, units), _placed(second, stage, cache, units))
        if second.mimic is None and not _follows(first, second, joints):
            joints[second.path] = replace(second, mimic=Mimic(first.path, gearing, None))
        elif first.mimic is None and not _follows(second, first, joints):
            joints[first.path] = replace(first, mimic=Mimic(second.path, 1.0 / gearing, None))
        else:
            warn_once(
                f"{gear.path}: both of its joints follow others already, so it has no effect. Author gears from the "
                "driven one on, without a loop."
            )
    return joints


def _follows(joint: Joint, other: Joint, joints: Mapping[str, Joint]) -> bool:
    """Return whether a joint follows another, perhaps through more."""
    found: Joint | None = joint
    for _ in joints:
        if found is None or found is other:
            break
        found = joints.get(found.mimic.leader) if found.mimic is not None else None
    return found is not None and found.path == other.path


def _direction(joint: Joint, body: str) -> float:
    return -1.0 if body == joint.body0 != joint.body1 else 1.0


def _placed(joint: Joint, stage: Usd.Stage, cache: UsdGeom.XformCache, units: Units) -> tuple[np.ndarray, np.ndarray]:
    """Return where a joint is in the world (3,) [m], and the direction (3,) of its axis."""
    frame = np.asarray(joint.frame0)
    position, axis = frame[:3], rotated(frame[3:], joint.axes[0].direction)
    if joint.body0 != STATIC:
        body = stage.GetPrimAtPath(joint.body0)
        pose = rigid_pose(np.array(cache.GetLocalToWorldTransform(body)), units.meters)
        position, axis = rotated(pose[3:], position) + pose[:3], rotated(pose[3:], axis)
    return position, axis


def _side(pinion: tuple[np.ndarray, np.ndarray], rack: tuple[np.ndarray, np.ndarray]) -> float:
    """Return 1 where the rim of a pinion that turns forward goes along the rack's axis, else -1, as in PhysX."""
    rim = np.cross(pinion[1], rack[0] - pinion[0])
    return -1.0 if rim @ rack[1] < -1e-6 * np.linalg.norm(rim) else 1.0


def _read(prim: Usd.Prim, units: Units) -> _Gear:
    """Read a gear, whose second body turns the other way, or a rack, whose ratio is degrees per unit of length."""
    path, degree, bodies = str(prim.GetPath()), np.pi / 180.0, coupled_bodies(prim)
    if str(prim.GetTypeName()) == GEAR:
        ratio = finite(value(prim, "physics:gearRatio", 1.0), 1.0)
        return _Gear(path, _target(prim, "physics:hinge0"), _target(prim, "physics:hinge1"), -ratio, bodies, False)
    ratio = finite(value(prim, "physics:ratio", 1.0), 1.0)
    gearing = units.meters / (ratio * degree) if ratio else 0.0
    return _Gear(path, _target(prim, "physics:hinge"), _target(prim, "physics:prismatic"), gearing, bodies, True)


def _target(prim: Usd.Prim, name: str) -> str:
    relation = prim.GetRelationship(name)
    targets = relation.GetTargets() if relation else []
    return str(targets[0]) if targets else ""
