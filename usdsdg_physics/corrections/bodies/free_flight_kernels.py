"""Warp kernels of free flight: find the bodies that touch something, turn and move the others."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

from usdsdg_physics.corrections.bodies.free_bodies import set_free_body
from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays

# rad within a substep, below which the solver's own rotation has an error of no more than 1e-7 rad.
SMALL_TURN = wp.constant(0.01)


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


@wp.kernel(enable_backward=False)
def turn_bodies(
    # body
    free: wp.array[wp.int32],
    coordinate: wp.array[wp.int32],
    dof: wp.array[wp.int32],
    center: wp.array[wp.vec3],
    inverse_inertia: wp.array[wp.mat33],
    angular_damping: wp.array[wp.float32],
    touched: wp.array[wp.int32],
    body_f: wp.array[wp.spatial_vector],
    previous_body_q: wp.array[wp.transform],
    previous_body_qd: wp.array[wp.spatial_vector],
    dt: wp.float32,
    # out
    joint_q: wp.array[wp.float32],
    joint_qd: wp.array[wp.float32],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
):
    """Turn each body that is not `touched` by its angular velocity for `dt` seconds, about its center of mass.

    The rotation is by the angular velocity of the middle of the substep. The solver has found the velocity at its end
    for the axes that the body had at its begin; that velocity turns with the axes here.
    """
    body = wp.tid()
    angular = wp.spatial_bottom(body_qd[body])
    if free[body] == 0 or touched[body] != 0 or not wp.length(angular) * dt > SMALL_TURN:
        return
    kept = wp.max(1.0 - angular_damping[body] * dt, 0.0)
    if kept == 0.0:
        return
    start = wp.transform_get_rotation(previous_body_q[body])
    torque = wp.quat_rotate_inv(start, wp.spatial_bottom(body_f[body]))
    pushed = wp.quat_rotate(start, dt * (inverse_inertia[body] * torque))
    spin = angular / kept - pushed
    middle = 0.5 * (wp.spatial_bottom(previous_body_qd[body]) + spin)
    angular = kept * (wp.quat_rotate(rotation_of(middle * dt), spin) + pushed)
    rotation = wp.normalize(rotation_of(kept * (middle + pushed) * dt) * start)
    # Far from the origin the arm to the center of mass would lose digits against the position.
    pose = body_q[body]
    arm = wp.quat_rotate(wp.transform_get_rotation(pose), center[body]) - wp.quat_rotate(rotation, center[body])
    pose = wp.transform(wp.transform_get_translation(pose) + arm, rotation)
    velocity = wp.spatial_top(body_qd[body])
    set_free_body(body, pose, velocity, angular, coordinate, dof, joint_q, joint_qd, body_q, body_qd)


@wp.func
def rotation_of(turn: wp.vec3):
    """Return the rotation about a vector by its length [rad]."""
    angle = wp.length(turn)
    rotation = wp.quat_identity()
    if angle > 0.0:
        rotation = wp.quat_from_axis_angle(turn / angle, angle)
    return rotation
