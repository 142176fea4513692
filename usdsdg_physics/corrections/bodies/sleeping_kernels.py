"""Warp kernel that wakes sleeping bodies that a moving body touches."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays

# Bodies that rest on each other are at most this far apart.
TOUCH_DISTANCE = wp.constant(0.001)  # m


@wp.kernel(enable_backward=False)
def wake_touched_bodies(
    # scene
    shape_body: wp.array[wp.int32],
    # body
    was_asleep: wp.array[wp.int32],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    center: wp.array[wp.vec3],
    inertia_per_mass: wp.array[wp.float32],
    sleep_threshold: wp.array[wp.float32],
    contacts: ContactArrays,
    dt: wp.float32,
    # out
    asleep: wp.array[wp.int32],
    woke: wp.array[wp.int32],
):
    """Clear `asleep` of each body that a moving body touches or will reach within `dt` seconds; then `woke` (1,) is 1.

    A body moves when its kinetic energy per mass is above its own sleep threshold [m²/s²], or when it `was_asleep`
    before this step and has been woken in it: a pile wakes as a whole. Static colliders and bodies at rest wake none.
    """
    contact = wp.tid()
    if contact >= contacts.count[0] or contacts.shape0[contact] < 0 or contacts.shape1[contact] < 0:
        return
    first = shape_body[contacts.shape0[contact]]
    second = shape_body[contacts.shape1[contact]]
    if first < 0 or second < 0 or (asleep[first] != 0) == (asleep[second] != 0):
        return
    sleeping = int(first)
    other = int(second)
    if asleep[sleeping] == 0:
        sleeping = int(second)
        other = int(first)

    velocity = wp.spatial_top(body_qd[other])
    angular = wp.spatial_bottom(body_qd[other])
    energy = 0.5 * (wp.dot(velocity, velocity) + inertia_per_mass[other] * wp.dot(angular, angular))
    if energy <= sleep_threshold[other] and was_asleep[other] == 0:
        return

    point_on_first = wp.transform_point(body_q[first], contacts.point0[contact])
    point_on_second = wp.transform_point(body_q[second], contacts.point1[contact])
    depth = (
        wp.dot(contacts.normal[contact], point_on_first - point_on_second)
        + contacts.margin0[contact]
        + contacts.margin1[contact]
    )
    lever = point_on_first - wp.transform_point(body_q[other], center[other])
    approach = wp.dot(contacts.normal[contact], velocity + wp.cross(angular, lever))
    if other == second:
        approach = -approach
    if depth + wp.max(approach, 0.0) * dt >= -TOUCH_DISTANCE:
        asleep[sleeping] = 0
        woke[0] = 1
