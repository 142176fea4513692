"""Warp kernels over contacts: turn those at the seams of triangles to the faces beside them."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018

import warp as wp

from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays

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
    triangles = contacts.shape0[contact]
    other = contacts.shape1[contact]
    if triangles < 0 or other < 0:
        return
    point = contacts.point0[contact]
    sign = float(1.0)  # makes the normal point from the mesh to the other shape
    if is_mesh[triangles] == 0:
        triangles = contacts.shape1[contact]
        other = contacts.shape0[contact]
        point = contacts.point1[contact]
        sign = float(-1.0)
    if is_mesh[triangles] == 0 or is_round[other] == 0:
        return

    to_world = transform[triangles]
    body = shape_body[triangles]
    if body >= 0:
        point = wp.transform_point(body_q[body], point)
        to_world = body_q[body] * to_world
    to_mesh = wp.transform_inverse(to_world)
    size = scale[triangles][0]
    at = wp.transform_point(to_mesh, point) / size
    normal = wp.transform_vector(to_mesh, sign * contacts.normal[contact])
    distance = (DISTANCE + DISTANCE_BY_SIZE * wp.length(point)) / size
    above = at + distance * normal
    query = wp.mesh_query_point_no_sign(mesh[triangles], above, REACH * distance)
    if not query.result:
        return
    closest = wp.mesh_eval_position(mesh[triangles], query.face, query.u, query.v)
    if wp.length(closest - at) > ASIDE * distance and wp.length(above - closest) > ASIDE * distance:
        contacts.normal[contact] = sign * wp.transform_vector(to_world, wp.normalize(above - closest))


# How far [m] faces may stand out beside a seam, more where numbers are coarser; and where beside it they are looked at.
LIP = wp.constant(1.0e-4)
LIP_BY_SIZE = wp.constant(1.0e-6)
BESIDE = wp.constant(1.0e-3)
# A normal that is this much along that of the face needs no turning; one that is less than this along it holds nothing,
# since what the other shape lies on are faces below it, and is taken so far [m] from that.
ALONG = wp.constant(0.9999)
HOLDS = wp.constant(0.7)
APART = wp.constant(0.02)


@wp.kernel(enable_backward=False)
def turn_hulls_to_faces(
    # shape
    is_hull: wp.array[wp.int32],
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
    """Give contacts of flat shapes whose normal leads along a face of the mesh, where nothing stands, that of the face.

    What lies on some triangles of a plane is in front of the edges of the next ones, where it would stop.
    """
    contact = wp.tid()
    if contact >= contacts.count[0]:
        return
    triangles = contacts.shape0[contact]
    other = contacts.shape1[contact]
    if triangles < 0 or other < 0:
        return
    point = contacts.point0[contact]
    on_other = contacts.point1[contact]
    sign = float(1.0)  # makes the normal point from the mesh to the other shape
    if is_mesh[triangles] == 0:
        triangles = contacts.shape1[contact]
        other = contacts.shape0[contact]
        point = contacts.point1[contact]
        on_other = contacts.point0[contact]
        sign = float(-1.0)
    if is_mesh[triangles] == 0 or is_hull[other] == 0:
        return

    to_world = transform[triangles]
    body = shape_body[triangles]
    if body >= 0:
        point = wp.transform_point(body_q[body], point)
        to_world = body_q[body] * to_world
    center = transform[other]
    if shape_body[other] >= 0:
        on_other = wp.transform_point(body_q[shape_body[other]], on_other)
        center = body_q[shape_body[other]] * center
    to_mesh = wp.transform_inverse(to_world)
    size = scale[triangles][0]
    normal = wp.transform_vector(to_mesh, sign * contacts.normal[contact])
    lip = (LIP + LIP_BY_SIZE * wp.length(point)) / size
    beside = BESIDE / size

    # Where edges are parallel to faces the narrow phase finds points above the mesh.
    at = wp.transform_point(to_mesh, point) / size
    nearest = wp.mesh_query_point_no_sign(mesh[triangles], at, 1.0e6)
    if not nearest.result:
        return
    if wp.abs(wp.dot(normal, wp.mesh_eval_face_normal(mesh[triangles], nearest.face))) > ALONG:
        return
    at = wp.mesh_eval_position(mesh[triangles], nearest.face, nearest.u, nearest.v)
    found = wp.mesh_query_point_no_sign(mesh[triangles], at + beside * normal, 2.0 * beside)
    if not found.result:
        return
    next_to = wp.mesh_eval_position(mesh[triangles], found.face, found.u, found.v)
    up = wp.mesh_eval_face_normal(mesh[triangles], found.face)
    if wp.dot(up, wp.transform_point(to_mesh, wp.transform_get_translation(center)) / size - at) < 0.0:
        up = -up
    along = wp.dot(normal, up)
    if along < -0.01 or along > ALONG or wp.abs(wp.dot(next_to - at, up)) > lip:
        return
    aside = wp.normalize(normal - along * up)
    if wp.dot(next_to - at, aside) < 0.3 * beside:
        return
    if wp.mesh_query_ray(mesh[triangles], at + lip * up + beside * aside, -aside, 2.0 * beside).result:
        return
    # Beyond the edge of the mesh nothing holds the other shape.
    below = wp.transform_point(to_mesh, on_other) / size
    below = below - wp.dot(below - at, up) * up
    if not wp.mesh_query_point_no_sign(mesh[triangles], below, beside).result:
        return
    up = wp.transform_vector(to_world, up)
    nearest_point = wp.transform_point(to_world, below * size)
    if along < HOLDS:
        nearest_point = nearest_point - APART * up
    if body >= 0:
        nearest_point = wp.transform_point(wp.transform_inverse(body_q[body]), nearest_point)
    contacts.normal[contact] = sign * up
    if sign > 0.0:
        contacts.point0[contact] = nearest_point
    else:
        contacts.point1[contact] = nearest_point
