"""Warp kernels over bodies: velocities before contacts act, and poses after them."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

from usdsdg_physics.contact_solver.arrays import Bodies

# Part of a turn [rad] within which the gyroscopic torque is integrated at once, and how often at most in a step.
GYROSCOPIC_TURN = wp.constant(0.2)
MAX_GYROSCOPIC_STEPS = wp.constant(16)
GYROSCOPIC_ITERATIONS = wp.constant(4)


@wp.kernel(enable_backward=False)
def begin_step(
    # body
    moves: wp.array[wp.int32],
    dof: wp.array[wp.int32],
    armature: wp.array[wp.float32],
    body_mass_inverse: wp.array[wp.float32],
    body_inertia: wp.array[wp.mat33],
    body_inertia_inverse: wp.array[wp.mat33],
    body_center: wp.array[wp.vec3],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    body_f: wp.array[wp.spatial_vector],
    gravity: wp.array[wp.vec3],
    dt: wp.float32,
    # out
    bodies: Bodies,
):
    """Fill `bodies` with the velocities that forces alone would give; the last row is the world.

    `armature` is mass [kg] and moment of inertia [kg m²] that a body has besides its own, along and about the axes of
    the world.
    """
    body = wp.tid()
    bodies.overflow_count[body] = 0
    bodies.moves[body] = 0
    bodies.inverse_mass[body] = wp.vec3(0.0)
    bodies.inverse_inertia[body] = wp.mat33(0.0)
    if body >= body_q.shape[0]:
        bodies.center[body] = wp.vec3(0.0)
        bodies.velocity[body] = wp.vec3(0.0)
        bodies.angular[body] = wp.vec3(0.0)
        return
    velocity = wp.spatial_top(body_qd[body])
    angular = wp.spatial_bottom(body_qd[body])
    bodies.center[body] = wp.transform_point(body_q[body], body_center[body])
    if moves[body] != 0:
        rotation = wp.quat_to_matrix(wp.transform_get_rotation(body_q[body]))
        mass = 1.0 / body_mass_inverse[body]
        more_mass = wp.vec3(0.0)
        more_inertia = wp.vec3(0.0)
        if dof[body] >= 0:
            for i in range(3):
                more_mass[i] = armature[dof[body] + i]
                more_inertia[i] = armature[dof[body] + 3 + i]
        inverse = rotation * body_inertia_inverse[body] * wp.transpose(rotation)
        if wp.length(more_inertia) > 0.0:
            inverse = wp.inverse(rotation * body_inertia[body] * wp.transpose(rotation) + wp.diag(more_inertia))
        inverse_mass = wp.vec3(1.0 / (mass + more_mass[0]), 1.0 / (mass + more_mass[1]), 1.0 / (mass + more_mass[2]))
        bodies.moves[body] = 1
        bodies.inverse_mass[body] = inverse_mass
        bodies.inverse_inertia[body] = inverse
        velocity += dt * wp.cw_mul(inverse_mass, mass * gravity[0] + wp.spatial_top(body_f[body]))
        turning = wp.transpose(rotation) * angular
        turning = without_torque(turning, body_inertia[body], body_inertia_inverse[body], dt)
        angular = rotation * turning + dt * (inverse * wp.spatial_bottom(body_f[body]))
    bodies.velocity[body] = velocity
    bodies.angular[body] = angular


@wp.func
def without_torque(angular: wp.vec3, inertia: wp.mat33, inverse: wp.mat33, dt: float):
    """Return the angular velocity in the body's axes after `dt` seconds, by the implicit midpoint rule.

    It keeps energy and angular momentum, which the explicit torque would raise.
    """
    turn = wp.length(angular) * dt
    steps = wp.clamp(int(wp.ceil(turn / GYROSCOPIC_TURN)), 1, MAX_GYROSCOPIC_STEPS)
    h = dt / float(steps)
    current = angular
    for _ in range(steps):
        after = current
        for _ in range(GYROSCOPIC_ITERATIONS):
            middle = 0.5 * (current + after)
            after = current - h * (inverse * wp.cross(middle, inertia * middle))
        current = after
    return current


@wp.kernel(enable_backward=False)
def move_bodies(
    # body
    moves: wp.array[wp.int32],
    coordinate: wp.array[wp.int32],
    body_center: wp.array[wp.vec3],
    linear_damping: wp.array[wp.float32],
    angular_damping: wp.array[wp.float32],
    bodies: Bodies,
    body_q: wp.array[wp.transform],
    dt: wp.float32,
    # out
    moved_q: wp.array[wp.transform],
    joint_q: wp.array[wp.float32],
):
    """Move each body by its velocity for `dt` seconds."""
    body = wp.tid()
    pose = body_q[body]
    if moves[body] != 0:
        velocity = bodies.velocity[body] * wp.max(1.0 - linear_damping[body] * dt, 0.0)
        angular = bodies.angular[body] * wp.max(1.0 - angular_damping[body] * dt, 0.0)
        rotation = wp.transform_get_rotation(pose)
        angle = wp.length(angular) * dt
        if angle > 0.0:
            rotation = wp.normalize(wp.quat_from_axis_angle(wp.normalize(angular), angle) * rotation)
        # Far from the origin a small move and the arm to the center of mass would lose digits against the position.
        arm = wp.quat_rotate(wp.transform_get_rotation(pose), body_center[body]) - wp.quat_rotate(
            rotation, body_center[body]
        )
        pose = wp.transform(wp.transform_get_translation(pose) + (arm + velocity * dt), rotation)
    moved_q[body] = pose
    if coordinate[body] >= 0:
        for i in range(7):
            joint_q[coordinate[body] + i] = pose[i]


@wp.kernel(enable_backward=False)
def end_step(
    # body
    moves: wp.array[wp.int32],
    dof: wp.array[wp.int32],
    linear_damping: wp.array[wp.float32],
    angular_damping: wp.array[wp.float32],
    bodies: Bodies,
    dt: wp.float32,
    # out
    body_qd: wp.array[wp.spatial_vector],
    joint_qd: wp.array[wp.float32],
):
    """Publish the velocity of each body."""
    body = wp.tid()
    velocity = bodies.velocity[body]
    angular = bodies.angular[body]
    if moves[body] != 0:
        velocity *= wp.max(1.0 - linear_damping[body] * dt, 0.0)
        angular *= wp.max(1.0 - angular_damping[body] * dt, 0.0)
    body_qd[body] = wp.spatial_vector(velocity, angular)
    if dof[body] >= 0:
        for i in range(3):
            joint_qd[dof[body] + i] = velocity[i]
            joint_qd[dof[body] + 3 + i] = angular[i]
