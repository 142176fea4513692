"""Warp kernels over trees that float."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

TINY = wp.constant(1.0e-12)  # of the cube of a moment of inertia: below this, nothing resists a turn about a line


@wp.kernel(enable_backward=False)
def keep_momentum(
    # tree
    starts: wp.array[wp.int32],  # its first body in `bodies`, the base, and at last how many there are
    bodies: wp.array[wp.int32],
    coordinates: wp.array[wp.int32],  # of the base in joint_q
    dofs: wp.array[wp.int32],  # of the base in joint_qd
    gravity: wp.array[wp.vec3],
    dt: wp.float32,
    # body
    mass: wp.array[wp.float32],
    inertia: wp.array[wp.mat33],
    center: wp.array[wp.vec3],
    linear_damping: wp.array[wp.float32],
    angular_damping: wp.array[wp.float32],
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
    """Add to the velocities of a tree of which no body is `touched` the rigid motion that its momentum lacks.

    Its center of mass is moved to where the velocity brings it: the solver moves the base along a tangent, and the rest
    with it.
    """
    tree = wp.tid()
    begin, end = starts[tree], starts[tree + 1]
    base = bodies[begin]
    expected, found, total = wp.vec3(0.0), wp.vec3(0.0), wp.float32(0.0)
    before, now = wp.vec3(0.0), wp.vec3(0.0)  # centers of mass, from that of the base
    start = wp.transform_point(previous_body_q[base], center[base])
    place = wp.transform_point(body_q[base], center[base])
    for row in range(begin, end):
        body = bodies[row]
        if touched[body] != 0:
            return
        m = mass[body]
        total += m
        before += m * (wp.transform_point(previous_body_q[body], center[body]) - start)
        now += m * (wp.transform_point(body_q[body], center[body]) - place)
        expected += m * wp.spatial_top(previous_body_qd[body]) + dt * (m * gravity[0] + wp.spatial_top(body_f[body]))
        found += m * wp.spatial_top(body_qd[body])
    kept = wp.max(1.0 - linear_damping[base] * dt, 0.0)  # what the solver leaves of the base's velocity
    lacking = (kept * expected - found) / total
    before = before / total
    now = now / total
    shift = (start - place) + (before - now) + (dt * kept / total) * expected

    # About the centers of mass: what turns it, what it has, and what resists a turn of the whole.
    turning, spinning, resistance = wp.vec3(0.0), wp.vec3(0.0), wp.mat33(0.0)
    for row in range(begin, end):
        body = bodies[row]
        m = mass[body]
        arm = wp.transform_point(previous_body_q[body], center[body]) - start - before
        moment = m * wp.spatial_top(previous_body_qd[body]) + dt * wp.spatial_top(body_f[body])
        turning += wp.cross(arm, moment) + dt * wp.spatial_bottom(body_f[body])
        turning += in_world(previous_body_q[body], inertia[body]) * wp.spatial_bottom(previous_body_qd[body])
        arm = wp.transform_point(body_q[body], center[body]) - place - now
        own = in_world(body_q[body], inertia[body])
        spinning += m * wp.cross(arm, wp.spatial_top(body_qd[body])) + own * wp.spatial_bottom(body_qd[body])
        resistance += own + m * (wp.length_sq(arm) * wp.identity(n=3, dtype=wp.float32) - wp.outer(arm, arm))
    kept = wp.max(1.0 - angular_damping[base] * dt, 0.0)  # likewise of its spin, by which the whole tree turns
    spin = wp.vec3(0.0)
    scale = wp.trace(resistance)
    if kept > 0.0 and wp.determinant(resistance) > TINY * scale * scale * scale:
        damped = (1.0 / kept - 1.0) * (resistance * wp.spatial_bottom(body_qd[base]))
        spin = wp.inverse(resistance) * (turning - damped - spinning)

    for row in range(begin, end):
        body = bodies[row]
        arm = wp.transform_point(body_q[body], center[body]) - place - now
        body_qd[body] = body_qd[body] + wp.spatial_vector(lacking + wp.cross(spin, arm), spin)
    for row in range(begin, end):
        pose = body_q[bodies[row]]
        body_q[bodies[row]] = wp.transform(wp.transform_get_translation(pose) + shift, wp.transform_get_rotation(pose))
    lacking -= wp.cross(spin, now)
    for i in range(3):
        joint_q[coordinates[tree] + i] = joint_q[coordinates[tree] + i] + shift[i]
        joint_qd[dofs[tree] + i] = joint_qd[dofs[tree] + i] + lacking[i]
        joint_qd[dofs[tree] + 3 + i] = joint_qd[dofs[tree] + 3 + i] + spin[i]


@wp.func
def in_world(pose: wp.transform, inertia: wp.mat33):
    """Return an inertia [kg m²], which is along the axes of a body, along those of the world."""
    rotation = wp.quat_to_matrix(wp.transform_get_rotation(pose))
    return rotation * inertia * wp.transpose(rotation)
