"""Label pass over openness: how much of the hemisphere above each pixel's surface is free nearby."""

import warp as wp

from usdsdg_render.kernels.bsdf import perpendicular
from usdsdg_render.kernels.camera import camera_ray
from usdsdg_render.kernels.sampler import pixel_seed, sample_pair
from usdsdg_render.kernels.surface import facing, surface_at
from usdsdg_render.kernels.trig import cos_sin
from usdsdg_render.kernels.types import Camera, SceneTables
from usdsdg_render.kernels.visibility import closest, transmitted

AMBIENT_RAYS = wp.constant(64)


@wp.kernel(enable_backward=False)
def label_ambient(
    tables: SceneTables,
    camera: Camera,
    reach: float,  # how far things darken each other [stage units]
    mode: int,
    first_row: int,
    # out
    openness: wp.array2d(dtype=wp.float32),
):
    y, x = wp.tid()
    y += first_row
    ray = camera_ray(camera, float(x) + 0.5, float(y) + 0.5, wp.vec2(0.0))
    hit = closest(tables, ray.origin, ray.direction, ray.tmin, ray.tmax, mode, 0.5)
    openness[y, x] = 1.0
    if hit.instance < 0:
        return
    surface = surface_at(tables, hit, ray.direction)
    normal = facing(surface.normal, surface.horizon, -ray.direction)
    across = perpendicular(normal)
    along = wp.cross(normal, across)
    origin = surface.position + surface.lift + surface.geometric * surface.gap
    seed = pixel_seed(wp.uint32(0), wp.uint32(0), x, y)
    free = float(0.0)
    for k in range(AMBIENT_RAYS):
        r = sample_pair(seed, wp.uint32(k), 0)
        around = cos_sin(r[1])
        s = wp.sqrt(r[0])
        direction = across * (s * around[0]) + along * (s * around[1]) + normal * wp.sqrt(1.0 - r[0])
        if wp.dot(direction, surface.horizon) > 0.0:
            free += transmitted(tables, origin, direction, reach)
    openness[y, x] = free / float(AMBIENT_RAYS)
