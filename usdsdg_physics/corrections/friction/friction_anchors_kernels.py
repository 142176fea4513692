"""Warp kernel over contacts: the points of friction of faces that lie on something."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018, RUF046

import warp as wp
from newton._src.solvers.steel.friction import contact_tangent_basis
from newton._src.solvers.steel.friction_patches import FrictionPatches, _PatchFrame

from usdsdg_physics.body_points import body_point

LIES = wp.constant(0.5)  # cosine between a normal and gravity from which on a body lies on what is below it

OPPOSITE = wp.constant(0.02)  # of the distance between two anchors, by which a center may be beside their middle


@wp.kernel(enable_backward=False)
def center_anchors(
    count: wp.array[int],
    gravity: wp.array[wp.vec3],
    center: wp.array[wp.vec3],
    body_q: wp.array[wp.transform],
    # in and out
    frame: _PatchFrame,
    patches: FrictionPatches,
):
    """Move both anchors of a face along its plane, so that the center of mass of the body on it is between them.

    The springs that hold them are a motion of the plane, taken at the new places.
    """
    first = wp.tid()
    if first >= wp.min(count[0], frame.center.shape[0]) or patches.weight[first] != 0.5:
        return
    second = int(-1)
    contacts = int(1)
    contact = int(patches.next_contact[first])
    while contact >= 0 and contact != first:
        contacts += 1
        if patches.weight[contact] == 0.5:
            second = contact
        contact = patches.next_contact[contact]
    # The ends of an edge that lies on something are opposite.
    if second <= first or contacts < 3:
        return
    if frame.source[first] >= 0 and frame.source[second] >= 0:
        return  # they hold
    # Points from the second body to the first.
    normal = frame.normal[first]
    upward = -wp.dot(normal, gravity[0])
    if wp.abs(upward) <= LIES * wp.length(gravity[0]):
        return
    upper = frame.body_a[first]
    if upward < 0.0:
        upper = frame.body_b[first]
    if upper < 0:
        return
    move = wp.transform_point(body_q[upper], center[upper]) - 0.5 * (patches.point_a[first] + patches.point_a[second])
    move -= wp.dot(move, normal) * normal
    span = patches.point_a[second] - patches.point_a[first]
    span -= wp.dot(span, normal) * normal
    # What hangs over is held by more than friction below it; and what wavers in a stack shall not drift by that.
    distance = wp.length(move)
    length = wp.length(span)
    if distance > 0.5 * length or distance < OPPOSITE * length:
        return
    turned = wp.cross(normal, span)
    spin = wp.dot(spring(second, frame, patches) - spring(first, frame, patches), turned) / wp.length_sq(turned)
    change = spin * wp.cross(normal, move)
    move_anchor(first, move, change, body_q, frame, patches)
    move_anchor(second, move, change, body_q, frame, patches)


@wp.func
def spring(contact: int, frame: _PatchFrame, patches: FrictionPatches):
    """Return the displacement of an anchor that friction takes back."""
    side = float(1.0)
    if frame.flipped[contact] != 0:
        side = -1.0
    t0, t1 = contact_tangent_basis(side * frame.normal[contact])
    phi = patches.phi[contact]
    return side * (phi[0] * t0 + phi[1] * t1)


@wp.func
def move_anchor(
    contact: int,
    move: wp.vec3,
    change: wp.vec3,
    body_q: wp.array[wp.transform],
    frame: _PatchFrame,
    patches: FrictionPatches,
):
    """Move an anchor, and change the displacement that friction takes back."""
    a = frame.body_a[contact]
    place = patches.point_a[contact] + move
    patches.point_a[contact] = place
    patches.point_b[contact] = place
    frame.anchor_a[contact] = body_point(a, place, body_q)
    frame.anchor_b[contact] = body_point(frame.body_b[contact], place, body_q)
    local = change
    if a >= 0:
        local = wp.transform_vector(wp.transform_inverse(body_q[a]), change)
    frame.displacement[contact] += local
    side = float(1.0)
    if frame.flipped[contact] != 0:
        side = -1.0
    t0, t1 = contact_tangent_basis(side * frame.normal[contact])
    patches.phi[contact] += side * wp.vec2(wp.dot(t0, change), wp.dot(t1, change))
