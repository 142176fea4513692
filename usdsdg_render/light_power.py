"""How much each light gives to the scene: the weights by which the path tracer chooses among them."""

from __future__ import annotations

import numpy as np

from usdsdg_render.scene import LIGHT_CYLINDER, LIGHT_DISK, LIGHT_DISTANT, LIGHT_RECT, LIGHT_SPHERE

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def strengths(lights: np.ndarray) -> np.ndarray:
    """Per row of `scene.LIGHT`: irradiance of a distant light [lux], intensity of the others head on [cd]."""
    luminance = np.maximum(np.nan_to_num(lights["radiance"].astype(np.float64) @ _LUMINANCE), 0.0)
    radius, width, height = (lights[name].astype(np.float64) for name in ("radius", "width", "height"))
    cos_angle = lights["cos_angle"].astype(np.float64)
    facing = {
        LIGHT_SPHERE: np.pi * radius**2,
        LIGHT_DISTANT: np.where(cos_angle < 1.0, np.pi * (1.0 - cos_angle**2), 1.0),
        LIGHT_RECT: width * height,
        LIGHT_DISK: np.pi * radius**2,
        LIGHT_CYLINDER: 2.0 * radius * height,
    }
    area = np.select([lights["kind"] == kind for kind in facing], list(facing.values()), 0.0)
    return luminance * area * (lights["power"] > 0)


def extents(lights: np.ndarray) -> np.ndarray:
    """Per light: radius of the ball around its position that holds it [stage units]; of a distant one the sine."""
    radius, width, height = (lights[name] for name in ("radius", "width", "height"))
    by_kind = {
        LIGHT_SPHERE: radius,
        LIGHT_DISTANT: np.sqrt(np.maximum(0.0, 1.0 - lights["cos_angle"] ** 2)),
        LIGHT_RECT: 0.5 * np.hypot(width, height),
        LIGHT_DISK: radius,
        LIGHT_CYLINDER: np.hypot(radius, 0.5 * height),
    }
    return np.select([lights["kind"] == kind for kind in by_kind], list(by_kind.values()), 0.0).astype(np.float32)
