"""Warp kernel over bodies on ball joints: turn them as their angular momentum has it."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

# The angular velocity of the middle of a substep depends on the rotation up to there, and that on it. Each round takes
# the error times the angle of half a substep, a few hundredths of a radian where tops are fast.
ROUNDS = wp.constant(4)


@wp.kernel(enable_backward=False)
def turn_tops(
    # top
    bodies: wp.array[wp.int32],
    joints: wp.array[wp.int32],
    gravity: wp.array[wp.vec3],
    dt: wp.float32,
    # joint
    joint_q_start: wp.array[wp.int32],
    joint_qd_start: wp.array[wp.int32],
    parent: wp.array[wp.int32],  # a body that nothing moves but its own velocity, or the world (-1)
    in_parent: wp.array[wp.transform],  # its frame in that of the parent
    in_child: wp.array[wp.transform],  # its frame in the body's
    # body
    mass: wp.array[wp.float32],
    inertia: wp.array[wp.mat33],
    center: wp.array[wp.vec3],
    touched: wp.array[wp.int32],
    body_f: wp.array[wp.spatial_vector],
    previous_body_q: wp.array[wp.transform],
    previous_body_qd: wp.array[wp.spatial_vector],
    # out
    joint_q: wp.array[wp.float32],
    joint_qd: wp.array[wp.float32],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
):
    """Turn each top that is not `touched`, and whose joint stands still, about its joint for `dt` seconds.

    Its angular momentum about the joint gets half of what turns it in the substep before the rotation, by the angular
    velocity of the middle, and half after it: as much as it loses when time goes back, so no energy comes or goes.
    In floats fast tops would gain half a percent of their spin in a second.
    """
    body = bodies[wp.tid()]
    joint = joints[wp.tid()]
    if touched[body] != 0:
        return
    frame = in_parent[joint]
    held = parent[joint]
    if held >= 0:
        if wp.length_sq(previous_body_qd[held]) > 0.0:
            return
        frame = previous_body_q[held] * frame
    start = wp.normalize(wp.quatd(wp.transform_get_rotation(previous_body_q[body])))
    arm = wp.vec3d(center[body] - wp.transform_get_translation(in_child[joint]))  # in the body's frame
    spin = wp.vec3d(wp.spatial_bottom(previous_body_qd[body]))
    pushed = wp.vec3d(mass[body] * gravity[0] + wp.spatial_top(body_f[body]))
    torque = wp.vec3d(wp.spatial_bottom(body_f[body]))
    moved = wp.length_sq(arm) * wp.identity(n=3, dtype=wp.float64) - wp.outer(arm, arm)
    about_joint = wp.mat33d(inertia[body]) + wp.float64(mass[body]) * moved
    inverse = wp.inverse(about_joint)
    step = wp.float64(dt)
    half = wp.float64(0.5) * step

    momentum = wp.quat_rotate(start, about_joint * wp.quat_rotate_inv(start, spin))
    momentum += half * (torque + wp.cross(wp.quat_rotate(start, arm), pushed))
    spin = wp.vec3d(wp.spatial_bottom(body_qd[body]))
    for _ in range(ROUNDS):
        middle = turned(start, half * spin)
        spin = wp.quat_rotate(middle, inverse * wp.quat_rotate_inv(middle, momentum))
    end = turned(start, step * spin)
    momentum += half * (torque + wp.cross(wp.quat_rotate(end, arm), pushed))
    spin = wp.quat_rotate(end, inverse * wp.quat_rotate_inv(end, momentum))

    rotation = wp.quatf(end)
    position = wp.transform_get_translation(frame)
    position -= wp.quat_rotate(rotation, wp.transform_get_translation(in_child[joint]))
    body_q[body] = wp.transform(position, rotation)
    body_qd[body] = wp.spatial_vector(wp.vec3f(wp.cross(spin, wp.quat_rotate(end, arm))), wp.vec3f(spin))
    own = wp.quat_inverse(wp.transform_get_rotation(frame)) * rotation * wp.transform_get_rotation(in_child[joint])
    turning = wp.quat_rotate_inv(wp.transform_get_rotation(frame), wp.vec3f(spin))
    for i in range(4):
        joint_q[joint_q_start[joint] + i] = own[i]
    for i in range(3):
        joint_qd[joint_qd_start[joint] + i] = turning[i]


@wp.func
def turned(rotation: wp.quatd, turn: wp.vec3d):
    """Return a rotation, turned about a vector by its length [rad]."""
    angle = wp.length(turn)
    if angle > wp.float64(0.0):
        rotation = wp.normalize(wp.quat_from_axis_angle(turn / angle, angle) * rotation)
    return rotation
