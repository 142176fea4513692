"""Warp kernels over contacts: add those that bodies on their side will have at the end that is up."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018, RUF046, SIM102 (Warp evaluates both sides of `and`)

import warp as wp

from usdsdg_physics.body_points import body_point, world_point
from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays
from usdsdg_physics.corrections.contacts.contact_gaps import contact_gap, is_first_of_pair, is_free
from usdsdg_physics.corrections.contacts.outlines import HULL, Outlines, farthest_point, has_faces, is_long, is_on

# Sine and cosine of the greatest tilt at which a body lies on two ends, 15 degrees, and the tangent of the angle from
# the line between them at which the two corners of an end that is flat are looked for, 5 degrees.
SIN_TILT = wp.constant(0.2588190)
COS_TILT = wp.constant(0.9659258)
TAN_ASIDE = wp.constant(0.0874887)
# Sine of the angle at a contact, between the vertical and the center of mass, below which a body stands on it or rolls.
BALANCED = wp.constant(0.2)
# How far a surface may be from the plane of the other contact, as part of the distance between both, and at least.
UNEVEN = wp.constant(0.01)
MIN_UNEVEN = wp.constant(1.0e-5)  # m
SAME_POINT = wp.constant(1.0e-6)  # m


@wp.struct
class FarEnds:
    """Up to two contacts of a pair of shapes, with the points on both of them in the frames of their bodies."""

    count: wp.int32
    like: wp.int32  # the contact whose shapes, normal and margins they have
    first0: wp.vec3
    first1: wp.vec3
    second0: wp.vec3
    second1: wp.vec3


@wp.kernel(enable_backward=False)
def append_far_ends(
    outlines: Outlines,
    body_q: wp.array[wp.transform],
    # in and out
    contacts: ContactArrays,
):
    """Add the far ends of all pairs, one after the other, in one thread."""
    found = wp.min(contacts.count[0], contacts.shape0.shape[0])
    total = int(found)
    for contact in range(found):
        ends = far_ends(contact, found, outlines, body_q, contacts)
        total += write_far_ends(ends, total, contacts)
    contacts.count[0] = total


@wp.kernel(enable_backward=False)
def count_far_ends(
    outlines: Outlines,
    body_q: wp.array[wp.transform],
    contacts: ContactArrays,
    # out
    added: wp.array[wp.int32],
):
    """Count the far ends that come with each contact."""
    contact = wp.tid()
    added[contact] = 0
    found = wp.min(contacts.count[0], contacts.shape0.shape[0])
    if contact < found:
        ends = far_ends(contact, found, outlines, body_q, contacts)
        added[contact] = ends.count


@wp.kernel(enable_backward=False)
def add_far_ends(
    outlines: Outlines,
    body_q: wp.array[wp.transform],
    added: wp.array[wp.int32],
    added_up_to: wp.array[wp.int32],
    # in and out
    contacts: ContactArrays,
):
    """Write the far ends behind the contacts that are counted, in the order of these.

    `added` (C,) is how many come with each contact, `added_up_to` (C,) with it and all before it.
    """
    contact = wp.tid()
    if added[contact] > 0:
        found = wp.min(contacts.count[0], contacts.shape0.shape[0])  # more were found than there is room for
        ends = far_ends(contact, found, outlines, body_q, contacts)
        write_far_ends(ends, found + added_up_to[contact] - added[contact], contacts)


@wp.kernel(enable_backward=False)
def count_added(added_up_to: wp.array[wp.int32], count: wp.array[wp.int32]):
    """Count what was added."""
    capacity = added_up_to.shape[0]
    if count[0] < capacity:
        count[0] = wp.min(count[0] + added_up_to[capacity - 1], capacity)


@wp.func
def write_far_ends(ends: FarEnds, row: int, contacts: ContactArrays):
    """Write the contacts of far ends from a row on; return how many there was room for."""
    written = int(0)
    for i in range(ends.count):
        if row + i < contacts.shape0.shape[0]:
            contacts.shape0[row + i] = contacts.shape0[ends.like]
            contacts.shape1[row + i] = contacts.shape1[ends.like]
            contacts.point0[row + i] = wp.where(i == 0, ends.first0, ends.second0)
            contacts.point1[row + i] = wp.where(i == 0, ends.first1, ends.second1)
            contacts.normal[row + i] = contacts.normal[ends.like]
            contacts.margin0[row + i] = contacts.margin0[ends.like]
            contacts.margin1[row + i] = contacts.margin1[ends.like]
            written += 1
    return written


@wp.func
def far_ends(contact: int, count: int, outlines: Outlines, body_q: wp.array[wp.transform], contacts: ContactArrays):
    """Return the far ends of the pair whose first contact this is; none for others."""
    ends = FarEnds()
    first = contacts.shape0[contact]
    second = contacts.shape1[contact]
    if first < 0 or second < 0 or not is_first_of_pair(contact, contacts):
        return ends
    for side in range(2):
        lying = wp.where(side == 0, first, second)
        other = wp.where(side == 0, second, first)
        if ends.count == 0 and is_long(lying, outlines) and has_faces(other, outlines):
            if is_free(outlines.body[lying], outlines.free):
                ends = opposite_end(contact, count, side, lying, other, outlines, body_q, contacts)
    return ends


@wp.func
def opposite_end(
    contact: int,
    count: int,
    side: int,
    lying: int,
    other: int,
    outlines: Outlines,
    body_q: wp.array[wp.transform],
    contacts: ContactArrays,
):
    """Return the end of a shape that lies, as seen from its contacts with the other one, behind its center of mass.

    That is the point that touches first where the shape tilts over, and of hulls two of them. The other shape must have
    the plane of the contacts below it. `side` tells which of the contacts' points are those of the shape that lies.
    """
    ends = FarEnds()
    body = outlines.body[lying]
    center = wp.transform_point(body_q[body], outlines.center[body])

    deepest, end, least = deepest_of_pair(contact, count, outlines, body_q, contacts)
    start = point_of(deepest, side, outlines, body_q, contacts)
    normal = contacts.normal[deepest]
    middle = wp.vec3(0.0, 0.0, 0.0)
    beside = int(0)
    for i in range(contact, end):
        if is_beside(i, side, normal, start, least, outlines, body_q, contacts):
            middle += point_of(i, side, outlines, body_q, contacts)
            beside += 1
    middle /= float(beside)

    # Down is from the body that lies to what it lies on, across from the contacts to below the center of mass.
    down = wp.where(side == 0, normal, -normal)
    across = center - middle
    reach = wp.length(across)
    across -= wp.dot(across, down) * down
    distance = wp.length(across)
    if distance <= BALANCED * reach:
        return ends
    across = across / distance
    for i in range(contact, end):
        if is_beside(i, side, normal, start, least, outlines, body_q, contacts):
            if wp.dot(point_of(i, side, outlines, body_q, contacts) - center, across) >= 0.0:
                return ends  # lies on both sides

    to_world = body_q[body] * outlines.transform[lying]
    aside = TAN_ASIDE * SIN_TILT * wp.cross(down, across)
    direction = COS_TILT * down + SIN_TILT * across
    ground = point_of(deepest, 1 - side, outlines, body_q, contacts)
    margin = contacts.margin0[deepest] + contacts.margin1[deepest]
    previous = start
    for i in range(2):
        toward = direction
        if outlines.kind[lying] == HULL:
            toward = direction + wp.where(i == 0, aside, -aside)
        elif i == 1:
            return ends
        local = wp.quat_rotate_inv(wp.transform_get_rotation(to_world), toward)
        point = wp.transform_point(to_world, farthest_point(lying, local, outlines))
        below = point + wp.dot(down, ground - point) * down
        is_end = wp.dot(point - center, across) > 0.0 and wp.length(point - previous) > SAME_POINT
        if is_end and wp.dot(down, below - point) - margin <= outlines.gap[lying] + outlines.gap[other]:
            if is_on(below, other, wp.max(UNEVEN * wp.length(point - start), MIN_UNEVEN), outlines, body_q):
                on_lying = body_point(body, point, body_q)
                on_other = body_point(outlines.body[other], below, body_q)
                point0 = wp.where(side == 0, on_lying, on_other)
                point1 = wp.where(side == 0, on_other, on_lying)
                if ends.count == 0:
                    ends.first0 = point0
                    ends.first1 = point1
                else:
                    ends.second0 = point0
                    ends.second1 = point1
                ends.count += 1
                ends.like = deepest
        previous = point
    return ends


@wp.func
def deepest_of_pair(
    contact: int, count: int, outlines: Outlines, body_q: wp.array[wp.transform], contacts: ContactArrays
):
    """Return the deepest contact of the pair of shapes whose first is given, the one after its last, and its gap."""
    deepest = int(contact)
    least = float(1.0e10)
    end = int(contact)
    while end < count:
        if contacts.shape0[end] != contacts.shape0[contact] or contacts.shape1[end] != contacts.shape1[contact]:
            break
        gap = gap_of(end, outlines, body_q, contacts)
        if gap < least:
            least = gap
            deepest = end
        end += 1
    return deepest, end, least


@wp.func
def point_of(contact: int, side: int, outlines: Outlines, body_q: wp.array[wp.transform], contacts: ContactArrays):
    """Return a contact's point on its first shape (side 0) or second (side 1), in the world."""
    if side == 0:
        return world_point(outlines.body[contacts.shape0[contact]], contacts.point0[contact], body_q)
    return world_point(outlines.body[contacts.shape1[contact]], contacts.point1[contact], body_q)


@wp.func
def gap_of(contact: int, outlines: Outlines, body_q: wp.array[wp.transform], contacts: ContactArrays):
    """Return how far [m] the surfaces of a contact are apart, negative where they overlap."""
    point0 = point_of(contact, 0, outlines, body_q, contacts)
    point1 = point_of(contact, 1, outlines, body_q, contacts)
    return contact_gap(contact, point0, point1, contacts)


@wp.func
def is_beside(
    contact: int,
    side: int,
    normal: wp.vec3,
    start: wp.vec3,
    least: float,
    outlines: Outlines,
    body_q: wp.array[wp.transform],
    contacts: ContactArrays,
):
    """Return whether a contact has the plane of the deepest one, and a tilt about that would bring it down.

    A mesh gives others besides: those with edges of triangles some way off. The deepest has `normal`, `start` is its
    point of a `side`, and `least` its gap.
    """
    if wp.dot(contacts.normal[contact], normal) < COS_TILT:
        return False
    point0 = point_of(contact, 0, outlines, body_q, contacts)
    point1 = point_of(contact, 1, outlines, body_q, contacts)
    arm = wp.length(wp.where(side == 0, point0, point1) - start)
    return contact_gap(contact, point0, point1, contacts) - least <= SIN_TILT * arm
