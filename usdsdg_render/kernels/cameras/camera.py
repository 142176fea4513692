"""Pixels to rays."""

import warp as wp

from usdsdg.stage.cameras import pixels
from usdsdg_render.kernels.cameras.lens import FLAT, NONE, PANORAMA, lens_direction, panorama_direction, panorama_eye
from usdsdg_render.kernels.trig import cos_sin
from usdsdg_render.scene.structs import Camera

PIXEL_CENTER = wp.constant(pixels.PIXEL_CENTER)
# Neighboring threads take pixels along columns of bands of so many rows, so that the rays of a warp look one way.
BAND = wp.constant(4)


@wp.struct
class Ray:
    """origin + t * direction, unit direction; the clipping range is tmin < t < tmax.

    Where the lens lets no light in, tmax < tmin.
    """

    origin: wp.vec3
    direction: wp.vec3
    tmin: wp.float32
    tmax: wp.float32


@wp.func
def lens_point(camera: Camera, lens: wp.vec2):
    r = camera.lens_radius * wp.sqrt(lens[0])
    around = cos_sin(lens[1])
    return wp.vec3(r * around[0], r * around[1], 0.0)


@wp.func
def curved_ray(camera: Camera, column: float, row: float, lens: wp.vec2):
    """`camera_ray` through a lens that is no pinhole."""
    towards = wp.vec3(0.0)
    eye = wp.vec3(0.0)
    if camera.lens_kind == PANORAMA:
        towards = panorama_direction(column / float(camera.width), row / float(camera.height))
        eye = panorama_eye(camera.lens.eye, column / float(camera.width))
    else:
        plane = wp.vec2((column - camera.cx) / camera.fx, (row - camera.cy) / camera.fy)
        towards = lens_direction(camera.lens, plane)
    if towards[0] == 0.0 and towards[1] == 0.0 and towards[2] == 0.0:
        return Ray(origin=camera.origin, direction=camera.rotation * wp.vec3(0.0, 0.0, -1.0), tmin=1.0, tmax=-1.0)
    start = wp.vec3(0.0)
    # Clipping range and focus count along the axis of a flat lens, and along the rays of others, that look sideways.
    per_depth = float(1.0)
    if camera.lens_kind == FLAT:
        per_depth = -1.0 / towards[2]
    if camera.lens_radius > 0.0:
        start = lens_point(camera, lens)
        towards = wp.normalize(towards * (camera.focus_distance * per_depth) - start)
        if camera.lens_kind == FLAT:
            per_depth = -1.0 / towards[2]
    return Ray(
        origin=camera.origin + camera.rotation * (eye + start),
        direction=camera.rotation * towards,
        tmin=camera.near * per_depth,
        tmax=camera.far * per_depth,
    )


@wp.func
def camera_ray(camera: Camera, column: float, row: float, lens: wp.vec2):
    """The ray through a point of the picture [pixels] and a point of the lens (two numbers in [0, 1))."""
    if camera.lens_kind != NONE:
        return curved_ray(camera, column, row, lens)
    x = (column - camera.cx) / camera.fx
    y = (camera.cy - row) / camera.fy
    start = wp.vec3(0.0)
    towards = wp.vec3(x, y, -1.0)
    if camera.orthographic != 0:
        start = wp.vec3(x, y, 0.0)
        towards = wp.vec3(0.0, 0.0, -1.0)
    elif camera.lens_radius > 0.0:
        start = lens_point(camera, lens)
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


@wp.func
def pixel_ray(camera: Camera, x: int, y: int):
    """The ray through the center of a pixel and the center of the lens."""
    return camera_ray(camera, float(x) + PIXEL_CENTER, float(y) + PIXEL_CENTER, wp.vec2(0.0))
