"""Strength and extent of lights, by which the path tracer selects lights, and areas of light shapes."""

from collections.abc import Sequence

import numpy as np

from usdsdg.stage.colors import LUMINANCE
from usdsdg_render.scene import structs
from usdsdg_render.scene.scene import EmissionProfile


def strengths(lights: np.ndarray, profiles: Sequence[EmissionProfile] = ()) -> np.ndarray:
    """Return per row of `scene.LIGHT` the irradiance [lux] of a distant light, the peak intensity [cd] of others."""
    luminance = np.maximum(np.nan_to_num(lights["radiance"].astype(np.float64) @ LUMINANCE), 0.0)
    radius, width, height = (lights[name].astype(np.float64) for name in ("radius", "width", "height"))
    second, third = radius * lights["aspect"][:, 0], radius * lights["aspect"][:, 1]
    projected_area = {
        structs.LIGHT_SPHERE: np.pi * radius**2,
        structs.LIGHT_DISTANT: _distant_size(lights["cos_angle"].astype(np.float64)),
        structs.LIGHT_RECT: width * height,
        structs.LIGHT_DISK: np.pi * radius * second,
        structs.LIGHT_CYLINDER: ellipse_perimeter(radius, second) * height / np.pi,
        structs.LIGHT_ELLIPSOID: ellipsoid_area(radius, second, third) / 4.0,
    }
    area = np.select([lights["kind"] == kind for kind in projected_area], list(projected_area.values()), 0.0)
    factors = np.array([_profile_factor(profile) for profile in profiles] + [1.0])
    return luminance * area * factors[lights["emission_profile"]] * (lights["power"] > 0)


def _distant_size(cosine: np.ndarray) -> np.ndarray:
    """Return lux per nit on a surface that faces a distant light; 1 for delta lights, which are given in lux."""
    return np.where(cosine < 1.0, np.pi * (1.0 - np.maximum(cosine, 0.0) ** 2), 1.0)


def _profile_factor(profile: EmissionProfile) -> float:
    """Return the maximum of the IES profile times the mean luminance of the texture."""
    brightest = 1.0 if profile.ies is None else float(profile.ies.max())
    return brightest * (1.0 if profile.texture is None else float(profile.texture.mean((0, 1)) @ LUMINANCE))


def extents(lights: np.ndarray) -> np.ndarray:
    """Return the radius of each light's bounding sphere [stage units].

    For distant lights it is the sine of half the angle, or 2 if that is obtuse: the light then reaches every normal.
    """
    radius, width, height = (lights[name] for name in ("radius", "width", "height"))
    second, third = radius * lights["aspect"][:, 0], radius * lights["aspect"][:, 1]
    cosine = lights["cos_angle"]
    by_kind = {
        structs.LIGHT_SPHERE: radius,
        structs.LIGHT_DISTANT: np.where(cosine < 0.0, 2.0, np.sqrt(np.maximum(0.0, 1.0 - cosine**2))),
        structs.LIGHT_RECT: 0.5 * np.hypot(width, height),
        structs.LIGHT_DISK: np.maximum(radius, second),
        structs.LIGHT_CYLINDER: np.hypot(np.maximum(radius, second), 0.5 * height),
        structs.LIGHT_ELLIPSOID: np.maximum(radius, np.maximum(second, third)),
    }
    return np.select([lights["kind"] == kind for kind in by_kind], list(by_kind.values()), 0.0).astype(np.float32)


def ellipse_perimeter(a, b):
    """Approximate the perimeter of an ellipse by its half axes, exact for circles (Ramanujan); numbers or arrays."""
    return np.pi * (3.0 * (a + b) - np.sqrt((3.0 * a + b) * (a + 3.0 * b)))


def ellipsoid_area(a, b, c):
    """Approximate the area of an ellipsoid by its half axes, within 1.1 %, exact for spheres (Thomsen)."""
    p = 1.6075
    return 4.0 * np.pi * (((a * b) ** p + (a * c) ** p + (b * c) ** p) / 3.0) ** (1.0 / p)
