"""Warp kernels over trees that float."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp


@wp.kernel(enable_backward=False)
def keep_momentum(
    # tree
    starts: wp.array[wp.int32],  # its first body in `bodies`, the base, and at last how many there are
    bodies: wp.array[wp.int32],
    dofs: wp.array[wp.int32],  # of the base in joint_qd
    gravity: wp.array[wp.vec3],
    dt: wp.float32,
    # body
    mass: wp.array[wp.float32],
    linear_damping: wp.array[wp.float32],
    touched: wp.array[wp.int32],
    previous_body_qd: wp.array[wp.spatial_vector],
    body_f: wp.array[wp.spatial_vector],
    # out
    joint_qd: wp.array[wp.float32],
    body_qd: wp.array[wp.spatial_vector],
):
    """Add to the velocity of a tree of which no body is `touched` what its momentum lacks."""
    tree = wp.tid()
    begin, end = starts[tree], starts[tree + 1]
    expected, found, total = wp.vec3(0.0), wp.vec3(0.0), wp.float32(0.0)
    for row in range(begin, end):
        body = bodies[row]
        if touched[body] != 0:
            return
        m = mass[body]
        total += m
        expected += m * wp.spatial_top(previous_body_qd[body]) + dt * (m * gravity[0] + wp.spatial_top(body_f[body]))
        found += m * wp.spatial_top(body_qd[body])
    kept = wp.max(1.0 - linear_damping[bodies[begin]] * dt, 0.0)  # what the solver leaves of the base's velocity
    lacking = (kept * expected - found) / total
    for row in range(begin, end):
        body = bodies[row]
        body_qd[body] = body_qd[body] + wp.spatial_vector(lacking, wp.vec3(0.0))
    for i in range(3):
        joint_qd[dofs[tree] + i] = joint_qd[dofs[tree] + i] + lacking[i]
