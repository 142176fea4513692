"""UsdLux lights to rows of `scene.LIGHT`, in nits and stage units.

Luminance is intensity * 2^exposure * color * temperature, and `normalize` divides it by the world-space area, as the
UsdLux schema says. Two deliberate readings:

Distant lights: intensity is the illuminance [lux] of a surface that faces the light, whether `normalize` is on or off.
UsdLux without `normalize` means nits over the light's cone, which at the fallback angle of 0.53 degrees makes 400 a
night (0.03 lux); scenes made for Omniverse author a few hundred to a few thousand and expect daylight.

Non-uniform scale: a sphere, disk or cylinder stays one, with a mean radius; its area for `normalize` is exact for disks
and to 1 % for ellipsoids and elliptic cylinders.
"""

from __future__ import annotations

import math

import numpy as np
from pxr import Usd, UsdGeom, UsdLux

from usdsdg import errors

from . import images
from .scene import (
    LIGHT,
    LIGHT_CYLINDER,
    LIGHT_DISK,
    LIGHT_DISTANT,
    LIGHT_RECT,
    LIGHT_SPHERE,
)
from .textures import srgb_to_linear

KINDS = {
    "SphereLight": LIGHT_SPHERE,
    "DistantLight": LIGHT_DISTANT,
    "RectLight": LIGHT_RECT,
    "DiskLight": LIGHT_DISK,
    "CylinderLight": LIGHT_CYLINDER,
}
DOMES = ("DomeLight", "DomeLight_1")
UNSUPPORTED = ("PortalLight", "GeometryLight", "PluginLight")

# A light without size has no area to be seen; this radius stands for it [m].
POINT_RADIUS = 1e-3
# Distant lights compete with the others by the flux through a disc of this radius [m], the size of a room: fixed, so
# that the choice of lights does not depend on where objects are.
NOMINAL_RADIUS = 5.0
# Scales that differ by less are rounding.
UNIFORM = 1e-3

_WHITE = np.array(UsdLux.BlackbodyTemperatureAsRgb(6500.0))


def light_value(prim: Usd.Prim, name: str, default):
    """Value of `inputs:<name>`, or of `<name>` as files before USD 21.02 wrote it."""
    attribute = prim.GetAttribute(f"inputs:{name}")
    if not (attribute and attribute.HasAuthoredValue()):
        old = prim.GetAttribute(name)
        if old and old.HasAuthoredValue():
            attribute = old
    value = attribute.Get() if attribute else None
    return default if value is None else value


def light_number(prim: Usd.Prim, name: str, default: float) -> float:
    """A finite number; `default` (with a warning) for NaN and infinity."""
    value = float(light_value(prim, name, default))
    if math.isfinite(value):
        return value
    errors.warn_once(f"{prim.GetPath()}: inputs:{name} = {value} is not usable; {default} is used. Correct it.")
    return default


def emitted_colour(prim: Usd.Prim, fallback_intensity: float = 1.0) -> np.ndarray | None:
    """(3,) intensity * 2^exposure * color * temperature; None (with a warning) if it is no light."""
    colour = np.array(light_value(prim, "color", (1.0, 1.0, 1.0)), np.float64)
    colour = colour * float(light_value(prim, "intensity", fallback_intensity))
    with np.errstate(over="ignore", invalid="ignore"):
        colour = colour * np.exp2(float(light_value(prim, "exposure", 0.0)))
    if light_value(prim, "enableColorTemperature", False):
        colour = colour * temperature_colour(light_number(prim, "colorTemperature", 6500.0))
    if not np.isfinite(colour).all() or (colour < 0.0).any():
        errors.warn_once(
            f"{prim.GetPath()}: intensity, exposure and color give {colour.tolist()}, which is no light; it is off. "
            f"Author finite values >= 0."
        )
        return None
    return colour


def temperature_colour(kelvin: float) -> np.ndarray:
    """(3,) linear Rec.709 of a black body, white at 6500 K as the schema asks."""
    return np.array(UsdLux.BlackbodyTemperatureAsRgb(kelvin)) / _WHITE


def read_light(prim: Usd.Prim, local_to_world: np.ndarray, metres_per_unit: float) -> np.ndarray | None:
    """One row of `scene.LIGHT`; None for a light that gives none or (with a warning) cannot be read."""
    kind = KINDS[str(prim.GetTypeName())]
    luminance = emitted_colour(prim, 50000.0 if kind == LIGHT_DISTANT else 1.0)
    axes, scale = _frame(local_to_world)
    if luminance is None or not luminance.any():
        return None
    if axes is None:
        errors.warn_once(f"{prim.GetPath()}: the light's transform is NaN or scaled to zero; it is off. Correct it.")
        return None
    row = np.zeros((), LIGHT)
    row["kind"] = kind
    row["x_axis"], row["y_axis"], row["z_axis"] = axes
    row["position"] = local_to_world[3, :3]
    _read_shaping(prim, row)
    row["diffuse"] = max(light_number(prim, "diffuse", 1.0), 0.0)
    row["specular"] = max(light_number(prim, "specular", 1.0), 0.0)
    visible = prim.GetAttribute("visibleInPrimaryRay")
    row["visible"] = 0 if visible and visible.Get() is False else 1
    _warn_of_the_rest(prim)
    with np.errstate(over="ignore", invalid="ignore"):
        if kind == LIGHT_DISTANT:
            light = _distant(prim, row, luminance, metres_per_unit)
        else:
            light = _area_light(prim, row, luminance, scale, metres_per_unit)
    if light is None or all(np.isfinite(light[name]).all() for name in LIGHT.names or ()):
        return light
    errors.warn_once(
        f"{prim.GetPath()}: the light is too bright or too large for 32-bit numbers; it is off. Correct it."
    )
    return None


def _frame(local_to_world: np.ndarray) -> tuple[np.ndarray | None, np.ndarray]:
    """Unit axes as rows (the emission axis z kept, x and y made orthogonal to it), and the scale along each."""
    rows = local_to_world[:3, :3]
    scale = np.linalg.norm(rows, axis=1)
    if not np.isfinite(local_to_world).all() or scale.min() < 1e-12:
        return None, scale
    z = rows[2] / scale[2]
    x = rows[0] - z * (rows[0] @ z)
    x = x / max(np.linalg.norm(x), 1e-30)
    y = rows[1] - z * (rows[1] @ z)
    y = y - x * (y @ x)
    length = np.linalg.norm(y)
    if length < 1e-12 * scale[1]:
        return None, scale
    return np.stack([x, y / length, z]), scale


def _distant(prim: Usd.Prim, row: np.ndarray, lux: np.ndarray, metres_per_unit: float) -> np.ndarray:
    angle = min(max(light_number(prim, "angle", 0.53), 0.0), 360.0)
    half_angle = math.radians(angle) / 2.0
    row["cos_angle"] = math.cos(half_angle)
    # From the float32 that the kernel has: at small angles its rounding is a visible part of 1 - cos.
    cosine = float(row["cos_angle"])
    row["radiance"] = lux if cosine == 1.0 else lux / distant_size_factor(cosine)
    row["power"] = _brightness(lux) * math.pi * (NOMINAL_RADIUS / metres_per_unit) ** 2
    return row


def distant_size_factor(cosine: float) -> float:
    """Lux per nit of a distant light of that half angle: UsdLux's sizeFactor for distant lights."""
    sine_squared = 1.0 - cosine * cosine
    return math.pi * (sine_squared if cosine >= 0.0 else 2.0 - sine_squared)


def _area_light(
    prim: Usd.Prim, row: np.ndarray, luminance: np.ndarray, scale: np.ndarray, metres_per_unit: float
) -> np.ndarray | None:
    sx, sy, sz = scale
    kind = int(row["kind"])
    normalize = bool(light_value(prim, "normalize", False))
    point = POINT_RADIUS / metres_per_unit
    if kind == LIGHT_RECT:
        width, height = (_size(prim, "width", 1.0) * sx, _size(prim, "height", 1.0) * sy)
        row["width"], row["height"] = max(width, point), max(height, point)
        area = emitting = width * height
        mean = rect_texture_mean(prim)
        luminance = luminance if mean is None else luminance * mean
    elif kind == LIGHT_CYLINDER:
        radius, length = _size(prim, "radius", 0.5), _size(prim, "length", 1.0) * sx
        row["radius"], row["height"] = max(radius * math.sqrt(sy * sz), point), max(length, point)
        _warn_of_scale(prim, sy, sz)
        area = emitting = length * ellipse_perimeter(radius * sy, radius * sz)
    elif kind == LIGHT_DISK:
        radius = _size(prim, "radius", 0.5)
        row["radius"] = max(radius * math.sqrt(sx * sy), point)
        _warn_of_scale(prim, sx, sy)
        area = emitting = math.pi * radius * radius * sx * sy
    else:
        radius = _size(prim, "radius", 0.5)
        row["radius"] = max(radius * (sx * sy * sz) ** (1.0 / 3.0), point)
        _warn_of_scale(prim, sx, sy, sz)
        area = emitting = ellipsoid_area(radius * sx, radius * sy, radius * sz)
    drawn = _drawn_area(row)
    if normalize:
        luminance = luminance / (area if area > 0.0 else drawn)
    elif area <= 0.0:
        errors.warn_once(
            f"{prim.GetPath()}: the light has no size, so it gives no light. Author a size, or inputs:normalize = true "
            f"to keep its power at any size."
        )
        return None
    # What is drawn may differ from the true area (mean radius, smallest size): keep the flux.
    row["radiance"] = luminance * (emitting / drawn if emitting > 0.0 else 1.0)
    row["power"] = _brightness(np.asarray(row["radiance"], np.float64)) * math.pi * drawn
    return row


def _drawn_area(row: np.ndarray) -> float:
    kind, radius = int(row["kind"]), float(row["radius"])
    if kind == LIGHT_RECT:
        return float(row["width"]) * float(row["height"])
    if kind == LIGHT_CYLINDER:
        return 2.0 * math.pi * radius * float(row["height"])
    return math.pi * radius * radius * (4.0 if kind == LIGHT_SPHERE else 1.0)


def _size(prim: Usd.Prim, name: str, default: float) -> float:
    value = light_number(prim, name, default)
    if value >= 0.0:
        return value
    errors.warn_once(f"{prim.GetPath()}: inputs:{name} = {value} is no size; 0 is used. Author a value > 0.")
    return 0.0


def ellipse_perimeter(a: float, b: float) -> float:
    """Ramanujan's first approximation, exact for circles."""
    return math.pi * (3.0 * (a + b) - math.sqrt((3.0 * a + b) * (a + 3.0 * b)))


def ellipsoid_area(a: float, b: float, c: float) -> float:
    """Thomsen's approximation, exact for spheres, within 1.1 % otherwise."""
    p = 1.6075
    return 4.0 * math.pi * (((a * b) ** p + (a * c) ** p + (b * c) ** p) / 3.0) ** (1.0 / p)


def _brightness(colour: np.ndarray) -> float:
    return max(float(colour @ np.array([0.2126, 0.7152, 0.0722])), 1e-12)


def _read_shaping(prim: Usd.Prim, row: np.ndarray) -> None:
    """Without ShapingAPI or authored values a light is not shaped, whatever the schema's fallback angle."""
    angle = light_number(prim, "shaping:cone:angle", 180.0)
    row["shaping_cos"] = math.cos(math.radians(min(max(angle, 0.0), 180.0)))
    row["shaping_softness"] = min(max(light_number(prim, "shaping:cone:softness", 0.0), 0.0), 1.0)
    row["shaping_focus"] = max(light_number(prim, "shaping:focus", 0.0), 0.0)
    if row["shaping_focus"] > 0.0 and any(light_value(prim, "shaping:focusTint", (0.0, 0.0, 0.0))):
        _warn_ignored(prim, "inputs:shaping:focusTint", "black is used")


def _warn_of_scale(prim: Usd.Prim, *scale: float) -> None:
    if max(scale) > min(scale) * (1.0 + UNIFORM):
        errors.warn_once(
            f"{prim.GetPath()}: the light is scaled by {', '.join(f'{s:.4g}' for s in scale)}; it keeps its "
            f"round shape with the mean radius and the same flux. Scale it uniformly."
        )


def _warn_of_the_rest(prim: Usd.Prim) -> None:
    ies = light_value(prim, "shaping:ies:file", None)
    if ies is not None and ies.path:
        _warn_ignored(prim, "inputs:shaping:ies:file", "the light shines evenly")
    if light_value(prim, "shadow:enable", True) is False:
        _warn_ignored(prim, "inputs:shadow:enable = false", "it casts shadows")
    for collection in ("lightLink", "shadowLink"):
        for kind in ("includes", "excludes"):
            links = prim.GetRelationship(f"collection:{collection}:{kind}")
            if links and links.HasAuthoredTargets():
                _warn_ignored(prim, f"collection:{collection}", "the light reaches everything")


def _warn_ignored(prim: Usd.Prim, name: str, instead: str) -> None:
    errors.warn_once(f"{prim.GetPath()}: {name} is not supported and is ignored: {instead}. Remove it to silence this.")


def rect_texture_mean(prim: Usd.Prim) -> np.ndarray | None:
    """(3,) linear mean of a rect light's texture, which stands for it; None without one."""
    attribute = prim.GetAttribute("inputs:texture:file")
    authored, file = images.asset_file(attribute) if attribute else ("", "")
    if not authored:
        return None
    try:
        picture = images.read(file) if file else None
    except errors.AssetUnreadable:
        picture = None
    if picture is None:
        errors.warn_once(f"{prim.GetPath()}: the light's texture {authored} cannot be read; it is ignored. Correct it.")
        return None
    errors.warn_once(
        f"{prim.GetPath()}: a rect light's texture is replaced by its mean colour. Remove it to silence this."
    )
    return linear_rgb(picture).reshape(-1, 3).mean(axis=0)


def linear_rgb(picture: images.Picture) -> np.ndarray:
    """(H, W, 3) float32 linear, NaN, infinite and negative texels replaced."""
    texels = picture.texels[..., :3]
    if texels.dtype.kind == "f":
        clean = np.nan_to_num(texels, nan=0.0, posinf=65504.0, neginf=0.0)
        return np.maximum(clean, 0.0)
    values = np.arange(np.iinfo(texels.dtype).max + 1, dtype=np.float32) / np.iinfo(texels.dtype).max
    table = srgb_to_linear(values) if texels.dtype == np.uint8 else values
    return table.astype(np.float32)[texels]


def metres_per_unit(stage: Usd.Stage) -> float:
    """Positive, whatever the stage says."""
    value = UsdGeom.GetStageMetersPerUnit(stage)
    return value if math.isfinite(value) and value > 0.0 else 1.0
