"""Weights of multiple importance sampling: light is found by next-event estimation, and by the rays of paths."""

import warp as wp

from usdsdg_render.kernels.lights.light_sampling import light_weight
from usdsdg_render.kernels.path.path_state import Path
from usdsdg_render.scene.structs import Light

# Sentinel pdf of specular bounces, which next-event estimation cannot find; gives them MIS weight 1.
DELTA_PDF = wp.constant(1.0e15)


@wp.func
def mis_weight(pdf: float, other: float):
    """Power heuristic: MIS weight of a sample with density `pdf` that another technique finds with density `other`."""
    a = pdf * pdf
    return a / (a + other * other)


@wp.func
def light_probability(light: Light, path: Path):
    """Probability that next-event estimation at the path's last vertex chooses this light."""
    return light_weight(light, path.origin, path.normal, path.environment_weight) / path.light_weight_sum
