"""Warp kernels over bodies: what happens to a body after the solver has moved it."""
# ruff: noqa: UP018, RUF046

from __future__ import annotations

import warp as wp


@wp.kernel
def settle(
    # body
    dynamic: wp.array[wp.int32],
    pulled_by_gravity: wp.array[wp.int32],
    gyration: wp.array[wp.float32],
    sleep_threshold: wp.array[wp.float32],
    asleep: wp.array[wp.int32],
    max_velocity: wp.array[wp.float32],
    max_angular_velocity: wp.array[wp.float32],
    before: wp.array[wp.transform],
    # rest
    dt: wp.float32,
    fall_energy: wp.float32,
    rest_after: wp.float32,
    # out
    joint_q: wp.array[wp.float32],
    joint_qd: wp.array[wp.float32],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    quiet: wp.array[wp.float32],
    broken: wp.array[wp.int32],
):
    """Bound the speed of each body, hold bodies that have come to rest, and take back a step that is not finite.

    A body is quiet while its kinetic energy per mass [m²/s²] is below its sleep threshold, as in PhysX, and below
    `fall_energy`, which is less than gravity alone would give it in one step: only a supported body can be quiet for
    longer than an instant, and one that loses its support leaves at once. After `rest_after` seconds it is held where
    it was, so that the last millimetres per second of the contact solver do not show as creep.
    Those that were put to sleep (`asleep`) are held at once. `gyration` is inertia over mass [m²].
    """
    body = wp.tid()
    if dynamic[body] == 0:
        return
    pose = body_q[body]
    velocity = wp.spatial_top(body_qd[body])
    angular = wp.spatial_bottom(body_qd[body])
    speed = wp.length(velocity)
    spin = wp.length(angular)
    energy = 0.5 * (speed * speed + gyration[body] * spin * spin)

    hold = int(0)
    if not (wp.isfinite(speed) and wp.isfinite(spin) and finite_transform(pose)):
        broken[body] = broken[body] + 1
        hold = 1
    elif asleep[body] != 0:
        hold = 1
    elif pulled_by_gravity[body] != 0 and energy < wp.min(sleep_threshold[body], fall_energy):
        quiet[body] = quiet[body] + dt
        if quiet[body] >= rest_after:
            hold = 1
    else:
        quiet[body] = 0.0

    if hold != 0:
        pose = before[body]
        velocity = wp.vec3(0.0, 0.0, 0.0)
        angular = wp.vec3(0.0, 0.0, 0.0)
    elif speed > max_velocity[body]:
        velocity = velocity * (max_velocity[body] / speed)
    if hold == 0 and spin > max_angular_velocity[body]:
        angular = angular * (max_angular_velocity[body] / spin)

    body_q[body] = pose
    body_qd[body] = wp.spatial_vector(velocity, angular)
    for i in range(7):
        joint_q[7 * body + i] = pose[i]
    for i in range(3):
        joint_qd[6 * body + i] = velocity[i]
        joint_qd[6 * body + 3 + i] = angular[i]


@wp.func
def finite_transform(pose: wp.transform):
    total = float(0.0)
    for i in range(7):
        total += wp.abs(pose[i])
    return wp.isfinite(total)
