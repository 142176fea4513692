"""Warp function over free bodies: set the pose and velocity of one wherever the solver keeps them."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp


@wp.func
def set_free_body(
    body: int,
    pose: wp.transform,
    velocity: wp.vec3,
    angular: wp.vec3,
    coordinate: wp.array[wp.int32],
    dof: wp.array[wp.int32],
    # out
    joint_q: wp.array[wp.float32],
    joint_qd: wp.array[wp.float32],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
):
    """Set a body's pose, and the velocity of its center of mass, in the world and as coordinates of its free joint."""
    body_q[body] = pose
    body_qd[body] = wp.spatial_vector(velocity, angular)
    for i in range(7):
        joint_q[coordinate[body] + i] = pose[i]
    for i in range(3):
        joint_qd[dof[body] + i] = velocity[i]
        joint_qd[dof[body] + 3 + i] = angular[i]
