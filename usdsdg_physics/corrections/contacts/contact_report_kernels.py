"""Warp kernels over contacts: keep those that are reported."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

from usdsdg_physics.body_points import world_point
from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


@wp.kernel(enable_backward=False)
def note_contacts(
    # scene
    shape_body: wp.array[wp.int32],
    reported: wp.array[wp.int32],
    # body
    body_q: wp.array[wp.transform],
    contacts: ContactArrays,
    substep: wp.int32,
    # out
    shapes: wp.array2d[wp.vec2i],
    position: wp.array2d[wp.vec3],
    normal: wp.array2d[wp.vec3],
    separation: wp.array2d[wp.float32],
):
    """Note shapes, place [m, world] and separation [m] of each contact of a reported shape; shapes -1 of the others."""
    contact = wp.tid()
    shapes[substep, contact] = wp.vec2i(-1, -1)
    if contact >= contacts.count[0]:
        return
    first = int(contacts.shape0[contact])
    second = int(contacts.shape1[contact])
    if first < 0 or second < 0 or (reported[first] == 0 and reported[second] == 0):
        return
    direction = wp.vec3(contacts.normal[contact])
    point0 = world_point(shape_body[first], contacts.point0[contact], body_q) + contacts.margin0[contact] * direction
    point1 = world_point(shape_body[second], contacts.point1[contact], body_q) - contacts.margin1[contact] * direction
    shapes[substep, contact] = wp.vec2i(first, second)
    position[substep, contact] = 0.5 * (point0 + point1)
    normal[substep, contact] = direction
    separation[substep, contact] = wp.dot(direction, point1 - point0)


@wp.kernel(enable_backward=False)
def note_impulses(
    forces: wp.array[wp.spatial_vector],
    substep: wp.int32,
    dt: wp.float32,
    # out
    impulse: wp.array2d[wp.vec3],
):
    """Note the impulse [N s] of each contact on its first shape."""
    contact = wp.tid()
    impulse[substep, contact] = dt * wp.spatial_top(forces[contact])
