"""Read gears and racks: joints of PhysX that couple the motion of two other joints."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np
from pxr import Usd

from usdsdg.errors import warn_once
from usdsdg_physics.parse.attributes import finite, value
from usdsdg_physics.parse.units import Units
from usdsdg_physics.scene.records import Joint, Mimic

GEAR, RACK = "PhysxPhysicsGearJoint", "PhysxPhysicsRackAndPinionJoint"


@dataclass(frozen=True)
class _Gear:
    path: str
    first: str  # joint
    second: str
    gearing: float  # of the position of the second by that of the first, in SI units


def is_gear(prim: Usd.Prim) -> bool:
    """Return whether a joint couples two others."""
    return str(prim.GetTypeName()) in (GEAR, RACK)


def couple(gears: Collection[Usd.Prim], joints: Mapping[str, Joint], units: Units) -> dict[str, Joint]:
    """Return the joints, of which those in gear follow others from where they are."""
    joints = dict(joints)
    for gear in (_read(prim, units) for prim in gears if value(prim, "physics:jointEnabled", True)):
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
        if second.mimic is None and not _follows(first, second, joints):
            joints[second.path] = replace(second, mimic=Mimic(first.path, gear.gearing, None))
        elif first.mimic is None and not _follows(second, first, joints):
            joints[first.path] = replace(first, mimic=Mimic(second.path, 1.0 / gear.gearing, None))
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


def _read(prim: Usd.Prim, units: Units) -> _Gear:
    """Read a gear, whose second joint turns the other way, or a rack, whose ratio is degrees per unit of length."""
    path, degree = str(prim.GetPath()), np.pi / 180.0
    if str(prim.GetTypeName()) == GEAR:
        ratio = finite(value(prim, "physics:gearRatio", 1.0), 1.0)
        return _Gear(path, _target(prim, "physics:hinge0"), _target(prim, "physics:hinge1"), -ratio)
    ratio = finite(value(prim, "physics:ratio", 1.0), 1.0)
    gearing = units.meters / (ratio * degree) if ratio else 0.0
    return _Gear(path, _target(prim, "physics:hinge"), _target(prim, "physics:prismatic"), gearing)


def _target(prim: Usd.Prim, name: str) -> str:
    relation = prim.GetRelationship(name)
    targets = relation.GetTargets() if relation else []
    return str(targets[0]) if targets else ""
