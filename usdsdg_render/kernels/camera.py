"""Pixels to rays."""

import warp as wp

from usdsdg_render.kernels.trig import cos_sin
from usdsdg_render.kernels.types import Camera


@wp.struct
class Ray:
    """origin + t * direction, unit direction; the clipping range is tmin < t < tmax."""

    origin: wp.vec3
    direction: wp.vec3
    tmin: wp.float32
    tmax: wp.float32


@wp.func
def camera_ray(camera: Camera, column: float, row: float, lens: wp.vec2):
    """The ray through a point of the picture [pixels] and a point of the lens (two numbers in [0, 1))."""
    x = (column - camera.cx) / camera.fx
    y = (camera.cy - row) / camera.fy
    start = wp.vec3(0.0)
    towards = wp.vec3(x, y, -1.0)
    if camera.orthographic != 0:
        start = wp.vec3(x, y, 0.0)
        towards = wp.vec3(0.0, 0.0, -1.0)
    elif camera.lens_radius > 0.0:
        r = camera.lens_radius * wp.sqrt(lens[0])
        around = cos_sin(lens[1])
        start = wp.vec3(r * around[0], r * around[1], 0.0)
        towards = towards * camera.focus_distance - start
    towards = wp.normalize(towards)
    # The clipping range counts along the axis, t along the ray.
    per_depth = -1.0 / towards[2]
    return Ray(
        origin=camera.origin + camera.rotation * start,
        direction=camera.rotation * towards,
        tmin=camera.near * per_depth,
        tmax=camera.far * per_depth,
    )
