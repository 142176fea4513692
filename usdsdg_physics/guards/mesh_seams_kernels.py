"""Warp kernel over contacts: turn those of round shapes at the seams of triangles to the faces beside them."""

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
