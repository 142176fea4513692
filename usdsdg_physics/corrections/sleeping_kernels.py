"""The Warp kernel that finds out which sleeping bodies are touched."""

from __future__ import annotations

import warp as wp

# Bodies at rest on each other are this near, or nearer.
TOUCHING = wp.constant(0.001)  # m


@wp.kernel
def wake_touched(
    # scene
    shape_body: wp.array[wp.int32],
    # body
    slept: wp.array[wp.int32],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    gyration: wp.array[wp.float32],
    sleep_threshold: wp.array[wp.float32],
    # contact
    count: wp.array[wp.int32],
    shape0: wp.array[wp.int32],
    shape1: wp.array[wp.int32],
    point0: wp.array[wp.vec3],
    point1: wp.array[wp.vec3],
    normal: wp.array[wp.vec3],
    margin0: wp.array[wp.float32],
    margin1: wp.array[wp.float32],
    dt: wp.float32,
    # out
    asleep: wp.array[wp.int32],
):
    """Clear `asleep` of each body that one in motion touches or will reach within `dt` seconds.

    In motion are bodies of more kinetic energy per mass than their own sleep threshold [m²/s²], and those that `slept`
    before and have been woken: a pile wakes as a whole. Static colliders and what lies still wake nobody.
    """
    contact = wp.tid()
    if contact >= count[0] or shape0[contact] < 0 or shape1[contact] < 0:
        return
    first = shape_body[shape0[contact]]
    second = shape_body[shape1[contact]]
    if first < 0 or second < 0 or (asleep[first] != 0) == (asleep[second] != 0):
        return
    sleeper = int(first)
    other = int(second)
    if asleep[sleeper] == 0:
        sleeper = int(second)
        other = int(first)

    velocity = wp.spatial_top(body_qd[other])
    angular = wp.spatial_bottom(body_qd[other])
    energy = 0.5 * (wp.dot(velocity, velocity) + gyration[other] * wp.dot(angular, angular))
    if energy <= sleep_threshold[other] and slept[other] == 0:
        return

    on_first = wp.transform_point(body_q[first], point0[contact])
    on_second = wp.transform_point(body_q[second], point1[contact])
    # The normal points from the first shape to the second.
    depth = wp.dot(normal[contact], on_first - on_second) + margin0[contact] + margin1[contact]
    lever = on_first - wp.transform_get_translation(body_q[other])
    approach = wp.dot(normal[contact], velocity + wp.cross(angular, lever))
    if other == second:
        approach = -approach
    if depth + wp.max(approach, 0.0) * dt >= -TOUCHING:
        asleep[sleeper] = 0
