"""Coverage pass: which pixels instances would cover if each were alone."""

import warp as wp

from usdsdg_render.kernels.camera import camera_ray
from usdsdg_render.kernels.lens import NONE
from usdsdg_render.kernels.types import Camera, SceneTables
from usdsdg_render.kernels.visibility import meets_cutout
from usdsdg_render.trace.query import wide_meets_instance

ROUNDING = wp.constant(0.01)  # pixels

vec12 = wp.types.vector(length=12, dtype=wp.float32)


@wp.struct
class Strip:
    """A run of pixels of one row and one word, [first, last), to test for one instance."""

    instance: wp.int32
    row: wp.int32
    first: wp.int32
    last: wp.int32


@wp.func
def span_of_box(corners: wp.array2d(dtype=wp.vec3), box: int, camera: Camera, row: int):
    """Columns [first, last) whose rays in a row of a pinhole's picture can meet a box.

    These rays lie in one plane, which cuts the box in a convex polygon: its corners lie on edges of the box. What of it
    lies in front of the near plane is the polygon's corners there, and where lines from them to the others cross.
    """
    slope = (camera.cy - (float(row) + 0.5)) / camera.fy
    near = wp.max(camera.near * 0.999, 1.0e-12)
    across = vec12()
    depth = vec12()
    count = int(0)
    for corner in range(8):
        for axis in range(3):
            if (corner >> axis) & 1 == 0:
                a = corners[box, corner]
                b = corners[box, corner + (1 << axis)]
                # Heights above the plane of the row; the camera looks along -z.
                above_a = a[1] + a[2] * slope
                above_b = b[1] + b[2] * slope
                if (above_a < 0.0) != (above_b < 0.0):
                    share = above_a / (above_a - above_b)
                    across[count] = a[0] + (b[0] - a[0]) * share
                    depth[count] = -(a[2] + (b[2] - a[2]) * share)
                    count += 1
    left = float(wp.inf)
    right = -float(wp.inf)
    for k in range(count):
        if depth[k] >= near:
            left = wp.min(left, across[k] / depth[k])
            right = wp.max(right, across[k] / depth[k])
            for other in range(count):
                if depth[other] < near:
                    share = (depth[k] - near) / (depth[k] - depth[other])
                    at_near = (across[k] + (across[other] - across[k]) * share) / near
                    left = wp.min(left, at_near)
                    right = wp.max(right, at_near)
    if left > right:
        return wp.vec2i(0, 0)
    # Pixels whose centres lie between.
    most = float(camera.width) + 1.0
    first = wp.clamp(camera.cx + camera.fx * left - 0.5 - ROUNDING, -1.0, most)
    last = wp.clamp(camera.cx + camera.fx * right - 0.5 + ROUNDING, -1.0, most)
    return wp.vec2i(int(wp.ceil(first)), int(wp.floor(last)) + 1)


@wp.kernel(enable_backward=False)
def find_spans(
    camera: Camera,
    corners: wp.array2d(dtype=wp.vec3),  # per box the eight corners in the camera's frame
    rectangles: wp.array(dtype=wp.vec4i),  # per box x0, y0, x1, y1 (exclusive): pixels it can reach
    first_box: int,
    # out: per box and row the columns [first, last) to test
    spans: wp.array2d(dtype=wp.vec2i),
):
    box, row = wp.tid()
    box += first_box
    r = rectangles[box]
    span = wp.vec2i(0, 0)
    if row >= r[1] and row < r[3]:
        span = wp.vec2i(r[0], r[2])
        if camera.orthographic == 0 and camera.lens_kind == NONE:
            tight = span_of_box(corners, box, camera, row)
            span = wp.vec2i(wp.max(r[0], tight[0]), wp.min(r[2], tight[1]))
    spans[box, row] = span


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
