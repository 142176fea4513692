"""Warp kernels of free flight: find the bodies that touch something, and move the others."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


@wp.kernel(enable_backward=False)
def note_touched(
    # scene
    shape_body: wp.array[wp.int32],
    contacts: ContactArrays,
    # out
    touched: wp.array[wp.int32],
):
    """Set `touched` of both bodies of each contact."""
    contact = wp.tid()
    if contact >= contacts.count[0] or contacts.shape0[contact] < 0 or contacts.shape1[contact] < 0:
        return
    first = shape_body[contacts.shape0[contact]]
    second = shape_body[contacts.shape1[contact]]
    if first >= 0:
        touched[first] = 1
    if second >= 0:
        touched[second] = 1


@wp.kernel(enable_backward=False)
def move_untouched(
    # body
    free: wp.array[wp.int32],
    coordinate: wp.array[wp.int32],
    center: wp.array[wp.vec3],
    touched: wp.array[wp.int32],
    start: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    dt: wp.float32,
    # out
    joint_q: wp.array[wp.float32],
    body_q: wp.array[wp.transform],
):
    """Move the center of mass [m, in the body's frame] of each body to `start` plus its velocity [m/s] times `dt`."""
    body = wp.tid()
    if free[body] == 0 or touched[body] != 0:
        return
    pose = body_q[body]
    moved = wp.transform_point(start[body], center[body]) + wp.spatial_top(body_qd[body]) * dt
    position = moved - wp.quat_rotate(wp.transform_get_rotation(pose), center[body])
    body_q[body] = wp.transform(position, wp.transform_get_rotation(pose))
    for i in range(3):
        joint_q[coordinate[body] + i] = position[i]
