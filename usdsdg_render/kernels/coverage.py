"""Coverage pass: which pixels a few instances would cover if nothing else were there."""

import warp as wp

from usdsdg_render.kernels.camera import camera_ray
from usdsdg_render.kernels.types import Camera, SceneTables
from usdsdg_render.kernels.visibility import closest_in_instance


@wp.struct
class Strip:
    """A run of pixels in one row, [first, last), and the group to test it for."""

    group: wp.int32
    row: wp.int32
    first: wp.int32
    last: wp.int32


@wp.kernel(enable_backward=False)
def cover_strips(
    tables: SceneTables,
    camera: Camera,
    members: wp.array2d(dtype=wp.int32),  # per group the instances, closed by -1
    rectangles: wp.array(dtype=wp.vec4i),  # per instance x0, y0, x1, y1 (exclusive): pixels it can reach
    strips: wp.array(dtype=Strip),
    first_strip: int,
    # out, per strip: pixels covered, first and last column of them
    covered: wp.array(dtype=wp.vec3i),
):
    s = first_strip + wp.tid()
    strip = strips[s]
    count = int(0)
    left = int(2147483647)
    right = int(-1)
    for x in range(strip.first, strip.last):
        ray = camera_ray(camera, float(x) + 0.5, float(strip.row) + 0.5, wp.vec2(0.0))
        k = int(0)
        while True:
            instance = members[strip.group, k]
            if instance < 0:
                break
            k += 1
            r = rectangles[instance]
            if x >= r[0] and x < r[2] and strip.row >= r[1] and strip.row < r[3]:
                hit = closest_in_instance(tables, ray.origin, ray.direction, ray.tmin, ray.tmax, instance)
                if hit.instance >= 0:
                    count += 1
                    left = wp.min(left, x)
                    right = wp.max(right, x)
                    break
    covered[s] = wp.vec3i(count, left, right)
