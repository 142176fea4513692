"""Read joints of UsdPhysics, and PhysxMimicJointAPI."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.errors import warn_once
from usdsdg_physics.parse.attributes import finite, has_api, value
from usdsdg_physics.parse.joints.joint_axes import D6_AXES, limit_in_si, read_axes
from usdsdg_physics.parse.joints.joint_ends import read_end
from usdsdg_physics.parse.joints.joint_types import is_rope, type_of
from usdsdg_physics.parse.units import Units
from usdsdg_physics.scene.records import Axis, Joint, JointKind, Mimic

_MIMIC = "PhysxMimicJointAPI:"
_DISTANCE = "physxPhysicsDistanceJoint"
_DISTANCES = ("physics:minDistance", "physics:maxDistance")


def read_joint(prim: Usd.Prim, cache: UsdGeom.XformCache, units: Units) -> Joint | None:
    """Read a joint that is enabled; None, with a warning, for one that is not between two bodies or a body and another.

    Its type must be one of UsdPhysics; see `is_supported`.
    """
    first, second = read_end(prim, 0, cache, units), read_end(prim, 1, cache, units)
    if first is None or second is None:
        return None
    (body0, frame0), (body1, frame1) = first, second
    if body0 == body1:
        warn_once(
            f"{prim.GetPath()}: a joint needs two different bodies, and at least one that is rigid, so it is left out. "
            "Author physics:body0 and physics:body1."
        )
        return None
    axes = read_axes(prim, units)
    return Joint(
        path=str(prim.GetPath()),
        kind=_kind(prim, axes),
        body0=body0,
        body1=body1,
        frame0=frame0,
        frame1=frame1,
        axes=axes,
        in_articulation=not value(prim, "physics:excludeFromArticulation", False),
        break_force=limit_in_si(value(prim, "physics:breakForce", None), units.force),
        break_torque=limit_in_si(value(prim, "physics:breakTorque", None), units.torque),
        mimic=_read_mimic(prim, axes, units),
        distance=_read_distance(prim, units),
        spring=_read_spring(prim, units),
    )


def _kind(prim: Usd.Prim, axes: tuple[Axis, ...]) -> JointKind:
    if type_of(prim) == "Distance" or is_rope(prim):
        return "distance"
    if not axes:
        return "ball" if type_of(prim) == "Spherical" else "fixed"
    if len(axes) == 1:
        return "revolute" if axes[0].angular else "prismatic"
    free = all(axis == Axis(axis.name, axis.angular, axis.direction, instance=axis.name) for axis in axes)
    return "ball" if free and [axis.name for axis in axes] == list(D6_AXES[3:]) else "d6"


def _read_mimic(prim: Usd.Prim, axes: Iterable[Axis], units: Units) -> Mimic | None:
    """Read whom a joint follows; gearing and offset are between degrees and stage units."""
    for schema in prim.GetAppliedSchemas():
        if not schema.startswith(_MIMIC):
            continue
        prefix = f"physxMimicJoint:{schema.removeprefix(_MIMIC)}"
        relation = prim.GetRelationship(f"{prefix}:referenceJoint")
        leader = prim.GetStage().GetPrimAtPath(relation.GetTargets()[0]) if relation and relation.GetTargets() else None
        axis = next(iter(axes), None)
        if not leader or axis is None:
            warn_once(f"{prim.GetPath()}: {prefix}:referenceJoint names no joint, so it follows none. Name one.")
            continue
        follows = units_of = np.pi / 180.0 if axis.angular else units.meters
        leads = np.pi / 180.0 if type_of(leader) == "Revolute" else units.meters
        gearing = finite(value(prim, f"{prefix}:gearing", 1.0), 1.0)
        offset = finite(value(prim, f"{prefix}:offset", 0.0), 0.0)
        return Mimic(str(leader.GetPath()), -gearing * float(follows / leads), -offset * float(units_of))
    return None


def _read_distance(prim: Usd.Prim, units: Units) -> tuple[float, float]:
    names = ("limit:distance:physics:low", "limit:distance:physics:high") if is_rope(prim) else _DISTANCES
    least, most = (finite(value(prim, name, -1.0), -1.0) for name in names)
    if 0.0 <= most < least:
        warn_once(
            f"{prim.GetPath()}: {names[0]} is {least:g}, which is above {names[1]}, {most:g}, so the distance is the "
            "former. Exchange them."
        )
        most = least
    return max(0.0, least) * units.meters, most * units.meters if most >= 0.0 else float("inf")


def _read_spring(prim: Usd.Prim, units: Units) -> tuple[float, float] | None:
    if not has_api(prim, "PhysxPhysicsDistanceJointAPI") or not value(prim, f"{_DISTANCE}:springEnabled", False):
        return None
    stiffness, damping = (
        finite(value(prim, f"{_DISTANCE}:spring{name}", 0.0), 0.0) for name in ("Stiffness", "Damping")
    )
    return max(0.0, stiffness) * units.kilograms, max(0.0, damping) * units.kilograms
