"""Camera rays."""

import warp as wp

from usdsdg.stage.cameras import pixels
from usdsdg_render.kernels.cameras.lens import FLAT, NONE, PANORAMA, lens_direction, panorama_direction, panorama_origin
from usdsdg_render.kernels.trig import cos_sin
from usdsdg_render.scene.structs import Camera

PIXEL_CENTER = wp.constant(pixels.PIXEL_CENTER)
# Rows of the bands along whose columns threads take pixels, so that the rays of a warp are coherent.
BAND = wp.constant(4)


@wp.struct
class Ray:
    """origin + t * direction, unit direction; the clipping range is tmin < t < tmax.

    Where the lens transmits no light, tmax < tmin.
    """

    origin: wp.vec3
    direction: wp.vec3
    tmin: wp.float32
    tmax: wp.float32


@wp.func
def lens_sample(camera: Camera, lens: wp.vec2):
    """Map two numbers in [0, 1) to a point of the lens disk in the camera's frame."""
    r = camera.lens_radius * wp.sqrt(lens[0])
    around = cos_sin(lens[1])
    return wp.vec3(r * around[0], r * around[1], 0.0)


@wp.func
def lens_ray(camera: Camera, column: float, row: float, lens: wp.vec2):
    """Return the ray of a camera with a `Lens` record; see `camera_ray`."""
    direction = wp.vec3(0.0)
    origin = wp.vec3(0.0)
    if camera.lens_kind == PANORAMA:
        direction = panorama_direction(column / float(camera.width), row / float(camera.height))
        origin = panorama_origin(camera.lens.eye_offset, column / float(camera.width))
    else:
        plane = wp.vec2((column - camera.cx) / camera.fx, (row - camera.cy) / camera.fy)
        direction = lens_direction(camera.lens, plane)
    if direction[0] == 0.0 and direction[1] == 0.0 and direction[2] == 0.0:
        return Ray(origin=camera.origin, direction=camera.rotation * wp.vec3(0.0, 0.0, -1.0), tmin=1.0, tmax=-1.0)
    lens_offset = wp.vec3(0.0)
    # Clipping range and focus distance count along the axis for a flat lens, and along the ray for all others.
    per_depth = float(1.0)
    if camera.lens_kind == FLAT:
        per_depth = -1.0 / direction[2]
    if camera.lens_radius > 0.0:
        lens_offset = lens_sample(camera, lens)
        direction = wp.normalize(direction * (camera.focus_distance * per_depth) - lens_offset)
        if camera.lens_kind == FLAT:
            per_depth = -1.0 / direction[2]
    return Ray(
        origin=camera.origin + camera.rotation * (origin + lens_offset),
        direction=camera.rotation * direction,
        tmin=camera.near * per_depth,
        tmax=camera.far * per_depth,
    )


@wp.func
def camera_ray(camera: Camera, column: float, row: float, lens: wp.vec2):
    """Return the ray through a point of the image [pixels] and a point of the lens (two numbers in [0, 1))."""
    if camera.lens_kind != NONE:
        return lens_ray(camera, column, row, lens)
    x = (column - camera.cx) / camera.fx
    y = (camera.cy - row) / camera.fy
    if camera.orthographic != 0:
        # Queries count from the origin on, so rays start at a near plane that is behind the camera.
        behind = wp.max(-camera.near, 0.0)
        return Ray(
            origin=camera.origin + camera.rotation * wp.vec3(x, y, behind),
            direction=camera.rotation * wp.vec3(0.0, 0.0, -1.0),
            tmin=camera.near + behind,
            tmax=camera.far + behind,
        )
    offset = wp.vec3(0.0)
    direction = wp.vec3(x, y, -1.0)
    if camera.lens_radius > 0.0:
        offset = lens_sample(camera, lens)
        direction = direction * camera.focus_distance - offset
    direction = wp.normalize(direction)
    # The clipping range counts along the axis, t along the ray.
    per_depth = -1.0 / direction[2]
    return Ray(
        origin=camera.origin + camera.rotation * offset,
        direction=camera.rotation * direction,
        tmin=camera.near * per_depth,
        tmax=camera.far * per_depth,
    )


@wp.func_native(
    """
#if !defined(__CUDA_ARCH__)
#pragma clang fp contract(off)
#endif
const auto& m = rotation.data;
const float length = sqrtf(x * x + y * y + 1.0f);
const float dx = x / length, dy = y / length, dz = -1.0f / length;
wp::vec_t<4, float> ray;
ray[0] = m[0][0] * dx + m[0][1] * dy + m[0][2] * dz;
ray[1] = m[1][0] * dx + m[1][1] * dy + m[1][2] * dz;
ray[2] = m[2][0] * dx + m[2][1] * dy + m[2][2] * dz;
ray[3] = length;
return ray;
"""
)
def direction_and_length(rotation: wp.mat33, x: float, y: float) -> wp.vec4: ...


@wp.func
def center_ray(camera: Camera, column: float, row: float):
    """Return the ray of a pinhole camera through a point of the image [pixels] and the center of the lens.

    `put_pixel_rays` computes the same bits for many pixels.
    """
    made = direction_and_length(camera.rotation, (column - camera.cx) / camera.fx, (camera.cy - row) / camera.fy)
    return Ray(
        origin=camera.origin,
        direction=wp.vec3(made[0], made[1], made[2]),
        tmin=camera.near * made[3],
        tmax=camera.far * made[3],
    )


@wp.func
def is_pinhole(camera: Camera):
    """Return whether rays through the center of the lens start at one point, and no lens model bends them."""
    return camera.lens_kind == NONE and camera.orthographic == 0


@wp.func
def pixel_ray(camera: Camera, x: int, y: int):
    """Return the ray through the center of a pixel and the center of the lens."""
    if is_pinhole(camera):
        return center_ray(camera, float(x) + PIXEL_CENTER, float(y) + PIXEL_CENTER)
    return camera_ray(camera, float(x) + PIXEL_CENTER, float(y) + PIXEL_CENTER, wp.vec2(0.0))
