"""The outlines of shapes in Warp: their farthest points, and whether points are on their surface."""

# Code of Warp functions is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: RUF046, SIM109, UP018

import newton
import warp as wp

PLANE = wp.constant(int(newton.GeoType.PLANE))
BOX = wp.constant(int(newton.GeoType.BOX))
CYLINDER = wp.constant(int(newton.GeoType.CYLINDER))
CONE = wp.constant(int(newton.GeoType.CONE))
HULL = wp.constant(int(newton.GeoType.CONVEX_MESH))
MESH = wp.constant(int(newton.GeoType.MESH))

SHORTEST = wp.constant(1.0e-6)  # of a direction, below which it has no direction


@wp.struct
class Outlines:
    """The shapes of a model, and what is needed of the bodies that they belong to."""

    kind: wp.array[wp.int32]
    # Half extents of boxes, radius and half height of cylinders and cones, which are along z, and scales of meshes.
    scale: wp.array[wp.vec3]
    mesh: wp.array[wp.uint64]
    transform: wp.array[wp.transform]  # to the body's frame, or the world's
    gap: wp.array[wp.float32]  # m
    body: wp.array[wp.int32]  # -1 for static shapes
    # Of bodies.
    center: wp.array[wp.vec3]  # m, in its frame
    free: wp.array[wp.int32]


def outlines_of(model: newton.Model, free: wp.array) -> Outlines:
    """Return the outlines of a model's shapes; `free` (N,) marks the bodies that move by themselves."""
    outlines = Outlines()
    outlines.kind, outlines.scale, outlines.mesh = model.shape_type, model.shape_scale, model.shape_source_ptr
    outlines.transform, outlines.gap, outlines.body = model.shape_transform, model.shape_gap, model.shape_body
    outlines.center, outlines.free = model.body_com, free
    return outlines


@wp.func
def is_long(shape: int, outlines: Outlines):
    """Return whether a shape may have ends, and `farthest_point` knows it."""
    kind = outlines.kind[shape]
    return kind == CYLINDER or kind == CONE or kind == HULL


@wp.func
def has_faces(shape: int, outlines: Outlines):
    """Return whether a shape may have flat faces, and `is_on` knows it."""
    kind = outlines.kind[shape]
    return kind == PLANE or kind == BOX or kind == CYLINDER or kind == HULL or kind == MESH


@wp.func
def farthest_point(shape: int, direction: wp.vec3, outlines: Outlines):
    """Return the point of a shape that `is_long`, in its own frame, that is farthest along a direction."""
    scale = outlines.scale[shape]
    if outlines.kind[shape] == HULL:
        corners = wp.mesh_get(outlines.mesh[shape]).points
        scaled = wp.cw_mul(direction, scale)
        best = int(0)
        farthest = float(-1.0e10)
        for i in range(corners.shape[0]):
            along = wp.dot(corners[i], scaled)
            if along > farthest:
                farthest = along
                best = i
        return wp.cw_mul(corners[best], scale)
    radial = wp.length(wp.vec2(direction[0], direction[1]))
    rim = wp.vec3(0.0, 0.0, 0.0)
    if radial > SHORTEST:
        rim = wp.vec3(scale[0] * direction[0] / radial, scale[0] * direction[1] / radial, 0.0)
    top = wp.vec3(0.0, 0.0, scale[1])
    if outlines.kind[shape] == CYLINDER:
        return rim + wp.where(direction[2] >= 0.0, top, -top)
    if wp.dot(direction, top) >= wp.dot(direction, rim - top):
        return top
    return rim - top


@wp.func
def is_on(point: wp.vec3, shape: int, tolerance: float, outlines: Outlines, body_q: wp.array[wp.transform]):
    """Return whether a point of the world is on the surface of a shape that `has_faces`, by a tolerance [m]."""
    to_world = outlines.transform[shape]
    if outlines.body[shape] >= 0:
        to_world = body_q[outlines.body[shape]] * to_world
    at = wp.transform_point(wp.transform_inverse(to_world), point)
    scale = outlines.scale[shape]
    kind = outlines.kind[shape]
    if kind == PLANE:
        return wp.abs(at[2]) <= tolerance
    if kind == BOX:
        outside = wp.max(wp.max(wp.abs(at[0]) - scale[0], wp.abs(at[1]) - scale[1]), wp.abs(at[2]) - scale[2])
        return wp.abs(outside) <= tolerance
    if kind == CYLINDER:
        outside = wp.max(wp.length(wp.vec2(at[0], at[1])) - scale[0], wp.abs(at[2]) - scale[1])
        return wp.abs(outside) <= tolerance
    # The mesh is in units of its own, so that its closest point is one only where it is near.
    least = wp.min(wp.abs(scale[0]), wp.min(wp.abs(scale[1]), wp.abs(scale[2])))
    in_mesh = wp.cw_div(at, scale)
    query = wp.mesh_query_point_no_sign(outlines.mesh[shape], in_mesh, tolerance / least)
    if not query.result:
        return False
    closest = wp.mesh_eval_position(outlines.mesh[shape], query.face, query.u, query.v)
    return wp.length(wp.cw_mul(closest - in_mesh, scale)) <= tolerance
