"""Warp kernels over links and trees of joints: what moving links carry, and steps that are not finite."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays

# Robots that stand still under their drives are ten times as slow.
MOVES = wp.constant(5.0e-5)  # m/s
TURNS = wp.constant(5.0e-4)  # rad/s


@wp.kernel(enable_backward=False)
def mark_moving_links(
    # body
    tree: wp.array[wp.int32],
    body_qd: wp.array[wp.spatial_vector],
    carried: wp.array[wp.int32],
    most: wp.int32,
    # out
    level: wp.array[wp.int32],
):
    """Give links that move the highest `level`, and the other bodies that at which they were `carried`."""
    body = wp.tid()
    if tree[body] < 0:
        level[body] = carried[body]
    elif wp.length(wp.spatial_top(body_qd[body])) > MOVES or wp.length(wp.spatial_bottom(body_qd[body])) > TURNS:
        level[body] = most
    else:
        level[body] = 0


@wp.kernel(enable_backward=False)
def wake_carried(
    # scene
    shape_body: wp.array[wp.int32],
    # body
    tree: wp.array[wp.int32],
    level: wp.array[wp.int32],
    contacts: ContactArrays,
    # out
    next_level: wp.array[wp.int32],
    rest_time: wp.array[wp.float32],
):
    """Clear `rest_time` of each body that touches one of a higher `level`; it is carried one level below that."""
    contact = wp.tid()
    if contact >= contacts.count[0] or contacts.shape0[contact] < 0 or contacts.shape1[contact] < 0:
        return
    first = shape_body[contacts.shape0[contact]]
    second = shape_body[contacts.shape1[contact]]
    if first < 0 or second < 0:
        return
    if tree[second] < 0 and level[first] > 1:
        wp.atomic_max(next_level, second, level[first] - 1)
        rest_time[second] = 0.0
    if tree[first] < 0 and level[second] > 1:
        wp.atomic_max(next_level, first, level[second] - 1)
        rest_time[first] = 0.0


@wp.kernel(enable_backward=False)
def revert_coordinates(
    # tree
    ranges: wp.array[wp.vec4i],
    previous_joint_q: wp.array[wp.float32],
    # out
    joint_q: wp.array[wp.float32],
    joint_qd: wp.array[wp.float32],
    is_finite: wp.array[wp.int32],
):
    """Restore the coordinates of a tree, at rest, where one of them is not finite."""
    tree = wp.tid()
    total = wp.float32(0.0)
    for i in range(ranges[tree][0], ranges[tree][1]):
        total += wp.abs(joint_q[i])
    for i in range(ranges[tree][2], ranges[tree][3]):
        total += wp.abs(joint_qd[i])
    is_finite[tree] = wp.where(wp.isfinite(total), 1, 0)
    if is_finite[tree] != 0:
        return
    for i in range(ranges[tree][0], ranges[tree][1]):
        joint_q[i] = previous_joint_q[i]
    for i in range(ranges[tree][2], ranges[tree][3]):
        joint_qd[i] = 0.0


@wp.kernel(enable_backward=False)
def revert_links(
    # body
    tree: wp.array[wp.int32],
    is_finite: wp.array[wp.int32],
    previous_body_q: wp.array[wp.transform],
    # out
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    nonfinite_steps: wp.array[wp.int32],
):
    """Put the links of reverted trees back to where they were."""
    body = wp.tid()
    if tree[body] < 0 or is_finite[tree[body]] != 0:
        return
    body_q[body] = previous_body_q[body]
    body_qd[body] = wp.spatial_vector()
    nonfinite_steps[body] = nonfinite_steps[body] + 1
