"""Warp kernel over bodies: undo motion along and about locked axes."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

from usdsdg_physics.corrections.bodies.free_bodies import set_free_body


@wp.kernel(enable_backward=False)
def lock_velocities(
    # body
    locked_position: wp.array[wp.int32],
    locked_rotation: wp.array[wp.int32],
    dof: wp.array[wp.int32],
    # out
    joint_qd: wp.array[wp.float32],
    body_qd: wp.array[wp.spatial_vector],
):
    """Clear the velocities along and about locked axes; see `lock_axes`."""
    body = wp.tid()
    locked = locked_position[body] | (locked_rotation[body] << 3)
    velocity = body_qd[body]
    for i in range(6):
        if (locked & (1 << i)) != 0:
            velocity[i] = 0.0
            joint_qd[dof[body] + i] = 0.0
    body_qd[body] = velocity


@wp.kernel(enable_backward=False)
def lock_axes(
    # body
    locked_position: wp.array[wp.int32],
    locked_rotation: wp.array[wp.int32],
    coordinate: wp.array[wp.int32],
    dof: wp.array[wp.int32],
    center: wp.array[wp.vec3],
    previous_body_q: wp.array[wp.transform],
    # out
    joint_q: wp.array[wp.float32],
    joint_qd: wp.array[wp.float32],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
):
    """Keep the center of mass where it was along locked axes, and turn about the others only.

    Bits 1, 2 and 4 of `locked_position` and `locked_rotation` are the world's x, y and z.
    """
    body = wp.tid()
    positions = int(locked_position[body])
    rotations = int(locked_rotation[body])
    if positions == 0 and rotations == 0:
        return
    before = previous_body_q[body]
    after = body_q[body]
    velocity = wp.spatial_top(body_qd[body])
    angular = wp.spatial_bottom(body_qd[body])
    start = wp.transform_point(before, center[body])
    end = wp.transform_point(after, center[body])
    rotation = wp.transform_get_rotation(after)
    for axis in range(3):
        if (positions & (1 << axis)) != 0:
            velocity[axis] = 0.0
            end[axis] = start[axis]
        if (rotations & (1 << axis)) != 0:
            angular[axis] = 0.0
    if rotations != 0:
        # By how far the solver turned it, which the velocity does not tell where it also pushed bodies apart.
        turn = rotation_vector(rotation * wp.quat_inverse(wp.transform_get_rotation(before)))
        for axis in range(3):
            if (rotations & (1 << axis)) != 0:
                turn[axis] = 0.0
        rotation = wp.transform_get_rotation(before)
        angle = wp.length(turn)
        if angle > 0.0:
            rotation = wp.normalize(wp.quat_from_axis_angle(wp.normalize(turn), angle) * rotation)
    position = end - wp.quat_rotate(rotation, center[body])
    pose = wp.transform(position, rotation)
    set_free_body(body, pose, velocity, angular, coordinate, dof, joint_q, joint_qd, body_q, body_qd)


@wp.func
def rotation_vector(rotation: wp.quat):
    """Return the axis of a rotation times its angle [rad], which is at most pi."""
    axis = wp.vec3(rotation[0], rotation[1], rotation[2])
    size = wp.length(axis)
    if size == 0.0:
        return axis
    if rotation[3] < 0.0:
        axis = -axis
    return axis * (2.0 * wp.atan2(size, wp.abs(rotation[3])) / size)
