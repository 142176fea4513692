"""Warp kernel over contacts: turn those with the edge of a collider that continues the surface of its neighbor."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018

import warp as wp

from usdsdg_physics.body_points import shape_to_world, world_point
from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays
from usdsdg_physics.guards.sides import point_on, shape_on, turn

# How far [m] one collider may stand out of the surface of its neighbor, more where numbers are coarser; how wide the
# seam between them may be; and how far things may have sunk into the surface.
LIP = wp.constant(1.0e-4)
LIP_BY_SIZE = wp.constant(1.0e-6)
WIDTH = wp.constant(1.0e-3)
SUNK = wp.constant(2.0e-3)
# A normal that is this much along that of the surface needs no turning; one that is less than this along it holds
# nothing, since what the other shape lies on is below it, and is taken so far [m] from that.
ALONG = wp.constant(0.9999)
HOLDS = wp.constant(0.7)
APART = wp.constant(0.02)


@wp.kernel(enable_backward=False)
def turn_to_surface(
    # shape
    face_rows: wp.array[wp.vec2i],
    faces: wp.array[wp.vec4],
    neighbor_rows: wp.array[wp.vec2i],
    neighbors: wp.array[wp.int32],
    transform: wp.array[wp.transform],
    shape_body: wp.array[wp.int32],
    collision_group: wp.array[wp.int32],
    # body
    body_q: wp.array[wp.transform],
    # in and out
    contacts: ContactArrays,
):
    """Give contacts whose point lies in a neighbor's face the normal of that face.

    That is where the neighbor is in the direction that the normal has besides, and the collider does not stand out of
    the face.
    """
    contact = wp.tid()
    if contact >= contacts.count[0]:
        return
    if contacts.shape0[contact] < 0 or contacts.shape1[contact] < 0:
        return
    side = float(1.0)  # of the collider
    if neighbor_rows[contacts.shape0[contact]][1] == 0:
        side = float(-1.0)
    collider = shape_on(side, contact, contacts)
    other = shape_on(-side, contact, contacts)
    rows = neighbor_rows[collider]
    if rows[1] == 0 or shape_body[other] < 0:
        return

    body = shape_body[collider]
    point = world_point(body, point_on(side, contact, contacts), body_q)
    to_collider = wp.transform_inverse(shape_to_world(collider, transform, shape_body, body_q))
    normal = side * contacts.normal[contact]
    lip = LIP + LIP_BY_SIZE * wp.length(point)
    for row in range(rows[0], rows[0] + rows[1]):
        neighbor = neighbors[row]
        if neighbor == other or collision_group[neighbor] == 0:
            continue
        neighbor_to_world = shape_to_world(neighbor, transform, shape_body, body_q)
        to_neighbor = wp.transform_inverse(neighbor_to_world)
        at = wp.transform_point(to_neighbor, point)
        own = face_rows[neighbor]
        for face in range(own[0], own[0] + own[1]):
            plane = faces[face]
            above = wp.dot(wp.vec3(plane[0], plane[1], plane[2]), at) - plane[3]
            if above > lip or above < -SUNK:
                continue
            up = wp.transform_vector(neighbor_to_world, wp.vec3(plane[0], plane[1], plane[2]))
            along = wp.dot(normal, up)
            if along < -0.01 or along > ALONG:
                continue
            aside = wp.normalize(normal - along * up)
            if not is_inside(wp.transform_point(to_neighbor, point + WIDTH * aside), faces, own, face, lip):
                continue
            raised = point - WIDTH * aside + (lip - above) * up
            if is_inside(wp.transform_point(to_collider, raised), faces, face_rows[collider], -1, 0.0):
                continue
            on_other = world_point(shape_body[other], point_on(-side, contact, contacts), body_q)
            below = on_other - (wp.dot(on_other - point, up) + above) * up
            # Beyond the edge of both nothing holds the other shape.
            if is_inside(wp.transform_point(to_neighbor, below), faces, own, face, WIDTH) or is_inside(
                wp.transform_point(to_collider, below), faces, face_rows[collider], -1, WIDTH
            ):
                turn(contact, side, up, below - wp.where(along < HOLDS, APART, 0.0) * up, body, body_q, contacts)
                return


@wp.func
def is_inside(point: wp.vec3, faces: wp.array[wp.vec4], rows: wp.vec2i, left_out: int, tolerance: float):
    """Return whether a point is behind all faces of a shape but one, or before them by no more than the tolerance."""
    for face in range(rows[0], rows[0] + rows[1]):
        plane = faces[face]
        if face != left_out and wp.dot(wp.vec3(plane[0], plane[1], plane[2]), point) - plane[3] > tolerance:
            return False
    return True
