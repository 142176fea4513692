"""Label pass over openness: how much of the hemisphere above each pixel's surface is free nearby."""

import warp as wp

from usdsdg_render.kernels.bsdf.bsdf import perpendicular
from usdsdg_render.kernels.labels.label_module import LABELS
from usdsdg_render.kernels.labels.views import Views, meet_centre, picture_row
from usdsdg_render.kernels.path.sampler import pixel_seed, sample_pair
from usdsdg_render.kernels.scene.surface import facing, surface_at
from usdsdg_render.kernels.scene.visibility import transmitted
from usdsdg_render.kernels.trig import cos_sin
from usdsdg_render.scene.structs import SceneTables

AMBIENT_RAYS = wp.constant(64)


@wp.kernel(enable_backward=False, module=LABELS)
def label_ambient(
    tables: SceneTables,
    views: Views,
    reach: float,  # how far things darken each other [stage units]
    mode: int,
    first_band: int,
    # out: (views, height, width)
    openness: wp.array3d(dtype=wp.float32),
):
    band, x, row = wp.tid()
    v, y = picture_row(views, first_band + band, row)
    if y >= views.height:
        return
    ray, hit = meet_centre(tables, views.cameras[v], x, y, mode)
    openness[v, y, x] = 1.0
    if hit.instance < 0:
        return
    surface = surface_at(tables, hit, ray.direction)
    normal = facing(surface.normal, surface.horizon_normal, -ray.direction)
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
            free += transmitted(tables, origin, direction, reach)
    openness[v, y, x] = free / float(AMBIENT_RAYS)
