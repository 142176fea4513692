"""Attributes read by name, so that it does not matter which schema plugins are registered."""

from __future__ import annotations

import math
from typing import Any

from pxr import Usd

RIGID_BODY = "PhysicsRigidBodyAPI"
COLLIDER = "PhysicsCollisionAPI"
MASS = "PhysicsMassAPI"


def value(prim: Usd.Prim, name: str, default: Any) -> Any:
    """The attribute's value at the default time, its schema's fallback, or `default` when neither exists."""
    found = prim.GetAttribute(name).Get()
    return default if found is None else found


def authored(prim: Usd.Prim, name: str) -> Any | None:
    """The value that somebody gave, None for a mere fallback."""
    attribute = prim.GetAttribute(name)
    return attribute.Get() if attribute and attribute.HasAuthoredValue() else None


def finite(number: Any, default: float) -> float:
    """A float; PhysX writes "use the default" as ±inf."""
    return default if number is None or not math.isfinite(number) else float(number)


def has_api(prim: Usd.Prim, name: str) -> bool:
    """Whether an applied schema of this name is listed, registered or not."""
    return name in prim.GetAppliedSchemas()
