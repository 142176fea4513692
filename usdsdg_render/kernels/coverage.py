"""Coverage pass: which pixels instances would cover if each were alone."""

import warp as wp

from usdsdg_render.kernels.camera import camera_ray
from usdsdg_render.kernels.types import Camera, SceneTables
from usdsdg_render.kernels.visibility import meets_cutout
from usdsdg_render.trace.query import wide_meets_instance


@wp.struct
class Strip:
    """A run of pixels of one row and one word, [first, last), to test for one instance."""

    instance: wp.int32
    row: wp.int32
    first: wp.int32
    last: wp.int32


@wp.kernel(enable_backward=False)
def cover_strips(
    tables: SceneTables,
    camera: Camera,
    mode: int,
    shown: wp.array2d(dtype=wp.int32),  # the instance AOV
    strips: wp.array(dtype=Strip),
    first_strip: int,
    # out, per strip a bit per pixel of its word
    covered: wp.array(dtype=wp.uint64),
    visible: wp.array(dtype=wp.uint64),
):
    s = first_strip + wp.tid()
    strip = strips[s]
    solid = tables.tree.instances[strip.instance].cutout == 0
    met = wp.uint64(0)
    seen = wp.uint64(0)
    for x in range(strip.first, strip.last):
        bit = wp.uint64(1) << wp.uint64(x & 63)
        if shown[strip.row, x] == strip.instance:
            seen = seen | bit
        else:
            ray = camera_ray(camera, float(x) + 0.5, float(strip.row) + 0.5, wp.vec2(0.0))
            if solid:
                if (
                    wide_meets_instance(tables.tree, ray.origin, ray.direction, ray.tmin, ray.tmax, strip.instance)[3]
                    >= 0
                ):
                    met = met | bit
            elif meets_cutout(tables, ray.origin, ray.direction, ray.tmin, ray.tmax, strip.instance, mode):
                met = met | bit
    covered[s] = met | seen
    visible[s] = seen
