"""How much each light gives to the scene: the weights by which the path tracer chooses among them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdsdg.stage.colors import LUMINANCE
from usdsdg_render.lights.areas import ellipse_perimeter, ellipsoid_area
from usdsdg_render.scene.scene import LightPattern
from usdsdg_render.scene.structs import (
    LIGHT_CYLINDER,
    LIGHT_DISK,
    LIGHT_DISTANT,
    LIGHT_ELLIPSOID,
    LIGHT_RECT,
    LIGHT_SPHERE,
)


def strengths(lights: np.ndarray, patterns: Sequence[LightPattern] = ()) -> np.ndarray:
    """Per row of `scene.LIGHT`: irradiance of a distant light [lux], intensity of the others head on [cd]."""
    luminance = np.maximum(np.nan_to_num(lights["radiance"].astype(np.float64) @ LUMINANCE), 0.0)
    radius, width, height = (lights[name].astype(np.float64) for name in ("radius", "width", "height"))
    second, third = radius * lights["aspect"][:, 0], radius * lights["aspect"][:, 1]
    facing = {
        LIGHT_SPHERE: np.pi * radius**2,
        LIGHT_DISTANT: _distant_size(lights["cos_angle"].astype(np.float64)),
        LIGHT_RECT: width * height,
        LIGHT_DISK: np.pi * radius * second,
        LIGHT_CYLINDER: ellipse_perimeter(radius, second) * height / np.pi,
        LIGHT_ELLIPSOID: ellipsoid_area(radius, second, third) / 4.0,
    }
    area = np.select([lights["kind"] == kind for kind in facing], list(facing.values()), 0.0)
    gains = np.array([_gain(pattern) for pattern in patterns] + [1.0])
    return luminance * area * gains[lights["pattern"]] * (lights["power"] > 0)


def _distant_size(cosine: np.ndarray) -> np.ndarray:
    """Lux per nit of a surface that faces the light; a delta light has its lux already."""
    return np.where(cosine < 1.0, np.pi * (1.0 - np.maximum(cosine, 0.0) ** 2), 1.0)


def _gain(pattern: LightPattern) -> float:
    """The brightest direction of a profile, times the mean of a picture."""
    brightest = 1.0 if pattern.profile is None else float(pattern.profile.max())
    return brightest * (1.0 if pattern.picture is None else float(pattern.picture.mean((0, 1)) @ LUMINANCE))


def extents(lights: np.ndarray) -> np.ndarray:
    """Per light: radius of the ball around its position that holds it [stage units].

    Of a distant one the sine of half its angle, or 2 where that is obtuse: it then reaches surfaces of any tilt.
    """
    radius, width, height = (lights[name] for name in ("radius", "width", "height"))
    second, third = radius * lights["aspect"][:, 0], radius * lights["aspect"][:, 1]
    cosine = lights["cos_angle"]
    by_kind = {
        LIGHT_SPHERE: radius,
        LIGHT_DISTANT: np.where(cosine < 0.0, 2.0, np.sqrt(np.maximum(0.0, 1.0 - cosine**2))),
        LIGHT_RECT: 0.5 * np.hypot(width, height),
        LIGHT_DISK: np.maximum(radius, second),
        LIGHT_CYLINDER: np.hypot(np.maximum(radius, second), 0.5 * height),
        LIGHT_ELLIPSOID: np.maximum(radius, np.maximum(second, third)),
    }
    return np.select([lights["kind"] == kind for kind in by_kind], list(by_kind.values()), 0.0).astype(np.float32)
