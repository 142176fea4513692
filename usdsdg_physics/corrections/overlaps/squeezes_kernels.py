"""Warp kernels over contacts: let bodies that are squeezed move out of each other, not turn between each other."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018, RUF046

import warp as wp

from usdsdg_physics.body_points import arm_of, body_point, world_point
from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays
from usdsdg_physics.corrections.contacts.contact_gaps import contact_gap, is_first_of_pair, is_free

# A contact squeezes a shape where it is deeper than this part of the shape's half thickness, fully from the second.
SQUEEZED = wp.constant(0.5)
FULLY_SQUEEZED = wp.constant(0.75)
# Bodies that are farther inside each other [m], or are squeezed, do not rest.
MAX_REST_DEPTH = wp.constant(0.002)
OVERLAPS = wp.constant(64)  # set besides the bits of directions
# Shapes touch where their gap is smaller [m].
TOUCHES = wp.constant(1.0e-3)
# What is so many times heavier than what it squeezes is held at the first depth as by what supports that, where it is
# deeper than this part of it besides what both have moved in a step: what rolls over something squeezes nothing.
MUCH_HEAVIER = wp.constant(100.0)
LIFTED = wp.constant(0.5)
# Cosine of the angle with an axis below which something pushes in its direction.
MIN_COSINE = wp.constant(0.5)


@wp.kernel(enable_backward=False)
def note_squeezes(
    # scene
    shape_body: wp.array[wp.int32],
    half_thickness: wp.array[wp.float32],
    # body
    free: wp.array[wp.int32],
    body_q: wp.array[wp.transform],
    contacts: ContactArrays,
    # out
    squeezed: wp.array[wp.int32],
    support: wp.array[wp.int32],
    touched: wp.array[wp.int32],
    touched_by: wp.array[wp.int32],
    neighbors: wp.array[wp.int32],
):
    """Note in `squeezed` which bodies overlap with others, and where what is not `free` squeezes them.

    Its bits are OVERLAPS and the `directions` in which such a shape, `support`, pushes the body; those of `touched` are
    directions in which one, `touched_by`, at least touches it. `half_thickness` [m] is that of shapes. `neighbors`
    counts for each body the free ones that touch it, by pairs of their shapes.
    """
    contact = wp.tid()
    if contact >= contacts.count[0] or contacts.shape0[contact] < 0 or contacts.shape1[contact] < 0:
        return
    first = int(contacts.shape0[contact])
    second = int(contacts.shape1[contact])
    body0 = int(shape_body[first])
    body1 = int(shape_body[second])
    point0 = world_point(body0, contacts.point0[contact], body_q)
    point1 = world_point(body1, contacts.point1[contact], body_q)
    depth = -contact_gap(contact, point0, point1, contacts)
    free0 = is_free(body0, free)
    free1 = is_free(body1, free)
    if free0 and free1 and depth > -TOUCHES and is_first_of_pair(contact, contacts):
        wp.atomic_add(neighbors, body0, 1)
        wp.atomic_add(neighbors, body1, 1)
    if depth > -TOUCHES and free0 and not free1:
        wp.atomic_or(touched, body0, directions(-contacts.normal[contact]))
        wp.atomic_max(touched_by, body0, second)
    if depth > -TOUCHES and free1 and not free0:
        wp.atomic_or(touched, body1, directions(contacts.normal[contact]))
        wp.atomic_max(touched_by, body1, first)
    if depth <= 0.0:
        return
    if free0:
        limit = SQUEEZED * half_thickness[first]
        if not free1 and depth > limit:
            wp.atomic_or(squeezed, body0, directions(-contacts.normal[contact]))
            wp.atomic_max(support, body0, second)
        if depth > wp.min(limit, MAX_REST_DEPTH):
            wp.atomic_or(squeezed, body0, OVERLAPS)
    if free1:
        limit = SQUEEZED * half_thickness[second]
        if not free0 and depth > limit:
            wp.atomic_or(squeezed, body1, directions(contacts.normal[contact]))
            wp.atomic_max(support, body1, first)
        if depth > wp.min(limit, MAX_REST_DEPTH):
            wp.atomic_or(squeezed, body1, OVERLAPS)


@wp.kernel(enable_backward=False)
def redirect_squeezes(
    # scene
    shape_body: wp.array[wp.int32],
    half_thickness: wp.array[wp.float32],
    # body
    free: wp.array[wp.int32],
    inverse_mass: wp.array[wp.float32],
    center: wp.array[wp.vec3],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    squeezed: wp.array[wp.int32],
    support: wp.array[wp.int32],
    touched: wp.array[wp.int32],
    touched_by: wp.array[wp.int32],
    lifts: wp.int32,
    h: wp.float32,
    # in and out
    contacts: ContactArrays,
):
    """Pass on what supports a squeezed body, and move the points of other deep contacts to below its center of mass.

    A body that is squeezed against something fixed pushes others as that would, and so does one that only touches it
    while what is much heavier squeezes it. Of two bodies that move, the lighter one counts.
    """
    contact = wp.tid()
    if contact >= contacts.count[0] or contacts.shape0[contact] < 0 or contacts.shape1[contact] < 0:
        return
    first = int(contacts.shape0[contact])
    second = int(contacts.shape1[contact])
    body0 = int(shape_body[first])
    body1 = int(shape_body[second])
    bits0 = int(0)
    bits1 = int(0)
    if is_free(body0, free):
        bits0 = squeezed[body0]
    if is_free(body1, free):
        bits1 = squeezed[body1]
    if bits0 == 0 and bits1 == 0:
        return
    point0 = world_point(body0, contacts.point0[contact], body_q)
    point1 = world_point(body1, contacts.point1[contact], body_q)
    depth = -contact_gap(contact, point0, point1, contacts)
    if depth <= 0.0:
        return

    normal = contacts.normal[contact]
    if is_free(body0, free) and is_free(body1, free):
        if (bits0 & directions(normal)) != 0:
            contacts.shape0[contact] = support[body0]
            contacts.point0[contact] = body_point(shape_body[support[body0]], point0, body_q)
            return
        if (bits1 & directions(-normal)) != 0:
            contacts.shape1[contact] = support[body1]
            contacts.point1[contact] = body_point(shape_body[support[body1]], point1, body_q)
            return
        if lifts != 0 and is_lifted(body0, body1, normal, touched, inverse_mass):
            limit = SQUEEZED * half_thickness[first]
            if depth > LIFTED * limit + h * approach(body0, body1, body_qd):
                contacts.shape0[contact] = touched_by[body0]
                contacts.point0[contact] = body_point(shape_body[touched_by[body0]], point0 - limit * normal, body_q)
                return
        if lifts != 0 and is_lifted(body1, body0, -normal, touched, inverse_mass):
            limit = SQUEEZED * half_thickness[second]
            if depth > LIFTED * limit + h * approach(body0, body1, body_qd):
                contacts.shape1[contact] = touched_by[body1]
                contacts.point1[contact] = body_point(shape_body[touched_by[body1]], point1 + limit * normal, body_q)
                return

    takes_second = is_free(body1, free)
    if is_free(body0, free) and is_free(body1, free):
        takes_second = inverse_mass[body1] >= inverse_mass[body0]
    body = wp.where(takes_second, body1, body0)
    share = depth / half_thickness[wp.where(takes_second, second, first)]
    share = wp.clamp((share - SQUEEZED) / (FULLY_SQUEEZED - SQUEEZED), 0.0, 1.0)
    if share == 0.0:
        return
    arm = arm_of(body, wp.where(takes_second, point1, point0), center, body_q)
    move = -share * (arm - wp.dot(arm, normal) * normal)
    contacts.point0[contact] = body_point(body0, point0 + move, body_q)
    contacts.point1[contact] = body_point(body1, point1 + move, body_q)


@wp.func
def is_lifted(body: int, other: int, normal: wp.vec3, touched: wp.array[wp.int32], inverse_mass: wp.array[wp.float32]):
    """Return whether a body lies between something fixed and one that is much heavier, in the direction `normal`."""
    return inverse_mass[body] > MUCH_HEAVIER * inverse_mass[other] and (touched[body] & directions(normal)) != 0


@wp.func
def approach(body0: int, body1: int, body_qd: wp.array[wp.spatial_vector]):
    """Return the speed [m/s] at which the centers of two bodies move relative to each other."""
    return wp.length(wp.spatial_top(body_qd[body1]) - wp.spatial_top(body_qd[body0]))


@wp.func
def directions(vector: wp.vec3):
    """Return a bit for each of +x, -x, +y, -y, +z, -z that a unit vector is within 60 degrees of."""
    bits = int(0)
    for axis in range(3):
        if vector[axis] > MIN_COSINE:
            bits |= 1 << (2 * axis)
        elif vector[axis] < -MIN_COSINE:
            bits |= 2 << (2 * axis)
    return bits
