"""The AOV of ambient occlusion: the fraction of the hemisphere above a surface without geometry nearby."""

import warp as wp

from usdsdg_render.kernels.bsdf.bsdf import perpendicular
from usdsdg_render.kernels.cameras.camera import Ray
from usdsdg_render.kernels.labels.aov_table import HEMISPHERE, aov
from usdsdg_render.kernels.path.sampler import pixel_seed, sample_pair
from usdsdg_render.kernels.scene.surface import Surface, ensure_valid_reflection
from usdsdg_render.kernels.scene.visibility import transmitted
from usdsdg_render.kernels.trig import cos_sin
from usdsdg_render.scene.structs import SceneTables

AMBIENT_RAYS = wp.constant(64)
AMBIENT_DISTANCE = 0.35  # [m], as the reference's default


@aov(HEMISPHERE, miss=1.0)
def ambient_occlusion(tables: SceneTables, ray: Ray, surface: Surface, x: int, y: int, distance: float) -> wp.float32:
    """Cosine-weighted fraction of the hemisphere that is unoccluded within AMBIENT_DISTANCE; 1 = unoccluded."""
    normal = ensure_valid_reflection(surface.normal, surface.horizon_normal, -ray.direction)
    across = perpendicular(normal)
    along = wp.cross(normal, across)
    origin = surface.position + surface.terminator_offset + surface.geometric * surface.ray_epsilon
    seed = pixel_seed(wp.uint32(0), wp.uint32(0), x, y)
    free = float(0.0)
    for k in range(AMBIENT_RAYS):
        r = sample_pair(seed, wp.uint32(k), 0)
        around = cos_sin(r[1])
        s = wp.sqrt(r[0])
        direction = across * (s * around[0]) + along * (s * around[1]) + normal * wp.sqrt(1.0 - r[0])
        if wp.dot(direction, surface.horizon_normal) > 0.0:
            free += transmitted(tables, origin, direction, distance)
    return wp.float32(free / float(AMBIENT_RAYS))
