"""Drag of links, and their highest velocities."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp


@wp.kernel(enable_backward=False)
def drag_links(
    trees: wp.array[wp.int32],  # the first link of each, and how many there are
    # link
    links: wp.array[wp.int32],  # its body
    against: wp.array[wp.int32],  # body by whose motion the drag is zero, which it pushes back; -1: the world
    dt: float,
    # body
    linear_damping: wp.array[wp.float32],  # 1/s
    angular_damping: wp.array[wp.float32],
    body_mass: wp.array[wp.float32],
    body_inertia: wp.array[wp.mat33],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    # out
    body_f: wp.array[wp.spatial_vector],
):
    """Add the forces by which links of a tree lose their velocities, or those against their parents."""
    tree = wp.tid()
    for row in range(trees[tree], trees[tree + 1]):
        body = links[row]
        other = against[row]
        # What would stop it within the step stops it, as for free bodies.
        linear = wp.min(linear_damping[body], 1.0 / dt)
        angular = wp.min(angular_damping[body], 1.0 / dt)
        spin = wp.spatial_bottom(body_qd[body])
        force = wp.vec3(0.0)
        if other >= 0:
            spin -= wp.spatial_bottom(body_qd[other])
        else:
            force = -linear * body_mass[body] * wp.spatial_top(body_qd[body])
        rotation = wp.transform_get_rotation(body_q[body])
        torque = -angular * wp.quat_rotate(rotation, body_inertia[body] * wp.quat_rotate_inv(rotation, spin))
        body_f[body] = body_f[body] + wp.spatial_vector(force, torque)
        if other >= 0:
            body_f[other] = body_f[other] - wp.spatial_vector(wp.vec3(0.0), torque)


@wp.kernel(enable_backward=False)
def limit_links(
    links: wp.array[wp.int32],
    dt: float,
    # body
    max_velocity: wp.array[wp.float32],
    max_angular_velocity: wp.array[wp.float32],
    body_mass: wp.array[wp.float32],
    body_inertia: wp.array[wp.mat33],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    # out
    body_f: wp.array[wp.spatial_vector],
):
    """Add the forces that take from links, if they were free, the velocity that is above their limits in a step."""
    body = links[wp.tid()]
    velocity = wp.spatial_top(body_qd[body])
    spin = wp.spatial_bottom(body_qd[body])
    speed = wp.length(velocity)
    turning = wp.length(spin)
    force = wp.vec3(0.0)
    torque = wp.vec3(0.0)
    if speed > max_velocity[body]:
        force = (body_mass[body] * (max_velocity[body] / speed - 1.0) / dt) * velocity
    if turning > max_angular_velocity[body]:
        rotation = wp.transform_get_rotation(body_q[body])
        change = (max_angular_velocity[body] / turning - 1.0) * spin
        torque = wp.quat_rotate(rotation, body_inertia[body] * wp.quat_rotate_inv(rotation, change)) / dt
    body_f[body] = body_f[body] + wp.spatial_vector(force, torque)
