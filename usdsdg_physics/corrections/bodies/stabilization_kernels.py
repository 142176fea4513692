"""Warp kernel over bodies: correct what the solver's step made of each."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018, RUF046

import warp as wp

from usdsdg_physics.corrections.bodies.free_bodies import set_free_body

# Speed below which a body in a pile may be at rest, in its radii of gyration [1/s].
REST_TURN = wp.constant(1.0)


@wp.kernel(enable_backward=False)
def stabilize_bodies(
    # body
    free: wp.array[wp.int32],
    coordinate: wp.array[wp.int32],
    dof: wp.array[wp.int32],
    gravity_enabled: wp.array[wp.int32],
    inertia_per_mass: wp.array[wp.float32],
    sleep_threshold: wp.array[wp.float32],
    asleep: wp.array[wp.int32],
    squeezed: wp.array[wp.int32],
    neighbors: wp.array[wp.int32],
    max_velocity: wp.array[wp.float32],
    max_angular_velocity: wp.array[wp.float32],
    previous_body_q: wp.array[wp.transform],
    # rest
    gravity: wp.array[wp.float64],
    dt: wp.float64,
    rest_gravity_fraction: wp.float64,
    rest_delay: wp.float32,
    # out
    joint_q: wp.array[wp.float32],
    joint_qd: wp.array[wp.float32],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    rest_time: wp.array[wp.float32],
    nonfinite_steps: wp.array[wp.int32],
):
    """Clamp the velocity of each body, hold bodies at rest or asleep, and revert a step that is not finite.

    A body whose kinetic energy per mass is below `rest_energy` for `rest_delay` seconds is held where it was, so that
    the last millimeters per second of the contact solver do not show as creep. Bodies that are `squeezed` are not held,
    since they are moved without speed; those `asleep` are held at once. `inertia_per_mass` is the mean moment of
    inertia over the mass [m²].
    """
    body = wp.tid()
    if free[body] == 0:
        return
    pose = body_q[body]
    velocity = wp.spatial_top(body_qd[body])
    angular = wp.spatial_bottom(body_qd[body])
    speed = wp.length(velocity)
    angular_speed = wp.length(angular)
    energy = 0.5 * (speed * speed + inertia_per_mass[body] * angular_speed * angular_speed)

    acceleration = rest_gravity_fraction * gravity[0]
    may_rest = energy < rest_energy(
        sleep_threshold[body], neighbors[body], inertia_per_mass[body], rest_time[body], rest_delay, acceleration, dt
    )
    hold = int(0)
    if not (wp.isfinite(speed) and wp.isfinite(angular_speed) and finite_transform(pose)):
        nonfinite_steps[body] = nonfinite_steps[body] + 1
        hold = 1
    elif asleep[body] != 0:
        hold = 1
    elif gravity_enabled[body] != 0 and squeezed[body] == 0 and may_rest:
        rest_time[body] = rest_time[body] + wp.float32(dt)
        if rest_time[body] >= rest_delay:
            hold = 1
    else:
        rest_time[body] = 0.0

    if hold != 0:
        pose = previous_body_q[body]
        velocity = wp.vec3(0.0, 0.0, 0.0)
        angular = wp.vec3(0.0, 0.0, 0.0)
    elif speed > max_velocity[body]:
        velocity = velocity * (max_velocity[body] / speed)
    if hold == 0 and angular_speed > max_angular_velocity[body]:
        angular = angular * (max_angular_velocity[body] / angular_speed)

    set_free_body(body, pose, velocity, angular, coordinate, dof, joint_q, joint_qd, body_q, body_qd)


@wp.func
def finite_transform(pose: wp.transform):
    """Return whether all seven numbers of a pose are finite."""
    total = float(0.0)
    for i in range(7):
        total += wp.abs(pose[i])
    return wp.isfinite(total)


@wp.func
def rest_energy(
    threshold: float,
    neighbors: int,
    inertia_per_mass: float,
    rest_time: float,
    rest_delay: float,
    acceleration: wp.float64,
    dt: wp.float64,
):
    """Return the kinetic energy per mass [m²/s²] below which a body may be at rest.

    That is its sleep `threshold`. This grows with the number of its neighbors, as in PhysX: what lies in a pile gets
    small impulses from all sides. It does not for small bodies, which would move far in proportion. And the speed must
    be below what an `acceleration` [m/s²], a fraction of gravity, alone would give it in one step: only a supported
    body stays below it for longer than an instant, and one that loses its support leaves at once. Until it has been at
    rest for `rest_delay` seconds the sleep threshold counts, below what the acceleration would give in that time: in
    short steps the former is less than the speed at which small things rock and roll on.
    """
    rest_speed = acceleration * dt
    in_pile = wp.min(threshold * wp.float32(1 + neighbors), 0.5 * inertia_per_mass * REST_TURN * REST_TURN)
    energy = wp.min(wp.max(threshold, in_pile), wp.float32(wp.float64(0.5) * rest_speed * rest_speed))
    if rest_time < rest_delay:
        slow_speed = acceleration * wp.float64(rest_delay)
        energy = wp.max(energy, wp.min(threshold, wp.float32(wp.float64(0.5) * slow_speed * slow_speed)))
    return energy
