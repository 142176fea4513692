"""UsdLux lights to rows of `scene.LIGHT`, in nits and stage units.

Luminance is intensity * 2^exposure * color * temperature, and `normalize` divides it by the world-space area, as the
UsdLux schema says. Two deliberate readings:

Distant lights: intensity is the illuminance [lux] of a surface that faces the light, whether `normalize` is on or off.
UsdLux without `normalize` means nits over the light's cone, which at the fallback angle of 0.53 degrees would turn 400
into night (0.03 lux); scenes made for Omniverse author a few hundred to a few thousand and expect daylight.

Non-uniform scale turns disks, cylinders and spheres into ellipses and ellipsoids; their area for `normalize` is exact
for disks and within 1 % for the others. `treatAsPoint` and `treatAsLine` shrink a light to a millimeter and keep the
flux of its authored size.
"""

import math

import numpy as np
from pxr import Usd

from usdsdg import errors
from usdsdg.stage.colors import LUMINANCE
from usdsdg_render.lights.light_values import emitted_color, light_number, light_value
from usdsdg_render.lights.power import ellipse_perimeter, ellipsoid_area
from usdsdg_render.scene import structs
from usdsdg_render.scene.scene import LIGHT, NO_EMISSION_PROFILE, NO_LINKS
from usdsdg_render.usd.prim_kinds import LIGHT_TYPES

# Radius of lights without a size [m].
POINT_RADIUS = 1e-3
# The weight of a distant light is its flux through a disk of this radius [m], the size of a room: fixed, so that light
# selection does not depend on where objects are.
NOMINAL_RADIUS = 5.0
# The fields of a row that hold numbers that are not whole.
_REALS = [name for name in LIGHT.names or () if LIGHT[name].base.kind == "f"]
# Relative differences of scales below this are rounding.
UNIFORM_SCALE_TOLERANCE = 1e-3


def read_light(
    prim: Usd.Prim, local_to_world: np.ndarray, meters_per_unit: float, *, luminance: np.ndarray | None = None
) -> np.ndarray | None:
    """Read one row of `scene.LIGHT`, without emission profile and links; None if it emits nothing or is invalid.

    Invalid lights are named in a warning.

    luminance: in place of the color that the prim emits.
    """
    kind = LIGHT_TYPES[str(prim.GetTypeName())]
    if luminance is None:
        luminance = emitted_color(prim, 50000.0 if kind == structs.LIGHT_DISTANT else 1.0)
    axes, scale = _frame(local_to_world)
    if luminance is None or not luminance.any():
        return None
    if axes is None:
        errors.warn_once(f"{prim.GetPath()}: the light's transform is NaN or scaled to zero; it is off. Correct it.")
        return None
    row = np.zeros((), LIGHT)
    row["kind"], row["emission_profile"], row["links"], row["aspect"] = kind, NO_EMISSION_PROFILE, NO_LINKS, 1.0
    row["x_axis"], row["y_axis"], row["z_axis"] = axes
    row["position"] = local_to_world[3, :3]
    _read_shaping(prim, row)
    row["diffuse"] = max(light_number(prim, "diffuse", 1.0), 0.0)
    row["specular"] = max(light_number(prim, "specular", 1.0), 0.0)
    visible = prim.GetAttribute("visibleInPrimaryRay")
    row["visible"] = 0 if visible and visible.Get() is False else 1
    warn_of_ignored(prim)
    _warn_of_shear(prim, local_to_world, scale)
    with np.errstate(over="ignore", invalid="ignore"):
        if kind == structs.LIGHT_DISTANT:
            _write_angle(prim, row)
        elif not _write_area(prim, row, scale, meters_per_unit):
            return None
    return _with_emission(prim, row, scale, luminance, meters_per_unit)


def read_emission(
    prim: Usd.Prim, row: np.ndarray, local_to_world: np.ndarray, meters_per_unit: float
) -> np.ndarray | None:
    """Return what `read_light` does for a light of which only brightness or color have changed since `row` was read."""
    luminance = emitted_color(prim, 50000.0 if int(row["kind"]) == structs.LIGHT_DISTANT else 1.0)
    if luminance is None or not luminance.any():
        return None
    return _with_emission(prim, row.copy(), _frame(local_to_world)[1], luminance, meters_per_unit)


def _with_emission(
    prim: Usd.Prim, row: np.ndarray, scale: np.ndarray, luminance: np.ndarray, meters_per_unit: float
) -> np.ndarray | None:
    with np.errstate(over="ignore", invalid="ignore"):
        row["radiance"], row["power"] = emission(prim, row, scale, luminance, meters_per_unit)
    if all(np.isfinite(row[name]).all() for name in _REALS):
        return row
    errors.warn_once(
        f"{prim.GetPath()}: the light is too bright or too large for 32-bit numbers; it is off. Correct it."
    )
    return None


def emission(
    prim: Usd.Prim, row: np.ndarray, scale: np.ndarray, color: np.ndarray, meters_per_unit: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return radiances (..., 3) float32 and powers (...) of a light that emits colors (..., 3); `row` has its shape."""
    if int(row["kind"]) == structs.LIGHT_DISTANT:
        # From the kernel's float32: at small angles its rounding is a visible part of 1 - cos.
        cosine = float(row["cos_angle"])
        radiance = color if cosine == 1.0 else color / distant_size_factor(cosine)
        return radiance.astype(np.float32), _luminance(color) * math.pi * (NOMINAL_RADIUS / meters_per_unit) ** 2
    area, _ = _shape(prim, LIGHT_TYPES[str(prim.GetTypeName())], scale)
    rendered_area = _rendered_area(row)
    if light_value(prim, "normalize", False):
        color = color / (area if area > 0.0 else rendered_area)
    # The rendered area may differ from the authored one (minimum size, points and lines): keep the flux.
    radiance = (color * (area / rendered_area if area > 0.0 else 1.0)).astype(np.float32)
    return radiance, _luminance(radiance.astype(np.float64)) * math.pi * rendered_area


def light_axes(local_to_world: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return `_frame` of (N, 4, 4) matrices with inverses: (N, 3, 3) axes as rows, and (N, 3) scales."""
    rows = local_to_world[:, :3, :3]
    scale = np.linalg.norm(rows, axis=2)
    z = rows[:, 2] / scale[:, 2:]
    x = rows[:, 0] - z * (rows[:, 0] * z).sum(1, keepdims=True)
    x = x / np.maximum(np.linalg.norm(x, axis=1, keepdims=True), 1e-30)
    y = rows[:, 1] - z * (rows[:, 1] * z).sum(1, keepdims=True)
    y = y - x * (y * x).sum(1, keepdims=True)
    return np.stack([x, y / np.linalg.norm(y, axis=1, keepdims=True), z], 1), scale


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


def _write_angle(prim: Usd.Prim, row: np.ndarray) -> None:
    angle = min(max(light_number(prim, "angle", 0.53), 0.0), 360.0)
    row["cos_angle"] = math.cos(math.radians(angle) / 2.0)


def distant_size_factor(cosine: float) -> float:
    """Return lux per nit of a distant light by the cosine of its half angle: UsdLux's sizeFactor."""
    sine_squared = 1.0 - cosine * cosine
    return math.pi * (sine_squared if cosine >= 0.0 else 2.0 - sine_squared)


def _write_area(prim: Usd.Prim, row: np.ndarray, scale: np.ndarray, meters_per_unit: float) -> bool:
    """Write the shape of an area light to the row; return whether it gives light, and say so if it does not."""
    area, half = _shape(prim, int(row["kind"]), scale)
    _write_shape(prim, row, half, POINT_RADIUS / meters_per_unit)
    if area > 0.0 or light_value(prim, "normalize", False):
        return True
    errors.warn_once(
        f"{prim.GetPath()}: the light has no size, so it gives no light. Author a size, or inputs:normalize = true "
        f"to keep its power at any size."
    )
    return False


def _shape(prim: Usd.Prim, kind: int, scale: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the world area of a light, and its half extents along x, y, z."""
    if kind == structs.LIGHT_RECT:
        half = scale * (_size(prim, "width", 1.0) / 2.0, _size(prim, "height", 1.0) / 2.0, 0.0)
        return 4.0 * half[0] * half[1], half
    radius = _size(prim, "radius", 0.5)
    if kind == structs.LIGHT_CYLINDER:
        half = scale * (_size(prim, "length", 1.0) / 2.0, radius, radius)
        return 2.0 * half[0] * ellipse_perimeter(half[1], half[2]), half
    half = scale * radius
    return math.pi * half[0] * half[1] if kind == structs.LIGHT_DISK else ellipsoid_area(*half), half


def _write_shape(prim: Usd.Prim, row: np.ndarray, half: np.ndarray, min_half: float) -> None:
    """Write the sizes to the row, at least `min_half`; treatAsPoint and treatAsLine shrink the light."""
    kind = int(row["kind"])
    hint = {structs.LIGHT_SPHERE: "treatAsPoint", structs.LIGHT_CYLINDER: "treatAsLine"}.get(kind)
    if hint and prim.HasAttribute(hint) and prim.GetAttribute(hint).Get():
        half = half * (0.0 if kind == structs.LIGHT_SPHERE else (1.0, 0.0, 0.0))
    x, y, z = np.maximum(half, min_half)
    if kind == structs.LIGHT_RECT:
        row["width"], row["height"] = 2.0 * x, 2.0 * y
    elif kind == structs.LIGHT_CYLINDER:
        row["radius"], row["aspect"][0], row["height"] = y, z / y, 2.0 * x
    else:
        row["radius"] = x
        if kind == structs.LIGHT_DISK:
            row["aspect"][0] = y / x
        elif max(x, y, z) > min(x, y, z) * (1.0 + UNIFORM_SCALE_TOLERANCE):
            row["kind"], row["aspect"] = structs.LIGHT_ELLIPSOID, (y / x, z / x)


def _rendered_area(row: np.ndarray) -> float:
    kind, radius = int(row["kind"]), float(row["radius"])
    second, third = radius * row["aspect"].astype(float)
    if kind == structs.LIGHT_RECT:
        return float(row["width"]) * float(row["height"])
    if kind == structs.LIGHT_CYLINDER:
        return ellipse_perimeter(radius, second) * float(row["height"])
    return math.pi * radius * second if kind == structs.LIGHT_DISK else ellipsoid_area(radius, second, third)


def _size(prim: Usd.Prim, name: str, default: float) -> float:
    value = light_number(prim, name, default)
    if value >= 0.0:
        return value
    errors.warn_once(f"{prim.GetPath()}: inputs:{name} = {value} is no size; 0 is used. Author a value > 0.")
    return 0.0


def _luminance(color: np.ndarray) -> np.ndarray:
    # Not a product of matrices, whose rounding depends on how many colors there are.
    red, green, blue = np.moveaxis(color, -1, 0)
    return np.maximum(red * LUMINANCE[0] + green * LUMINANCE[1] + blue * LUMINANCE[2], 1e-12)


def _read_shaping(prim: Usd.Prim, row: np.ndarray) -> None:
    """Read cone and focus; unauthored inputs mean no shaping, whatever the schema's fallback angle."""
    angle = light_number(prim, "shaping:cone:angle", 180.0)
    row["shaping_cos"] = math.cos(math.radians(min(max(angle, 0.0), 180.0)))
    row["shaping_softness"] = min(max(light_number(prim, "shaping:cone:softness", 0.0), 0.0), 1.0)
    row["shaping_focus"] = max(light_number(prim, "shaping:focus", 0.0), 0.0)
    tint = np.array(light_value(prim, "shaping:focusTint", (0.0, 0.0, 0.0)), float)
    row["focus_tint"] = np.clip(np.nan_to_num(tint), 0.0, None)


def _warn_of_shear(prim: Usd.Prim, local_to_world: np.ndarray, scale: np.ndarray) -> None:
    rows = local_to_world[:3, :3] / scale[:, None]
    if np.abs(rows @ rows.T - np.eye(3)).max() > UNIFORM_SCALE_TOLERANCE:
        errors.warn_once(
            f"{prim.GetPath()}: the light is sheared; its axes are made perpendicular. Scale it along its own axes."
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
