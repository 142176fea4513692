"""What the attributes of a UsdLux light say of its shape, and of where its light goes."""

import math
from typing import NamedTuple

import numpy as np
from pxr import Usd

from usdsdg import errors
from usdsdg_render.lights.light_values import light_number, light_value
from usdsdg_render.scene import structs
from usdsdg_render.usd.prim_kinds import LIGHT_TYPES

Triple = tuple[float, float, float]

_FULL = (1.0, 1.0, 1.0)
# Which of its half extents a light keeps that is treated as a point or a line.
_TREATED_AS = {
    structs.LIGHT_SPHERE: ("treatAsPoint", (0.0, 0.0, 0.0)),
    structs.LIGHT_CYLINDER: ("treatAsLine", (1.0, 0.0, 0.0)),
}


class LightInputs(NamedTuple):
    """The inputs of a light beside those of its brightness and color, which change more often."""

    kind: int
    half: Triple  # half extents along x, y, z in its own frame [stage units]; distant lights have none
    kept: Triple  # the factors of these that are drawn
    normalize: bool
    cos_angle: float
    shaping_cos: float
    shaping_softness: float
    shaping_focus: float
    focus_tint: Triple
    diffuse: float
    specular: float
    visible: bool


def read_inputs(prim: Usd.Prim) -> LightInputs:
    """Read the inputs of a light; warn of what cannot be used."""
    kind = LIGHT_TYPES[str(prim.GetTypeName())]
    visible = prim.GetAttribute("visibleInPrimaryRay")
    # Unauthored inputs mean no shaping, whatever the schema's fallback angle.
    cone = light_number(prim, "shaping:cone:angle", 180.0)
    softness = min(max(light_number(prim, "shaping:cone:softness", 0.0), 0.0), 1.0)
    focus = max(light_number(prim, "shaping:focus", 0.0), 0.0)
    tint = np.array(light_value(prim, "shaping:focusTint", (0.0, 0.0, 0.0)), float)
    diffuse, specular = (max(light_number(prim, name, 1.0), 0.0) for name in ("diffuse", "specular"))
    warn_of_ignored(prim)
    return LightInputs(
        kind,
        _half_extents(prim, kind),
        _kept(prim, kind),
        bool(light_value(prim, "normalize", False)),
        _cos_angle(prim) if kind == structs.LIGHT_DISTANT else 0.0,
        math.cos(math.radians(min(max(cone, 0.0), 180.0))),
        softness,
        focus,
        tuple(np.clip(np.nan_to_num(tint), 0.0, None).tolist()),
        diffuse,
        specular,
        not (visible and visible.Get() is False),
    )


def warn_of_ignored(prim: Usd.Prim) -> None:
    """Warn of light filters, and of inputs that are connected to others, from which no value is read."""
    connected = [
        attribute.GetName()
        for attribute in prim.GetAuthoredAttributes()
        if attribute.HasAuthoredConnections() and attribute.GetName().startswith("inputs:")
    ]
    if connected:
        errors.warn_once(
            f"{prim.GetPath()}: connections of lights are not supported: of {', '.join(connected)} the light's own "
            f"value is used. Author it there, and remove the connection."
        )
    filters = prim.GetRelationship("light:filters")
    if filters and filters.HasAuthoredTargets():
        errors.warn_once(f"{prim.GetPath()}: light:filters are not supported and are ignored. Remove them.")


def _half_extents(prim: Usd.Prim, kind: int) -> Triple:
    if kind == structs.LIGHT_DISTANT:
        return 0.0, 0.0, 0.0
    if kind == structs.LIGHT_RECT:
        return _size(prim, "width", 1.0) / 2.0, _size(prim, "height", 1.0) / 2.0, 0.0
    radius = _size(prim, "radius", 0.5)
    return (_size(prim, "length", 1.0) / 2.0 if kind == structs.LIGHT_CYLINDER else radius), radius, radius


def _size(prim: Usd.Prim, name: str, default: float) -> float:
    value = light_number(prim, name, default)
    if value >= 0.0:
        return value
    errors.warn_once(f"{prim.GetPath()}: inputs:{name} = {value} is no size; 0 is used. Author a value > 0.")
    return 0.0


def _kept(prim: Usd.Prim, kind: int) -> Triple:
    hint, kept = _TREATED_AS.get(kind, ("", _FULL))
    return kept if hint and prim.HasAttribute(hint) and prim.GetAttribute(hint).Get() else _FULL


def _cos_angle(prim: Usd.Prim) -> float:
    angle = min(max(light_number(prim, "angle", 0.53), 0.0), 360.0)
    return math.cos(math.radians(angle) / 2.0)
