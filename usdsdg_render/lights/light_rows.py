"""Rows of `scene.LIGHT` of UsdLux lights, in nits and stage units.

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
from collections.abc import Sequence

import numpy as np
from pxr import Sdf, Usd

from usdsdg import errors
from usdsdg.stage.colors import LUMINANCE
from usdsdg_render.lights.light_inputs import LightInputs, read_inputs
from usdsdg_render.lights.light_values import emitted_color
from usdsdg_render.lights.power import ellipse_perimeter, ellipsoid_area
from usdsdg_render.scene import structs
from usdsdg_render.scene.scene import LIGHT, NO_EMISSION_PROFILE, NO_LINKS

# Radius of lights without a size [m].
POINT_RADIUS = 1e-3
# The weight of a distant light is its flux through a disk of this radius [m], the size of a room: fixed, so that light
# selection does not depend on where objects are.
NOMINAL_RADIUS = 5.0
# The fields of a row that hold numbers that are not whole.
_REALS = [name for name in LIGHT.names or () if LIGHT[name].base.kind == "f"]
# The fields that inputs give as they are.
_GIVEN = [name for name in LightInputs._fields if name in (LIGHT.names or ())]
# Relative differences of scales below this are rounding.
UNIFORM_SCALE_TOLERANCE = 1e-3


def read_light(prim: Usd.Prim, local_to_world: np.ndarray, meters_per_unit: float) -> np.void | None:
    """Read one row of `scene.LIGHT`, without emission profile and links; None if it emits nothing or is invalid."""
    luminance = emitted_color(prim)
    if luminance is None or not luminance.any():
        return None
    paths, inputs = [prim.GetPath()], [read_inputs(prim)]
    rows, are_lit = light_rows(paths, inputs, luminance[None], local_to_world[None], meters_per_unit)
    return rows[0] if are_lit[0] else None


@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def light_rows(
    paths: Sequence[Sdf.Path],
    inputs: Sequence[LightInputs],
    luminances: np.ndarray,
    local_to_world: np.ndarray,
    meters_per_unit: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return rows (N,) of `scene.LIGHT`, without emission profiles and links, and which of them (N,) give light.

    Lights that should and do not are named in a warning.

    Args:
        luminances: (N, 3) that the lights emit before `normalize`, see `emitted_color`.
        local_to_world: (N, 4, 4).
    """
    rows = np.zeros(len(inputs), LIGHT)
    for name in _GIVEN:
        rows[name] = [getattr(each, name) for each in inputs]
    rows["emission_profile"], rows["links"], rows["aspect"] = NO_EMISSION_PROFILE, NO_LINKS, 1.0
    axes, scales, are_placed = light_frames(local_to_world)
    rows["x_axis"], rows["y_axis"], rows["z_axis"] = axes[:, 0], axes[:, 1], axes[:, 2]
    rows["position"] = local_to_world[:, 3, :3]
    half = scales * [each.half for each in inputs]
    areas = _areas(rows["kind"], half)
    _write_shapes(rows, half * [each.kept for each in inputs], POINT_RADIUS / meters_per_unit)
    normalized = np.array([each.normalize for each in inputs], bool)
    rows["radiance"], rows["power"] = emission(rows, areas, normalized, luminances, meters_per_unit)
    have_size = (areas > 0.0) | normalized | (rows["kind"] == structs.LIGHT_DISTANT)
    are_finite = np.logical_and.reduce([np.isfinite(rows[name]).reshape(len(rows), -1).all(1) for name in _REALS])
    _warn(paths, are_placed, have_size, are_finite)
    are_lit = are_placed & have_size & are_finite
    _warn_of_shear(paths, local_to_world, scales, are_placed)
    return rows, are_lit


def light_areas(inputs: Sequence[LightInputs], scales: np.ndarray) -> np.ndarray:
    """Return the world areas (N,) of lights, 0 of those without a size, at scales (N, 3)."""
    return _areas(np.array([each.kind for each in inputs]), scales * [each.half for each in inputs])


@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def emission(
    rows: np.ndarray, areas: np.ndarray, normalized: np.ndarray, colors: np.ndarray, meters_per_unit: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return radiances (N, 3) float32 and powers (N,) of lights that emit colors (N, 3); the others may be one row.

    areas: of their authored sizes in the world. normalized: whether `normalize` divides by these.
    """
    are_distant, rendered = rows["kind"] == structs.LIGHT_DISTANT, _rendered_areas(rows)
    has_area = ~are_distant & (areas > 0.0)
    divisor = np.where(normalized & ~are_distant, np.where(has_area, areas, rendered), 1.0)
    # The rendered area may differ from the authored one (minimum size, points and lines): keep the flux.
    kept = np.where(has_area, areas / rendered, 1.0)
    # From the kernel's float32: at small angles its rounding is a visible part of 1 - cos.
    cosines = rows["cos_angle"].astype(np.float64)
    divisor = np.where(are_distant & (cosines != 1.0), distant_size_factor(cosines), divisor)
    radiance = (colors / divisor[:, None] * kept[:, None]).astype(np.float32)
    flux = _luminance(radiance.astype(np.float64)) * math.pi * rendered
    nominal = _luminance(colors) * math.pi * (NOMINAL_RADIUS / meters_per_unit) ** 2
    return radiance, np.where(are_distant, nominal, flux)


@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def light_frames(local_to_world: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return frames of matrices (N, 4, 4).

    Returns:
        (N, 3, 3) unit axes as rows, the emission axis z kept, x and y made orthogonal to it; (N, 3) the scale along
        each; (N,) whether there is such a frame: the matrix is finite and has an inverse.
    """
    rows = local_to_world[:, :3, :3]
    scales = np.sqrt(_dot(rows, rows))
    z = rows[:, 2] / scales[:, 2:]
    x = rows[:, 0] - z * _dot(rows[:, 0], z)[:, None]
    x = x / np.maximum(np.sqrt(_dot(x, x)), 1e-30)[:, None]
    y = rows[:, 1] - z * _dot(rows[:, 1], z)[:, None]
    y = y - x * _dot(y, x)[:, None]
    length = np.sqrt(_dot(y, y))
    are_usable = np.isfinite(local_to_world).all((1, 2)) & (scales.min(1, initial=np.inf) >= 1e-12)
    are_usable &= length >= 1e-12 * scales[:, 1]
    return np.stack([x, y / length[:, None], z], 1), scales, are_usable


def distant_size_factor(cosines: np.ndarray) -> np.ndarray:
    """Return lux per nit of distant lights by the cosine of their half angles: UsdLux's sizeFactor."""
    sine_squared = 1.0 - cosines * cosines
    return math.pi * np.where(cosines >= 0.0, sine_squared, 2.0 - sine_squared)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    # Not a product of matrices, whose rounding depends on how many there are.
    products = a * b
    return products[..., 0] + products[..., 1] + products[..., 2]


def _luminance(colors: np.ndarray) -> np.ndarray:
    return np.maximum(_dot(colors, LUMINANCE), 1e-12)


def _areas(kinds: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Return the areas (N,) of lights with these half extents (N, 3) along x, y, z."""
    x, y, z = half.T
    by_kind = {
        structs.LIGHT_RECT: 4.0 * x * y,
        structs.LIGHT_CYLINDER: 2.0 * x * ellipse_perimeter(y, z),
        structs.LIGHT_DISK: math.pi * x * y,
        structs.LIGHT_SPHERE: ellipsoid_area(x, y, z),
    }
    return np.select([kinds == kind for kind in by_kind], list(by_kind.values()), 0.0)


def _write_shapes(rows: np.ndarray, half: np.ndarray, min_half: float) -> None:
    """Write the sizes of lights with these half extents (N, 3), at least `min_half`; scaled spheres are ellipsoids."""
    kinds, (x, y, z) = rows["kind"], np.maximum(half, min_half).T
    rects, cylinders = kinds == structs.LIGHT_RECT, kinds == structs.LIGHT_CYLINDER
    disks, spheres = kinds == structs.LIGHT_DISK, kinds == structs.LIGHT_SPHERE
    largest, least = np.maximum(np.maximum(x, y), z), np.minimum(np.minimum(x, y), z)
    ellipsoids = spheres & (largest > least * (1.0 + UNIFORM_SCALE_TOLERANCE))
    rows["width"] = np.where(rects, 2.0 * x, 0.0)
    rows["height"] = np.select([rects, cylinders], [2.0 * y, 2.0 * x], 0.0)
    rows["radius"] = np.select([cylinders, disks | spheres], [y, x], 0.0)
    rows["aspect"][:, 0] = np.select([cylinders, disks | ellipsoids], [z / y, y / x], 1.0)
    rows["aspect"][:, 1] = np.where(ellipsoids, z / x, 1.0)
    kinds[ellipsoids] = structs.LIGHT_ELLIPSOID


def _rendered_areas(rows: np.ndarray) -> np.ndarray:
    radius, width, height = (rows[name].astype(np.float64) for name in ("radius", "width", "height"))
    second, third = (radius[:, None] * rows["aspect"].astype(np.float64)).T
    by_kind = {
        structs.LIGHT_RECT: width * height,
        structs.LIGHT_CYLINDER: ellipse_perimeter(radius, second) * height,
        structs.LIGHT_DISK: math.pi * radius * second,
    }
    ellipsoids = ellipsoid_area(radius, second, third)
    return np.select([rows["kind"] == kind for kind in by_kind], list(by_kind.values()), ellipsoids)


def _warn(paths: Sequence[Sdf.Path], are_placed: np.ndarray, have_size: np.ndarray, are_finite: np.ndarray) -> None:
    """Say of the lights that should give light and do not why, each for its first reason."""
    for index in np.flatnonzero(~(are_placed & have_size & are_finite)).tolist():
        if not are_placed[index]:
            errors.warn_once(f"{paths[index]}: the light's transform is NaN or scaled to zero; it is off. Correct it.")
        elif not have_size[index]:
            errors.warn_once(
                f"{paths[index]}: the light has no size, so it gives no light. Author a size, or inputs:normalize = "
                "true to keep its power at any size."
            )
        else:
            errors.warn_once(
                f"{paths[index]}: the light is too bright or too large for 32-bit numbers; it is off. Correct it."
            )


def _warn_of_shear(
    paths: Sequence[Sdf.Path], local_to_world: np.ndarray, scales: np.ndarray, are_placed: np.ndarray
) -> None:
    rows = local_to_world[are_placed, :3, :3] / scales[are_placed, :, None]
    crossed = np.abs(rows @ rows.swapaxes(1, 2) - np.eye(3)).max((1, 2)) > UNIFORM_SCALE_TOLERANCE
    for index in np.flatnonzero(are_placed)[crossed].tolist():
        errors.warn_once(
            f"{paths[index]}: the light is sheared; its axes are made perpendicular. Scale it along its own axes."
        )
