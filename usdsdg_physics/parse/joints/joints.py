"""Read joints: UsdPhysics joints with their limits, drives and states, PhysxJointAPI, PhysxMimicJointAPI."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.errors import warn_once
from usdsdg.stage.poses.rotations import compose, decompose
from usdsdg_physics.parse.attributes import authored, finite, has_api, value, warn_if_varying, written_value
from usdsdg_physics.parse.colliders import frame_from_prim
from usdsdg_physics.parse.simulation_owners import has_scene
from usdsdg_physics.parse.units import Units
from usdsdg_physics.scene.records import STATIC, Axis, Drive, Joint, JointKind, Mimic, Vec3

_DIRECTIONS: dict[str, Vec3] = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
# From body 0 swing before twist, as in PhysX: the angle in the middle reaches no more than 90 degrees.
_D6_AXES = ("transX", "transY", "transZ", "rotY", "rotZ", "rotX")
_MIMIC = "PhysxMimicJointAPI:"
_DISTANCE = "physxPhysicsDistanceJoint"
_DISTANCES = ("physics:minDistance", "physics:maxDistance")
_ROPE = "PhysicsLimitAPI:distance"
_SUPPORTED = ("Fixed", "Revolute", "Prismatic", "Spherical", "Distance", "")


def read_joint(prim: Usd.Prim, cache: UsdGeom.XformCache, units: Units) -> Joint | None:
    """Read a joint that is enabled; None, with a warning, for one that is not between two bodies or a body and another.

    Its type must be one of UsdPhysics; see `is_supported`.
    """
    first, second = _end(prim, 0, cache, units), _end(prim, 1, cache, units)
    if first is None or second is None:
        return None
    (body0, frame0), (body1, frame1) = first, second
    if body0 == body1:
        warn_once(
            f"{prim.GetPath()}: a joint needs two different bodies, and at least one that is rigid, so it is left out. "
            "Author physics:body0 and physics:body1."
        )
        return None
    axes = _read_axes(prim, units)
    return Joint(
        path=str(prim.GetPath()),
        kind=_kind(prim, axes),
        body0=body0,
        body1=body1,
        frame0=frame0,
        frame1=frame1,
        axes=axes,
        in_articulation=not value(prim, "physics:excludeFromArticulation", False),
        break_force=_positive(value(prim, "physics:breakForce", None), _force(units, angular=False)),
        break_torque=_positive(value(prim, "physics:breakTorque", None), _force(units, angular=True)),
        mimic=_read_mimic(prim, axes, units),
        distance=_read_distance(prim, units),
        spring=_read_spring(prim, units),
    )


def is_supported(prim: Usd.Prim) -> bool:
    """Return whether the type of a joint is one that can be simulated."""
    return _type(prim) in _SUPPORTED


def free_axes(prim: Usd.Prim) -> frozenset[str]:
    """Return the instances that drives and states of a joint may have; none for a ball without limits."""
    kind = _type(prim)
    if kind in ("Revolute", "Prismatic"):
        return frozenset({"angular" if kind == "Revolute" else "linear"})
    if kind == "Spherical":
        limited = any(finite(value(prim, f"physics:coneAngle{number}Limit", -1.0), -1.0) >= 0.0 for number in (0, 1))
        return frozenset(_D6_AXES[3:]) if limited else frozenset()
    locked = (name for name in _D6_AXES if not _is_free(*_d6_limits(prim, name)))
    return frozenset() if kind or has_api(prim, _ROPE) else frozenset(_D6_AXES).difference(locked)


def joint_bodies(prim: Usd.Prim) -> list[str]:
    """Return the paths of the rigid bodies that a joint names, whatever its type."""
    owners = (_owner(prim.GetStage().GetPrimAtPath(path)) for path in _targets(prim))
    return [str(owner.GetPath()) for owner in owners if owner]


def read_drive(prim: Usd.Prim, name: str, angular: bool, units: Units) -> Drive | None:
    """Read the drive of an axis, `name` being its instance; None if there is none."""
    if not has_api(prim, f"PhysicsDriveAPI:{name}"):
        return None
    found = f"drive:{name}:physics"
    warn_if_varying(prim, f"{found}:targetPosition", f"{found}:targetVelocity")
    acceleration = str(value(prim, f"{found}:type", "force")) == "acceleration"
    unit = np.pi / 180.0 if angular else units.meters
    # Per degree, or unit of length; an acceleration drive has no mass in its units.
    strength = (1.0 if acceleration else units.inertia if angular else units.kilograms) * (180.0 / np.pi) ** angular
    force = unit if acceleration else _force(units, angular=angular)
    return Drive(
        stiffness=_gain(prim, f"{found}:stiffness") * strength,
        damping=_gain(prim, f"{found}:damping") * strength,
        target=finite(value(prim, f"{found}:targetPosition", 0.0), 0.0) * unit,
        target_velocity=finite(value(prim, f"{found}:targetVelocity", 0.0), 0.0) * unit,
        max_force=_positive(value(prim, f"{found}:maxForce", None), force),
        acceleration=acceleration,
    )


def _gain(prim: Usd.Prim, name: str) -> float:
    """Return the stiffness or damping of a drive, 0 where it is no number; name one that is below."""
    number = finite(value(prim, name, 0.0), 0.0)
    if number < 0.0:
        warn_once(f"{prim.GetPath()}: {name} is {number:g}, so it counts as 0. Set a positive number, or 0.")
    return max(0.0, number)


def _type(prim: Usd.Prim) -> str:
    return str(prim.GetTypeName()).removeprefix("Physics").removesuffix("Joint")


def _kind(prim: Usd.Prim, axes: tuple[Axis, ...]) -> JointKind:
    if _type(prim) == "Distance" or _is_rope(prim):
        return "distance"
    if not axes:
        return "ball" if _type(prim) == "Spherical" else "fixed"
    if len(axes) == 1:
        return "revolute" if axes[0].angular else "prismatic"
    free = all(axis == Axis(axis.name, axis.angular, axis.direction, instance=axis.name) for axis in axes)
    return "ball" if free and [axis.name for axis in axes] == list(_D6_AXES[3:]) else "d6"


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


def _end(prim: Usd.Prim, number: int, cache: UsdGeom.XformCache, units: Units) -> tuple[str, tuple[float, ...]] | None:
    """Return the body at an end of a joint, and the joint's frame in its frame [m]."""
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
    if rotation is None or not rotation.GetLength() > 0:
        return 0.0, 0.0, 0.0, 1.0
    return _components(rotation.GetNormalized())


def _is_rope(prim: Usd.Prim) -> bool:
    """Return whether a joint without a type of its own limits the distance of its ends, and nothing else."""
    if _type(prim) or not has_api(prim, _ROPE):
        return False
    found = [name for name in prim.GetAppliedSchemas() if name.startswith(("PhysicsLimitAPI:", "PhysicsDriveAPI:"))]
    if found == [_ROPE]:
        return True
    warn_once(
        f"{prim.GetPath()}: limit:distance has no effect beside {', '.join(sorted({*found} - {_ROPE}))}: a joint that "
        "limits the distance of its ends has no other limits and drives. Author a PhysicsDistanceJoint beside it."
    )
    return False


def _read_axes(prim: Usd.Prim, units: Units) -> tuple[Axis, ...]:
    kind = _type(prim)
    if _is_rope(prim):
        return ()
    if kind in ("Revolute", "Prismatic"):
        letter = _axis_letter(prim)
        lower, upper = (value(prim, f"physics:{end}Limit", None) for end in ("lower", "upper"))
        angular = kind == "Revolute"
        name = ("rot" if angular else "trans") + letter
        return (_axis(prim, name, "angular" if angular else "linear", lower, upper, units),)
    if kind == "Spherical":
        return _spherical_axes(prim, units)
    return () if kind in ("Fixed", "Distance") else _d6_axes(prim, units)


def _axis_letter(prim: Usd.Prim) -> str:
    """Return the axis of a joint, "X", "Y" or "Z"; "X", with a warning, of any other word."""
    letter = str(value(prim, "physics:axis", "X"))
    if letter in ("X", "Y", "Z"):
        return letter
    warn_once(f"{prim.GetPath()}: physics:axis {letter!r} is none of X, Y, Z; X is used. Correct it.")
    return "X"


def _d6_axes(prim: Usd.Prim, units: Units) -> tuple[Axis, ...]:
    limits = {name: _d6_limits(prim, name) for name in _D6_AXES}
    return tuple(_axis(prim, name, name, *ends, units) for name, ends in limits.items() if _is_free(*ends))


def _d6_limits(prim: Usd.Prim, name: str) -> tuple[float | None, float | None]:
    if not has_api(prim, f"PhysicsLimitAPI:{name}"):
        return None, None
    return value(prim, f"limit:{name}:physics:low", None), value(prim, f"limit:{name}:physics:high", None)


def _is_free(lower: float | None, upper: float | None) -> bool:
    """Return whether an axis is free; limits that leave nothing between them lock it.

    As in PhysX those that are equal hold it at that number, so that it must move there.
    """
    return lower is None or upper is None or lower < upper or lower == upper != 0.0


def _spherical_axes(prim: Usd.Prim, units: Units) -> tuple[Axis, ...]:
    """Return the axes of a spherical joint with a cone limit, twist last; none of one without."""
    cone = [finite(value(prim, f"physics:coneAngle{number}Limit", -1.0), -1.0) for number in (0, 1)]
    if max(cone) < 0.0:
        return ()
    twist = "XYZ".index(_axis_letter(prim))
    swings = ("XYZ"[(twist + 1) % 3], "XYZ"[(twist + 2) % 3])
    limits = {f"rot{letter}": (-angle, angle) if angle >= 0.0 else (None, None) for letter, angle in zip(swings, cone)}
    limits[f"rot{'XYZ'[twist]}"] = None, None
    # As in PhysX it has no drive.
    return tuple(replace(_axis(prim, name, name, *ends, units), drive=None) for name, ends in limits.items())


def _axis(prim: Usd.Prim, name: str, instance: str, lower: float | None, upper: float | None, units: Units) -> Axis:
    """Read an axis; `instance` is the name that its drive, state and friction have in the schemas."""
    angular = name.startswith("rot")
    unit = np.pi / 180.0 if angular else units.meters
    strength = units.inertia if angular else units.kilograms
    low, high = float("-inf"), float("inf")
    if lower is not None and np.isfinite(lower):
        low = float(lower) * unit
    if upper is not None and np.isfinite(upper):
        high = float(upper) * unit
    if low > high:
        unit_name = "degrees" if angular else "units"
        warn_once(
            f"{prim.GetPath()}: the lower limit of {name}, {lower:g} {unit_name}, is above the upper one, {upper:g}, "
            "so the joint is held at the lower one. Exchange them."
        )
    own = f"physxJointAxis:{instance}"
    speed = authored(prim, f"{own}:maxJointVelocity")
    speed = authored(prim, "physxJoint:maxJointVelocity") if speed is None else speed
    armature = authored(prim, f"{own}:armature")
    armature = value(prim, "physxJoint:armature", 0.0) if armature is None else armature
    return Axis(
        name=name,
        angular=angular,
        direction=_DIRECTIONS[name[-1]],
        lower=low,
        upper=max(low, high),
        drive=read_drive(prim, instance, angular, units),
        armature=max(0.0, finite(armature, 0.0)) * strength,
        friction=max(0.0, finite(value(prim, "physxJoint:jointFriction", 0.0), 0.0)),
        static_friction=_friction(prim, f"{own}:staticFrictionEffort") * _force(units, angular=angular),
        damping=_friction(prim, f"{own}:viscousFrictionCoefficient") * strength * (180.0 / np.pi) ** angular,
        max_velocity=_positive(speed, unit),
        position=_state(prim, instance, "position", unit),
        velocity=_state(prim, instance, "velocity", unit),
        instance=instance,
        has_state=has_api(prim, f"PhysicsJointStateAPI:{instance}"),
    )


def _friction(prim: Usd.Prim, name: str) -> float:
    return max(0.0, finite(value(prim, name, 0.0), 0.0))


def _state(prim: Usd.Prim, instance: str, name: str, unit: float) -> float | None:
    if not has_api(prim, f"PhysicsJointStateAPI:{instance}"):
        return None
    attribute = f"state:{instance}:physics:{name}"
    found = written_value(prim, attribute, None) if prim.GetAttribute(attribute).HasAuthoredValue() else None
    return None if found is None or not np.isfinite(found) else float(found) * unit


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
        leads = np.pi / 180.0 if _type(leader) == "Revolute" else units.meters
        gearing = finite(value(prim, f"{prefix}:gearing", 1.0), 1.0)
        offset = finite(value(prim, f"{prefix}:offset", 0.0), 0.0)
        return Mimic(str(leader.GetPath()), -gearing * float(follows / leads), -offset * float(units_of))
    return None


def _read_distance(prim: Usd.Prim, units: Units) -> tuple[float, float]:
    names = ("limit:distance:physics:low", "limit:distance:physics:high") if _is_rope(prim) else _DISTANCES
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


def _force(units: Units, *, angular: bool) -> float:
    """Return the factor to N or N m."""
    return units.kilograms * units.meters ** (2 if angular else 1)


def _positive(number: float | None, unit: float) -> float:
    """Return a limit in SI units; infinite where it is not a positive number."""
    return float("inf") if number is None or not np.isfinite(number) or number < 0 else float(number) * unit
