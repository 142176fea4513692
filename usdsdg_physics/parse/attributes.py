"""Read attributes by name, so that it does not matter which schema plugins are registered."""

import math
from typing import Any

from pxr import Gf, Usd

from usdsdg.errors import warn_once
from usdsdg.stage.time_code import current_time, current_value, default_or_current_time

RIGID_BODY = "PhysicsRigidBodyAPI"
COLLISION = "PhysicsCollisionAPI"
MASS = "PhysicsMassAPI"
MATERIAL = "PhysicsMaterialAPI"
FORCE = "PhysxForceAPI"
TRIGGER = "PhysxTriggerAPI"
TRIGGER_STATE = "PhysxTriggerStateAPI"
CONTACT_REPORT = "PhysxContactReportAPI"
SURFACE_VELOCITY = "PhysxSurfaceVelocityAPI"

_NUMBERS = (int, float)
_VECTORS = (Gf.Vec3f, Gf.Vec3d, Gf.Vec3h, Gf.Vec3i, Gf.Vec2f, Gf.Vec2d)
_QUATERNIONS = (Gf.Quatf, Gf.Quatd, Gf.Quath)


def value(prim: Usd.Prim, name: str, default: Any) -> Any:
    """Return an attribute's value at the time of the context, its schema's fallback, or `default` without either."""
    attribute = prim.GetAttribute(name)
    found = attribute.Get(current_time())
    return default if found is None or not _is_of_its_type(attribute, found, default) else found


def written_value(prim: Usd.Prim, name: str, default: Any) -> Any:
    """Return `value` of an attribute that steps write: its default value, beside which a script may record samples."""
    attribute = prim.GetAttribute(name)
    found = attribute.Get(default_or_current_time(attribute)) if attribute else None
    return default if found is None or not _is_of_its_type(attribute, found, default) else found


def authored(prim: Usd.Prim, name: str) -> Any | None:
    """Return an attribute's authored value; None where there is at most a schema's fallback."""
    attribute = prim.GetAttribute(name)
    found = current_value(attribute) if attribute and attribute.HasAuthoredValue() else None
    return found if found is not None and _is_of_its_type(attribute, found) else None


def _is_of_its_type(attribute: Usd.Attribute, found: Any, default: Any = None) -> bool:
    """Return whether a value has the type that its attribute has by its schema; name one that has not.

    A file may declare an attribute with another type than the schema: USD has the schema's type, and the file's value.

    Args:
        default: of that type too, where the schema is not applied; None: not known.
    """
    if default is not None and _are_alike(found, default):
        return True  # at once, since asking for the type takes longer than reading the value
    if not isinstance(default, _NUMBERS) and _are_alike(found, attribute.GetTypeName().defaultValue):
        return True
    warn_once(
        f"{attribute.GetPrim().GetPath()}: {attribute.GetName()} is {found!r}, which has another type than that "
        "attribute, so it counts as not given. Author it with the type of its schema."
    )
    return False


def _are_alike(found: Any, usual: Any) -> bool:
    """Return whether both are numbers, vectors of as many, quaternions, or of the same other type."""
    if isinstance(found, _NUMBERS):
        return isinstance(usual, _NUMBERS)
    if isinstance(found, _VECTORS):  # of any precision
        return isinstance(usual, (*_VECTORS, tuple)) and len(found) == len(usual)
    if isinstance(found, _QUATERNIONS):
        return isinstance(usual, _QUATERNIONS)
    return type(found) is type(usual)


def warn_if_varying(prim: Usd.Prim, *names: str) -> None:
    """Warn of attributes that vary with time, which physics reads once."""
    attributes = filter(None, map(prim.GetAttribute, names))
    if varying := [each.GetName() for each in attributes if each.ValueMightBeTimeVarying()]:
        warn_once(
            f"{prim.GetPath()}: physics does not follow time samples and splines of {', '.join(varying)}, which keeps "
            "the value that it has when the simulation begins. Remove them, and set it from a script while physics "
            "plays."
        )


def finite(number: Any, default: float) -> float:
    """Return a number as a float, or `default` for None and for ±inf, which PhysX writes for "use the default"."""
    return default if number is None or not math.isfinite(number) else float(number)


def positive(prim: Usd.Prim, name: str) -> float:
    """Return a mass or density, 0 for none; name one that nothing can have."""
    number = value(prim, name, 0.0)
    if number is not None and (number != number or -math.inf < number < 0.0):
        warn_once(f"{prim.GetPath()}: {name} is {number:g}, so it counts as not given. Set a positive number, or 0.")
    return max(0.0, finite(number, 0.0))


def has_api(prim: Usd.Prim, name: str) -> bool:
    """Return whether an applied schema of this name is listed, registered or not."""
    return name in prim.GetAppliedSchemas()
