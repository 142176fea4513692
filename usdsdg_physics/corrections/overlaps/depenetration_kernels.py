"""Warp kernels of depenetration: raise and clamp the velocity at which bodies are pushed out of a collider."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays

CLEARANCE = wp.constant(0.05)  # m, farther than the collider's center needs


@wp.kernel(enable_backward=False)
def raise_depenetration_velocity(
    # scene
    time_left: wp.array[wp.float32],
    half_thickness: wp.array[wp.float32],
    shape_body: wp.array[wp.int32],
    # body
    body_q: wp.array[wp.transform],
    contacts: ContactArrays,
    # out
    max_depenetration_velocity: wp.array[wp.float32],
):
    """Raise the maximum depenetration velocity of bodies that contain the center of a collider that just appeared.

    `time_left` [s] is positive for the shapes that appeared; `half_thickness` [m] is the distance from a shape's center
    to its surface. The velocity is what frees the center in that time.
    """
    contact = wp.tid()
    if contact >= contacts.count[0]:
        return
    shape = int(contacts.shape0[contact])
    other = int(contacts.shape1[contact])
    if shape < 0 or other < 0:
        return
    if time_left[shape] <= 0.0:
        shape = int(contacts.shape1[contact])
        other = int(contacts.shape0[contact])
    body = shape_body[other]
    if time_left[shape] <= 0.0 or body < 0:
        return
    point0 = wp.vec3(contacts.point0[contact])
    point1 = wp.vec3(contacts.point1[contact])
    if shape_body[contacts.shape0[contact]] >= 0:
        point0 = wp.transform_point(body_q[body], point0)
    else:
        point1 = wp.transform_point(body_q[body], point1)
    depth = wp.dot(contacts.normal[contact], point0 - point1) + contacts.margin0[contact] + contacts.margin1[contact]
    excess = depth - half_thickness[shape]
    if excess > 0.0:
        wp.atomic_max(max_depenetration_velocity, body, (excess + CLEARANCE) / time_left[shape])


@wp.kernel(enable_backward=False)
def clamp_depenetration_velocity(
    # scene
    any_left: wp.array[wp.int32],
    # body
    free: wp.array[wp.int32],
    dof: wp.array[wp.int32],
    max_depenetration_velocity: wp.array[wp.float32],
    previous_body_qd: wp.array[wp.spatial_vector],
    # out
    joint_qd: wp.array[wp.float32],
    body_qd: wp.array[wp.spatial_vector],
):
    """Let no body leave a step faster than it entered it, or than its authored maximum depenetration velocity [m/s].

    Where `any_left` (1,) is zero, no collider has pushed.
    """
    body = wp.tid()
    if any_left[0] == 0:
        return
    velocity = wp.spatial_top(body_qd[body])
    limit = wp.max(max_depenetration_velocity[body], wp.length(wp.spatial_top(previous_body_qd[body])))
    speed = wp.length(velocity)
    if free[body] == 0 or speed <= limit:
        return
    velocity = velocity * (limit / speed)
    body_qd[body] = wp.spatial_vector(velocity, wp.spatial_bottom(body_qd[body]))
    for i in range(3):
        joint_qd[dof[body] + i] = velocity[i]


@wp.kernel(enable_backward=False)
def count_down(dt: wp.float32, time_left: wp.array[wp.float32], any_left: wp.array[wp.int32]):
    """Take `dt` from the time [s] that each shape pushes, and set `any_left` (1,) where some is left."""
    shape = wp.tid()
    left = wp.max(time_left[shape] - dt, 0.0)
    if left < 1.0e-4:
        left = 0.0
    time_left[shape] = left
    if left > 0.0:
        any_left[0] = 1
