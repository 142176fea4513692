"""Warp kernel of kinematic motion: place the bodies that follow one."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp


@wp.kernel(enable_backward=False)
def place_bodies(
    # motion
    row: wp.array[wp.int32],
    poses: wp.array2d[wp.transform],
    substep: wp.int32,
    # body
    coordinate: wp.array[wp.int32],
    # out
    joint_q: wp.array[wp.float32],
    body_q: wp.array[wp.transform],
    teleported: wp.array[wp.int32],
):
    """Place each body with a `row` in `poses` (substep, row), which is -1 for the others.

    All body poses follow the joint coordinates, as where poses are set from outside; those of links, whose `coordinate`
    is -1, stay.
    """
    body = wp.tid()
    start = coordinate[body]
    if start < 0:
        return
    if row[body] >= 0:
        pose = poses[substep, row[body]]
        for i in range(7):
            joint_q[start + i] = pose[i]
        teleported[body] = 1
    position = wp.vec3(joint_q[start], joint_q[start + 1], joint_q[start + 2])
    rotation = wp.quat(joint_q[start + 3], joint_q[start + 4], joint_q[start + 5], joint_q[start + 6])
    body_q[body] = wp.transform(position, rotation)
