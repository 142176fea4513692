"""Warp kernels over joints: which break, and how much they rub."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

# To the solver a strength of zero is unlimited.
LEAST_FRICTION = wp.constant(1.0e-9)


@wp.kernel(enable_backward=False)
def note_broken(
    # joint
    breakable: wp.array[wp.int32],
    limits: wp.array[wp.vec2],
    joint_child: wp.array[wp.int32],
    joint_X_c: wp.array[wp.transform],
    # body
    center: wp.array[wp.vec3],
    body_q: wp.array[wp.transform],
    wrench: wp.array[wp.spatial_vector],
    more: wp.array[wp.spatial_vector],
    # out
    broken: wp.array[wp.int32],
):
    """Set `broken` of joints whose force [N], or torque [N m] about the joint's frame, is above its limit.

    Both are the sum of `wrench` and `more`, about the center of mass of the joint's child.
    """
    row = wp.tid()
    joint = breakable[row]
    body = joint_child[joint]
    load = wrench[body] + more[body]
    force = wp.spatial_top(load)
    at = wp.transform_point(body_q[body], wp.transform_get_translation(joint_X_c[joint]))
    arm = wp.transform_point(body_q[body], center[body]) - at
    torque = wp.spatial_bottom(load) + wp.cross(arm, force)
    if wp.length(force) > limits[row][0] or wp.length(torque) > limits[row][1]:
        broken[row] = 1


@wp.kernel(enable_backward=False)
def set_friction(
    # joint
    rubbing: wp.array[wp.vec2i],
    friction: wp.array[wp.vec2],
    joint_child: wp.array[wp.int32],
    # body
    wrench: wp.array[wp.spatial_vector],
    more: wp.array[wp.spatial_vector],
    # out
    joint_effort_limit: wp.array[wp.float32],
):
    """Set the strength of the drives that stand for friction: a constant part, and one that grows with the load."""
    row = wp.tid()
    body = joint_child[rubbing[row][0]]
    load = wrench[body] + more[body]
    total = wp.length(wp.spatial_top(load)) + wp.length(wp.spatial_bottom(load))
    joint_effort_limit[rubbing[row][1]] = wp.max(friction[row][0] + friction[row][1] * total, LEAST_FRICTION)
