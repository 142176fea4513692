"""Warp kernel over contacts: the velocity of the surfaces that touch."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

from usdsdg_physics.body_points import turning_velocity
from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


@wp.kernel(enable_backward=False)
def set_surface_velocities(
    # scene
    shape_body: wp.array[wp.int32],
    motion: wp.array[wp.spatial_vector],
    linear: wp.array[wp.vec3],
    angular: wp.array[wp.vec3],
    local: wp.array[wp.int32],
    # body
    body_q: wp.array[wp.transform],
    contacts: ContactArrays,
    # out
    velocity: wp.array[wp.vec3],
    rest_time: wp.array[wp.float32],
):
    """Set the `velocity` [m/s, world] of the surface of shape 1 relative to that of shape 0.

    `linear` [m/s] and `angular` [rad/s] are those of the bodies' surfaces, in the body's frame where `local` is not 0;
    `motion` is that of static shapes, at the world's origin.
    """
    contact = wp.tid()
    if contact >= contacts.count[0] or contacts.shape0[contact] < 0 or contacts.shape1[contact] < 0:
        return
    first = int(shape_body[contacts.shape0[contact]])
    second = int(shape_body[contacts.shape1[contact]])
    total = static_velocity(second, contacts.shape1[contact], contacts.point1[contact], motion) - static_velocity(
        first, contacts.shape0[contact], contacts.point0[contact], motion
    )
    total += surface_velocity(second, contacts.point1[contact], linear, angular, local, body_q) - surface_velocity(
        first, contacts.point0[contact], linear, angular, local, body_q
    )
    velocity[contact] = total
    if wp.length_sq(total) > 0.0:
        if first >= 0:
            rest_time[first] = 0.0
        if second >= 0:
            rest_time[second] = 0.0


@wp.func
def static_velocity(body: int, shape: int, point: wp.vec3, motion: wp.array[wp.spatial_vector]):
    """Return the velocity of a static shape at a point [m]; zero for shapes of bodies."""
    if body >= 0:
        return wp.vec3(0.0, 0.0, 0.0)
    return turning_velocity(motion[shape], point)


@wp.func
def surface_velocity(
    body: int,
    point: wp.vec3,
    linear: wp.array[wp.vec3],
    angular: wp.array[wp.vec3],
    local: wp.array[wp.int32],
    body_q: wp.array[wp.transform],
):
    """Return the velocity of a body's surface at a point in its frame, relative to the body, in the world."""
    if body < 0:
        return wp.vec3(0.0, 0.0, 0.0)
    if local[body] != 0:
        return wp.transform_vector(body_q[body], linear[body] + wp.cross(angular[body], point))
    return linear[body] + wp.cross(angular[body], wp.transform_vector(body_q[body], point))
