"""Warp functions of what holds a body: whether something fixed is below its center of mass."""

# Code of Warp functions is not Python to a type checker; Warp structs are no classes to it.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp
from newton import GeoType
from newton._src.geometry.raycast import ray_intersect_mesh_anyhit, ray_intersect_shape_no_normal

from usdsdg_physics.body_points import shape_to_world

MESH = wp.constant(int(GeoType.MESH))
CONVEX_MESH = wp.constant(int(GeoType.CONVEX_MESH))
PLANE = wp.constant(int(GeoType.PLANE))


@wp.struct
class FixedShapes:
    """The shapes that nothing moves but scripts and joints, and the arrays of all shapes that rays need."""

    indices: wp.array[wp.int32]  # of the fixed ones
    kind: wp.array[wp.int32]
    size: wp.array[wp.vec3]
    source: wp.array[wp.uint64]
    radius: wp.array[wp.float32]  # of the sphere about the shape's origin that holds it [m]
    transform: wp.array[wp.transform]
    body: wp.array[wp.int32]
    group: wp.array[wp.int32]  # 0 of those that do not collide


@wp.func
def is_supported(
    shape: int,
    center: wp.vec3,
    normal: wp.vec3,
    reach: float,
    fixed: FixedShapes,
    body_q: wp.array[wp.transform],
):
    """Return whether a fixed shape is at most `reach` below a center of mass, against `normal`.

    `shape` is looked at before all others, since it is the one that the body hits.
    """
    if is_hit(shape, center, -normal, reach, fixed, body_q):
        return True
    for n in range(fixed.indices.shape[0]):
        other = fixed.indices[n]
        if other != shape and fixed.group[other] != 0:  # noqa: SIM102  Warp computes both sides of an `and`
            if is_hit(other, center, -normal, reach, fixed, body_q):
                return True
    return False


@wp.func
def is_hit(
    shape: int, origin: wp.vec3, direction: wp.vec3, reach: float, fixed: FixedShapes, body_q: wp.array[wp.transform]
):
    """Return whether a ray of length `reach` from outside hits a shape."""
    pose = shape_to_world(shape, fixed.transform, fixed.body, body_q)
    kind = fixed.kind[shape]
    if kind != PLANE:
        to_shape = wp.transform_get_translation(pose) - origin
        along = wp.clamp(wp.dot(to_shape, direction), 0.0, reach)
        if wp.length(to_shape - along * direction) > fixed.radius[shape]:
            return False
    if kind == MESH or kind == CONVEX_MESH:  # noqa: SIM109
        inverse = wp.transform_inverse(pose)
        begin = wp.cw_div(wp.transform_point(inverse, origin), fixed.size[shape])
        along_mesh = wp.cw_div(wp.transform_vector(inverse, direction), fixed.size[shape])
        return ray_intersect_mesh_anyhit(begin, along_mesh, fixed.source[shape], reach) >= 0.0
    distance, _ = ray_intersect_shape_no_normal(pose, fixed.size[shape], kind, origin, direction, False)
    return distance >= 0.0 and distance <= reach
