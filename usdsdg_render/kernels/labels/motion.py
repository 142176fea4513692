"""Motion vectors of cameras without a lens model, from the previous frame of each camera."""

import warp as wp

from usdsdg_render.scene.structs import Camera, Hit


@wp.struct
class PreviousInstance:
    """Pose and shape of an instance in a previous frame."""

    known: wp.int32  # 1 = the instance existed
    local_to_world: wp.mat33
    world_origin: wp.vec3
    corners: wp.uint64  # corners of its triangles in that frame (vec3); 0 = they have not moved


@wp.struct
class PreviousFrame:
    """The previous frame of each camera: its pose, and those of all instances."""

    cameras: wp.array(dtype=Camera)
    frames: wp.array(dtype=wp.int32)  # per camera: row of `instances`
    instances: wp.array2d(dtype=PreviousInstance)  # (frames, instances)


@wp.func
def previous_point(instance: PreviousInstance, hit: Hit, local: wp.vec3):
    """Return the world position in the previous frame of a hit point, now at `local` in its instance's frame."""
    p = local
    if instance.corners != wp.uint64(0):
        first = 3 * hit.triangle
        corners = wp.array(ptr=instance.corners, shape=(first + 3,), dtype=wp.vec3)
        p = corners[first] * (1.0 - hit.u - hit.v) + corners[first + 1] * hit.u + corners[first + 2] * hit.v
    return instance.local_to_world * p + instance.world_origin


@wp.func
def pixel_of(camera: Camera, point: wp.vec3, at_infinity: bool):
    """Project a point: (column, row, 1); (0, 0, 0) if it has no pixel. A direction stands for a point at infinity."""
    p = point
    if not at_infinity:
        p = point - camera.origin
    p = wp.transpose(camera.rotation) * p
    if camera.orthographic != 0:
        if at_infinity:
            return wp.vec3(0.0)
        return wp.vec3(camera.cx + camera.fx * p[0], camera.cy - camera.fy * p[1], 1.0)
    if p[2] >= -1.0e-12:
        return wp.vec3(0.0)
    return wp.vec3(camera.cx - camera.fx * p[0] / p[2], camera.cy + camera.fy * p[1] / p[2], 1.0)


@wp.func
def motion(camera: Camera, previous_camera: Camera, point: wp.vec3, previous: wp.vec3, at_infinity: bool):
    """Return the motion vector [pixels]: +x moved left, +y moved up."""
    a = pixel_of(camera, point, at_infinity)
    b = pixel_of(previous_camera, previous, at_infinity)
    if a[2] == 0.0 or b[2] == 0.0:
        return wp.vec2(0.0)
    return wp.vec2(b[0] - a[0], b[1] - a[1])
