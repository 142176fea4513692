"""Read attributes by name, so that it does not matter which schema plugins are registered."""

import math
from typing import Any

from pxr import Usd

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


def value(prim: Usd.Prim, name: str, default: Any) -> Any:
    """Return an attribute's value at the time of the context, its schema's fallback, or `default` without either."""
    found = prim.GetAttribute(name).Get(current_time())
    return default if found is None else found


def written_value(prim: Usd.Prim, name: str, default: Any) -> Any:
    """Return `value` of an attribute that steps write: its default value, beside which a script may record samples."""
    attribute = prim.GetAttribute(name)
    found = attribute.Get(default_or_current_time(attribute)) if attribute else None
    return default if found is None else found


def authored(prim: Usd.Prim, name: str) -> Any | None:
    """Return an attribute's authored value; None where there is at most a schema's fallback."""
    attribute = prim.GetAttribute(name)
    return current_value(attribute) if attribute and attribute.HasAuthoredValue() else None


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
