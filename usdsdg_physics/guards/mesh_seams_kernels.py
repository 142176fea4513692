"""Warp kernels over contacts: turn those at the seams of triangles to the faces beside them."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018

import warp as wp

from usdsdg_physics.body_points import shape_to_world, world_point
from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays
from usdsdg_physics.guards.sides import point_on, shape_on, turn

# How far [m] from the surface, along the normal, its closest point is looked for, more where numbers are coarser; and
# by which part of that it must lie beside the contact's.
DISTANCE = wp.constant(2.0e-3)
DISTANCE_BY_SIZE = wp.constant(1.0e-3)
ASIDE = wp.constant(0.02)
REACH = wp.constant(1.5)


@wp.kernel(enable_backward=False)
def turn_to_faces(
    # shape
    is_round: wp.array[wp.int32],
    is_mesh: wp.array[wp.int32],
    mesh: wp.array[wp.uint64],
    scale: wp.array[wp.vec3],
    transform: wp.array[wp.transform],
    shape_body: wp.array[wp.int32],
    # body
    body_q: wp.array[wp.transform],
    # in and out
    contacts: ContactArrays,
):
    """Give contacts whose point is not the closest one of the mesh, seen from just above, the normal of the closest.

    The narrow phase sees each triangle alone: a ball on one of two that lie in a plane is in front of the other's
    edge, over which it would have to climb, and stops after some seams.
    """
    contact = wp.tid()
    if contact >= contacts.count[0]:
        return
    side = side_of_mesh(contact, is_mesh, is_round, contacts)
    if side == 0.0:
        return

    triangles = shape_on(side, contact, contacts)
    point = world_point(shape_body[triangles], point_on(side, contact, contacts), body_q)
    to_world = shape_to_world(triangles, transform, shape_body, body_q)
    to_mesh = wp.transform_inverse(to_world)
    size = scale[triangles][0]
    at = wp.transform_point(to_mesh, point) / size
    normal = wp.transform_vector(to_mesh, side * contacts.normal[contact])
    distance = (DISTANCE + DISTANCE_BY_SIZE * wp.length(point)) / size
    above = at + distance * normal
    query = wp.mesh_query_point_no_sign(mesh[triangles], above, REACH * distance)
    if not query.result:
        return
    closest = wp.mesh_eval_position(mesh[triangles], query.face, query.u, query.v)
    if wp.length(closest - at) > ASIDE * distance and wp.length(above - closest) > ASIDE * distance:
        contacts.normal[contact] = side * wp.transform_vector(to_world, wp.normalize(above - closest))


@wp.func
def side_of_mesh(contact: int, is_mesh: wp.array[wp.int32], is_other: wp.array[wp.int32], contacts: ContactArrays):
    """Return the side of the mesh in a contact with a shape of the other kind; 0 for other contacts."""
    if contacts.shape0[contact] < 0 or contacts.shape1[contact] < 0:
        return 0.0
    side = float(1.0)
    if is_mesh[contacts.shape0[contact]] == 0:
        side = float(-1.0)
    if is_mesh[shape_on(side, contact, contacts)] == 0 or is_other[shape_on(-side, contact, contacts)] == 0:
        return 0.0
    return side


# Radius [units of the mesh] of a search for the point nearest to another: larger than any distance of these.
FAR = wp.constant(1.0e6)
# How far [m] faces may stand out beside a seam, more where numbers are coarser; and where beside it they are looked at.
LIP = wp.constant(1.0e-4)
LIP_BY_SIZE = wp.constant(1.0e-6)
BESIDE = wp.constant(1.0e-3)
# A normal that is this much along that of the face needs no turning; one that is less than this along it holds nothing,
# since what the other shape lies on are faces below it, and is taken so far [m] from that.
ALONG = wp.constant(0.9999)
HOLDS = wp.constant(0.7)
APART = wp.constant(0.02)
# Likewise the normal of what lies on its round side, of which the axis is at most this much along that of the face.
ROUND_ALONG = wp.constant(1.0 - 1.0e-6)
LYING = wp.constant(0.5)
# How much nearer [m] to the face than a contact the lowest part of a round side is, more where numbers are coarser.
NEARER = wp.constant(2.0e-6)


@wp.kernel(enable_backward=False)
def turn_hulls_to_faces(
    # shape
    is_hull: wp.array[wp.int32],
    is_mesh: wp.array[wp.int32],
    mesh: wp.array[wp.uint64],
    scale: wp.array[wp.vec3],
    transform: wp.array[wp.transform],
    shape_body: wp.array[wp.int32],
    middle: wp.array[wp.vec3],
    is_of_revolution: wp.array[wp.int32],
    # body
    body_q: wp.array[wp.transform],
    # in and out
    contacts: ContactArrays,
):
    """Give contacts of flat shapes whose normal leads along a face of the mesh, where nothing stands, that of the face.

    What lies on some triangles of a plane is in front of the edges of the next ones, where it would stop. What rolls
    is held where it is lowest alone. `middle` is that of each shape, in its own frame; those that
    `is_of_revolution` are round about their z axis.
    """
    contact = wp.tid()
    if contact >= contacts.count[0]:
        return
    side = side_of_mesh(contact, is_mesh, is_hull, contacts)
    if side == 0.0:
        return

    triangles = shape_on(side, contact, contacts)
    other = shape_on(-side, contact, contacts)
    point = world_point(shape_body[triangles], point_on(side, contact, contacts), body_q)
    on_other = world_point(shape_body[other], point_on(-side, contact, contacts), body_q)
    center = wp.transform_point(shape_to_world(other, transform, shape_body, body_q), middle[other])

    # The face, in the frame and the units of the mesh.
    to_world = shape_to_world(triangles, transform, shape_body, body_q)
    to_mesh = wp.transform_inverse(to_world)
    size = scale[triangles][0]
    normal = wp.transform_vector(to_mesh, side * contacts.normal[contact])
    lip = (LIP + LIP_BY_SIZE * wp.length(point)) / size
    beside = BESIDE / size
    at = wp.transform_point(to_mesh, point) / size
    center = wp.transform_point(to_mesh, center) / size
    below = wp.transform_point(to_mesh, on_other) / size
    # Where edges are parallel to faces the narrow phase finds points above the mesh.
    nearest = wp.mesh_query_point_no_sign(mesh[triangles], at, FAR)
    if not nearest.result:
        return
    face = wp.mesh_eval_position(mesh[triangles], nearest.face, nearest.u, nearest.v)
    face_normal = wp.mesh_eval_face_normal(mesh[triangles], nearest.face)
    up = wp.vec3(0.0, 0.0, 0.0)
    if is_of_revolution[other] != 0:
        axis = wp.transform_vector(shape_to_world(other, transform, shape_body, body_q), wp.vec3(0.0, 0.0, 1.0))
        nearer = (NEARER + LIP_BY_SIZE * wp.length(point)) / size
        axis = wp.transform_vector(to_mesh, axis)
        up = lower_side(mesh[triangles], face, face_normal, normal, below, center, axis, lip, nearer)
    rolls = wp.length_sq(up) > 0.0
    if not rolls:
        up = level_face(mesh[triangles], face, face_normal, normal, center, lip, beside)
    if wp.length_sq(up) == 0.0:
        return
    # Beyond the edge of the mesh nothing holds the other shape.
    below = below - wp.dot(below - face, up) * up
    if not rolls and not wp.mesh_query_point_no_sign(mesh[triangles], below, beside).result:
        return
    holds = not rolls and wp.dot(normal, up) >= HOLDS
    up = wp.transform_vector(to_world, up)
    nearest_point = wp.transform_point(to_world, below * size)
    if not holds:
        nearest_point = nearest_point - APART * up
    turn(contact, side, up, nearest_point, shape_body[triangles], body_q, contacts)


@wp.func
def on_side_of(direction: wp.vec3, normal: wp.vec3):
    """Return a normal, turned round if it does not lead to the side of a direction."""
    if wp.dot(normal, direction) < 0.0:
        return -normal
    return normal


@wp.func
def level_face(
    mesh: wp.uint64,
    at: wp.vec3,
    face_normal: wp.vec3,
    normal: wp.vec3,
    center: wp.vec3,
    lip: float,
    beside: float,
):
    """Return the normal of the face of a mesh along which the `normal` of a contact at one of its points leads.

    The face begins `beside` the point, is level with it within `lip`, has nothing standing on it there, and its normal
    is on the side of `center`. Zero where there is no such face, or where `face_normal`, that of the face at the point,
    needs no turning.
    """
    none = wp.vec3(0.0, 0.0, 0.0)
    if wp.abs(wp.dot(normal, face_normal)) > ALONG:
        return none
    found = wp.mesh_query_point_no_sign(mesh, at + beside * normal, 2.0 * beside)
    if not found.result:
        return none
    next_to = wp.mesh_eval_position(mesh, found.face, found.u, found.v)
    up = on_side_of(center - at, wp.mesh_eval_face_normal(mesh, found.face))
    along = wp.dot(normal, up)
    if along < -0.01 or along > ALONG or wp.abs(wp.dot(next_to - at, up)) > lip:
        return none
    aside = wp.normalize(normal - along * up)
    if wp.dot(next_to - at, aside) < 0.3 * beside:
        return none
    if wp.mesh_query_ray(mesh, at + lip * up + beside * aside, -aside, 2.0 * beside).result:
        return none
    return up


@wp.func
def lower_side(
    mesh: wp.uint64,
    at: wp.vec3,
    face_normal: wp.vec3,
    normal: wp.vec3,
    on_side: wp.vec3,
    center: wp.vec3,
    axis: wp.vec3,
    lip: float,
    nearer: float,
):
    """Return the normal of the face at a point of a mesh if a round side rolls on it there; zero if not.

    That is where the lowest part of the side, at the same place along its `axis` as the point `on_side` of a contact,
    is nearer to the face than that: the part ahead comes down as it moves on, and meets the face when it is the lowest.
    """
    none = wp.vec3(0.0, 0.0, 0.0)
    up = on_side_of(center - at, face_normal)
    along = wp.dot(normal, up)
    if along <= 0.0 or along > ROUND_ALONG or wp.abs(wp.dot(axis, up)) > LYING:
        return none
    arm = on_side - center
    out = arm - wp.dot(arm, axis) * axis
    lowest = on_side - out - wp.length(out) * wp.normalize(up - wp.dot(up, axis) * axis)
    gap = wp.dot(on_side - at, up)
    found = wp.mesh_query_point_no_sign(mesh, lowest, wp.length(on_side - at) + wp.length(out))
    if not found.result:
        return none
    foot = wp.mesh_eval_position(mesh, found.face, found.u, found.v)
    lowest_gap = wp.dot(lowest - foot, up)
    is_below = wp.length(lowest - foot - lowest_gap * up) <= lip and wp.abs(wp.dot(foot - at, up)) <= lip
    if not is_below or lowest_gap > gap - nearer:
        return none
    return up
