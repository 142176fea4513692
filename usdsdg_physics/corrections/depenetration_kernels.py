"""Warp kernels that let bodies out of a collider that appeared around them."""

from __future__ import annotations

import warp as wp

MARGIN = wp.constant(0.05)  # m


@wp.kernel
def hurry_out(
    # scene
    time_left: wp.array[wp.float32],
    reach: wp.array[wp.float32],
    shape_body: wp.array[wp.int32],
    # body
    body_q: wp.array[wp.transform],
    # contact
    count: wp.array[wp.int32],
    shape0: wp.array[wp.int32],
    shape1: wp.array[wp.int32],
    point0: wp.array[wp.vec3],
    point1: wp.array[wp.vec3],
    normal: wp.array[wp.vec3],
    margin0: wp.array[wp.float32],
    margin1: wp.array[wp.float32],
    # out
    max_depenetration_velocity: wp.array[wp.float32],
):
    """Raise the speed at which a body may be pushed out, when it holds the middle of a collider that is new there.

    `time_left` [s] is positive for the shapes that appeared; `reach` [m] is the distance from a shape's middle to its
    surface. The speed is what frees the middle in that time.
    """
    contact = wp.tid()
    if contact >= count[0]:
        return
    shape = int(shape0[contact])
    other = int(shape1[contact])
    if shape < 0 or other < 0:
        return
    if time_left[shape] <= 0.0:
        shape = int(shape1[contact])
        other = int(shape0[contact])
    body = shape_body[other]
    if time_left[shape] <= 0.0 or body < 0:
        return
    on0 = wp.vec3(point0[contact])
    on1 = wp.vec3(point1[contact])
    if shape_body[shape0[contact]] >= 0:
        on0 = wp.transform_point(body_q[body], on0)
    else:
        on1 = wp.transform_point(body_q[body], on1)
    depth = wp.dot(normal[contact], on0 - on1) + margin0[contact] + margin1[contact]
    too_deep = depth - reach[shape]
    if too_deep > 0.0:
        wp.atomic_max(max_depenetration_velocity, body, (too_deep + MARGIN) / time_left[shape])


@wp.kernel
def calm_down(
    # body
    dynamic: wp.array[wp.int32],
    speed_kept: wp.array[wp.float32],
    before: wp.array[wp.spatial_vector],
    # out
    joint_qd: wp.array[wp.float32],
    body_qd: wp.array[wp.spatial_vector],
):
    """Being pushed out is no momentum: no body leaves the step faster than it came, or than `speed_kept` [m/s]."""
    body = wp.tid()
    velocity = wp.spatial_top(body_qd[body])
    most = wp.max(speed_kept[body], wp.length(wp.spatial_top(before[body])))
    speed = wp.length(velocity)
    if dynamic[body] == 0 or speed <= most:
        return
    velocity = velocity * (most / speed)
    body_qd[body] = wp.spatial_vector(velocity, wp.spatial_bottom(body_qd[body]))
    for i in range(3):
        joint_qd[6 * body + i] = velocity[i]
