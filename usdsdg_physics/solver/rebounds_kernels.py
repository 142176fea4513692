"""Warp functions of rebounds: how fast they are, and that they begin at the surface."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

FLIGHT = wp.constant(2.0)  # half the steps of a way up and down from which it is a flight
CONTACT = wp.constant(0)  # the solver's number of the type of a row


@wp.func
def rebound_speed(restitution: float, speed: float, pull: float, distance: float, dt: float, step: float):
    """Return the speed [m/s] with which surfaces part that meet with restitution.

    It takes them as far as the square of the restitution says of the way that the same `pull` [m/s²] would have needed
    to bring them together. Velocities are those of the end of a step [s], and carry a body at once: with a constant
    pull, half the square of its speed is less by `pull * step / 2` times the speed than the pull times the way.

    Args:
        speed: with which they approach, a `distance` [m] before they meet.
        pull: with which they are accelerated toward each other; below 0 where they are slowed down.
        dt: substep, by which bodies go that stay near a surface.
        step: the whole step, by which those go that leave it.
    """
    pulled = wp.max(pull, 0.0)
    lag = 0.5 * pulled * wp.where(restitution * speed > FLIGHT * pulled * step, step, dt)
    meeting = speed * speed + 2.0 * (pulled * distance + lag * speed)
    return lag + wp.sqrt(lag * lag + restitution * restitution * meeting)


@wp.kernel(enable_backward=False)
def land_first(
    # row, (1, R)
    count: wp.array[wp.int32],
    row_type: wp.array2d[wp.int32],
    distance: wp.array2d[wp.float32],  # m, before the substep
    target_velocity: wp.array2d[wp.float32],  # m/s, of surfaces that move; of no size where none does
    dof_a: wp.array2d[wp.int32],
    dof_b: wp.array2d[wp.int32],
    jacobian_a: wp.array3d[wp.float32],
    jacobian_b: wp.array3d[wp.float32],
    # velocities of joints, before the substep and after it without contacts
    dof: wp.array2d[wp.int32],
    joint_qd: wp.array[wp.float32],
    predicted: wp.array[wp.float32],
    dt: wp.float32,
    step: wp.float32,
    # in and out
    rebound_velocity: wp.array2d[wp.float32],  # m/s; 0 of what does not bounce
    right_side: wp.array2d[wp.float32],  # minus the velocity that the row asks for
):
    """Let rows that ask for a rebound ask for the velocity with which the surfaces just touch, and set that of after.

    `step` is the length of the whole step of which the substep of `dt` seconds is a part.
    """
    row = wp.tid()
    if row >= count[0] or row_type[0, row] != CONTACT:
        return
    rebound = rebound_velocity[0, row]
    apart = distance[0, row]
    if not rebound > 0.0 or not apart > 0.0:
        return
    target = wp.float32(0.0)
    if row < target_velocity.shape[1]:
        target = target_velocity[0, row]
    # A row that lets the surfaces come nearer asks for no rebound, as they do not meet in the substep.
    if right_side[0, row] + target >= 0.0:
        return
    speed = wp.float32(0.0)
    pull = wp.float32(0.0)
    for k in range(6):
        if dof_a[0, row] >= 0:
            at = dof[0, dof_a[0, row] + k]
            speed -= jacobian_a[0, row, k] * joint_qd[at]
            if k < 3:  # of centers of mass: how the spin of an uneven body sways brings nothing together
                pull -= jacobian_a[0, row, k] * (predicted[at] - joint_qd[at]) / dt
        if dof_b[0, row] >= 0:
            at = dof[0, dof_b[0, row] + k]
            speed -= jacobian_b[0, row, k] * joint_qd[at]
            if k < 3:
                pull -= jacobian_b[0, row, k] * (predicted[at] - joint_qd[at]) / dt
    right_side[0, row] = apart / dt - target
    if speed > 0.0:
        rebound_velocity[0, row] = rebound_speed(rebound / speed, speed, pull, apart, dt, step)
