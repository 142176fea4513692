"""Warp kernel over joints: the forces and torques that they pass on."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp


@wp.kernel(enable_backward=False)
def add_joint_forces(
    # joint
    child: wp.array[wp.int32],
    body: wp.array[wp.int32],
    frame: wp.array[wp.transform],
    sign: wp.array[wp.float32],
    # body
    center: wp.array[wp.vec3],
    body_q: wp.array[wp.transform],
    wrench: wp.array[wp.spatial_vector],
    share: float,
    is_first: int,
    # out
    measured: wp.array[wp.spatial_vector],
):
    """Add a share of the `wrench` about the center of mass of each joint's child, in a `frame` of a `body`.

    A body below zero is the world. The first of a step replaces what was there.
    """
    row = wp.tid()
    place = frame[row]
    if body[row] >= 0:
        place = body_q[body[row]] * place
    load = wrench[child[row]]
    force = wp.spatial_top(load)
    arm = wp.transform_point(body_q[child[row]], center[child[row]]) - wp.transform_get_translation(place)
    torque = wp.spatial_bottom(load) + wp.cross(arm, force)
    turn = wp.transform_get_rotation(place)
    local = wp.spatial_vector(wp.quat_rotate_inv(turn, force), wp.quat_rotate_inv(turn, torque))
    if is_first == 1:
        measured[row] = local * (share * sign[row])
    else:
        measured[row] = measured[row] + local * (share * sign[row])
