"""Read the axes of joints: limits, drives, states, and PhysxJointAPI."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pxr import Usd

from usdsdg.errors import warn_once
from usdsdg_physics.parse.attributes import authored, finite, has_api, value, warn_if_varying, written_value
from usdsdg_physics.parse.joints.joint_types import ROPE, is_rope, type_of
from usdsdg_physics.parse.units import Units
from usdsdg_physics.scene.records import Axis, Drive, Vec3

_DIRECTIONS: dict[str, Vec3] = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
# From body 0 swing before twist, as in PhysX: the angle in the middle reaches no more than 90 degrees.
D6_AXES = ("transX", "transY", "transZ", "rotY", "rotZ", "rotX")


def read_axes(prim: Usd.Prim, units: Units) -> tuple[Axis, ...]:
    """Return the axes along and about which a joint leaves its bodies free; none of one that is fixed, or a rope."""
    kind = type_of(prim)
    if is_rope(prim):
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


def free_axes(prim: Usd.Prim) -> frozenset[str]:
    """Return the instances that drives and states of a joint may have; none for a ball without limits."""
    kind = type_of(prim)
    if kind in ("Revolute", "Prismatic"):
        return frozenset({"angular" if kind == "Revolute" else "linear"})
    if kind == "Spherical":
        limited = any(finite(value(prim, f"physics:coneAngle{number}Limit", -1.0), -1.0) >= 0.0 for number in (0, 1))
        return frozenset(D6_AXES[3:]) if limited else frozenset()
    locked = (name for name in D6_AXES if not _is_free(*_d6_limits(prim, name)))
    return frozenset() if kind or has_api(prim, ROPE) else frozenset(D6_AXES).difference(locked)


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
    force = units.torque if angular else units.force
    return Drive(
        stiffness=_gain(prim, f"{found}:stiffness") * strength,
        damping=_gain(prim, f"{found}:damping") * strength,
        target=_target(prim, f"{found}:targetPosition") * unit,
        target_velocity=_target(prim, f"{found}:targetVelocity") * unit,
        max_force=limit_in_si(value(prim, f"{found}:maxForce", None), force),
        acceleration=acceleration,
    )


def _gain(prim: Usd.Prim, name: str) -> float:
    """Return the stiffness or damping of a drive, 0 where it is no finite number; name that, and one that is below."""
    number = _target(prim, name)
    if number < 0.0:
        warn_once(f"{prim.GetPath()}: {name} is {number:g}, so it counts as 0. Set a positive number, or 0.")
    return max(0.0, number)


def _target(prim: Usd.Prim, name: str) -> float:
    """Return a number of a drive; name one that is not finite, which counts as 0."""
    number = float(value(prim, name, 0.0))
    if not np.isfinite(number):
        warn_once(f"{prim.GetPath()}: {name} is {number:g}, so it counts as 0. Set a finite number.")
    return finite(number, 0.0)


def _axis_letter(prim: Usd.Prim) -> str:
    """Return the axis of a joint, "X", "Y" or "Z"; "X", with a warning, of any other word."""
    letter = str(value(prim, "physics:axis", "X"))
    if letter in ("X", "Y", "Z"):
        return letter
    warn_once(f"{prim.GetPath()}: physics:axis {letter!r} is none of X, Y, Z; X is used. Correct it.")
    return "X"


def _d6_axes(prim: Usd.Prim, units: Units) -> tuple[Axis, ...]:
    limits = {name: _d6_limits(prim, name) for name in D6_AXES}
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
        static_friction=_friction(prim, f"{own}:staticFrictionEffort") * (units.torque if angular else units.force),
        damping=_friction(prim, f"{own}:viscousFrictionCoefficient") * strength * (180.0 / np.pi) ** angular,
        max_velocity=limit_in_si(speed, unit),
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


def limit_in_si(number: float | None, unit: float) -> float:
    """Return a limit in SI units; infinite where it is not a positive number."""
    return float("inf") if number is None or not np.isfinite(number) or number < 0 else float(number) * unit
