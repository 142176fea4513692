"""First contact of a convex shape that moves along a straight line: conservative advancement over GJK distances.

The moving shape advances by its distance over the rate at which the distance shrinks, which never passes a contact.
Double precision throughout. (Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996, section 2.3.2.)
"""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportIndexIssue=false, reportOperatorIssue=false
# pyright: reportInvalidTypeForm=false

# ruff: noqa: UP018, RUF046, SIM109

import warp as wp

from usdsdg_physics.queries.overlap_kernels import (
    CAPSULE,
    MESH,
    PLANE,
    SPHERE,
    Simplex,
    core_support,
    nearest_on_simplex,
)

# Distance [m] at which the advance stops and the rest is extrapolated: the directions of shorter vectors are inexact.
MARGIN = wp.constant(wp.float64(1.0e-6))
MISS = wp.constant(wp.float64(-1.0))


@wp.func
def spanning_weights(s: Simplex, count: int, p: wp.vec3d):
    """Return the weights of one to three vertices whose weighted sum is p, a point that they span."""
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    if count == 1:
        return wp.vec3d(one, zero, zero)
    if count == 2:
        along = s[1] - s[0]
        t = wp.dot(p - s[0], along) / wp.dot(along, along)
        return wp.vec3d(one - t, t, zero)
    normal = wp.cross(s[1] - s[0], s[2] - s[0])
    area = wp.dot(normal, normal)
    u = wp.dot(wp.cross(s[1] - p, s[2] - p), normal) / area
    v = wp.dot(wp.cross(s[2] - p, s[0] - p), normal) / area
    return wp.vec3d(u, v, one - u - v)


@wp.func
def core_gap(
    query_kind: int,
    query_size: wp.vec3d,
    query_to_shape: wp.transformd,
    kind: int,
    size: wp.vec3d,
    first: int,
    count: int,
    points: wp.array[wp.vec3d],
):
    """Return the unit normal of the widest gap between planes that separate two cores, its width, and where it starts.

    The width is that of the shortest vector from the shape's core to the query's, never more; 0 where they overlap.
    """
    shape_to_query = wp.transform_inverse(query_to_shape)
    v = wp.transform_point(query_to_shape, wp.vec3d(wp.float64(0.0), wp.float64(0.0), wp.float64(0.0)))
    simplex = Simplex()
    feet = Simplex()  # points of the shape, one for each vertex of the simplex
    n = int(0)
    foot = wp.vec3d(wp.float64(0.0), wp.float64(0.0), wp.float64(0.0))
    normal = wp.vec3d(wp.float64(0.0), wp.float64(0.0), wp.float64(0.0))
    width = wp.float64(0.0)
    for _ in range(64):
        length = wp.dot(v, v)
        if length <= wp.float64(1.0e-24):
            return normal, wp.float64(0.0), foot
        far = wp.transform_point(
            query_to_shape, core_support(query_kind, query_size, 0, 0, points, wp.transform_vector(shape_to_query, -v))
        )
        own = core_support(kind, size, first, count, points, v)
        w = far - own
        if n > 0 and wp.dot(v, w) > width * wp.sqrt(length):
            width = wp.dot(v, w) / wp.sqrt(length)
            normal = v / wp.sqrt(length)
        if n > 0 and length - wp.dot(v, w) <= wp.float64(1.0e-12) * length:
            return normal, width, foot
        simplex[n] = w
        feet[n] = own
        n += 1
        v, mask = nearest_on_simplex(simplex, n)
        if mask == 15:
            return normal, wp.float64(0.0), foot
        kept = int(0)
        for i in range(n):
            if (mask & (1 << i)) != 0:
                simplex[kept] = simplex[i]
                feet[kept] = feet[i]
                kept += 1
        n = kept
        weights = spanning_weights(simplex, n, v)
        foot = feet[0] * weights[0]
        if n > 1:
            foot = foot + feet[1] * weights[1]
        if n > 2:
            foot = foot + feet[2] * weights[2]
    return normal, width, foot


@wp.func
def first_contact(
    query_kind: int,
    query_size: wp.vec3d,
    query_to_shape: wp.transformd,
    query_radius: wp.float64,
    direction: wp.vec3d,
    limit: wp.float64,
    kind: int,
    size: wp.vec3d,
    first: int,
    count: int,
    points: wp.array[wp.vec3d],
    shape_radius: wp.float64,
):
    """Return how far the query moves until it touches the shape, MISS if it does not, the normal and the contact.

    A query that overlaps at the start has distance 0, the normal against its motion, and its center as contact.
    """
    at = wp.transform_get_translation(query_to_shape)
    turned = wp.transform_get_rotation(query_to_shape)
    radius = query_radius + shape_radius
    moved = wp.float64(0.0)
    apart = wp.float64(-1.0)  # the largest advance at which the two are known to be apart
    margin = wp.float64(MARGIN)
    for i in range(128):
        placed = wp.transformd(at + direction * moved, turned)
        normal, width, foot = core_gap(query_kind, query_size, placed, kind, size, first, count, points)
        gap = width - radius
        if i == 0 and gap <= wp.float64(0.0):
            return moved, -direction, at
        if width == wp.float64(0.0):
            # Rounding made a short gap look like an overlap: go back, and stop at a wider gap from here on.
            moved = wp.float64(0.5) * (apart + moved)
            margin = wp.float64(4.0) * margin
        else:
            apart = moved
            closing = -wp.dot(normal, direction)
            if closing <= wp.float64(1.0e-12):
                return MISS, direction, at
            if gap <= wp.float64(2.0) * margin:
                touched = moved + gap / closing
                if touched > limit:
                    return MISS, direction, at
                return touched, normal, foot + normal * shape_radius
            moved += (gap - margin) / closing
            if moved > limit:
                return MISS, direction, at
    return MISS, direction, at


@wp.kernel(enable_backward=False)
def sweeps(
    # scene
    kinds: wp.array[wp.int32],
    sizes: wp.array[wp.vec3d],
    frames: wp.array[wp.transformd],
    first_points: wp.array[wp.int32],
    point_counts: wp.array[wp.int32],
    points: wp.array[wp.vec3d],
    candidates: wp.array[wp.int32],
    # query
    query_kind: int,
    query_size: wp.vec3d,
    query_frame: wp.transformd,
    direction: wp.vec3d,
    limit: wp.float64,
    both_sides: int,
    # out
    distances: wp.array[wp.float64],
    normals: wp.array[wp.vec3d],
    contacts: wp.array[wp.vec3d],
    faces: wp.array[wp.int32],
):
    """Write the first contact of the moving box or sphere with shape candidates[i]: its distance is MISS for none.

    `faces` is the triangle of a mesh, -1 otherwise; triangles that face along the motion count if `both_sides`.
    """
    row = wp.tid()
    shape = candidates[row]
    kind = kinds[shape]
    size = sizes[shape]
    first = first_points[shape]
    count = point_counts[shape]
    to_shape = wp.transform_inverse(frames[shape])
    placed = wp.transform_multiply(to_shape, query_frame)
    along = wp.transform_vector(to_shape, direction)
    query_radius = wp.float64(0.0)
    if query_kind == SPHERE:
        query_radius += query_size[0]
    shape_radius = wp.float64(0.0)
    if kind == SPHERE or kind == CAPSULE:
        shape_radius += size[0]
    best = MISS
    best_normal = -along
    best_contact = wp.transform_get_translation(placed)
    best_face = int(-1)
    if kind == PLANE:
        up = wp.vec3d(wp.float64(0.0), wp.float64(0.0), wp.float64(1.0))
        down = wp.transform_vector(wp.transform_inverse(placed), -up)
        lowest = wp.transform_point(placed, core_support(query_kind, query_size, 0, 0, points, down))
        gap = lowest[2] - query_radius
        if gap <= wp.float64(0.0):
            best = wp.float64(0.0)
        elif along[2] < wp.float64(0.0) and gap / -along[2] <= limit:
            best = gap / -along[2]
            best_normal = up
            best_contact = lowest + along * best - up * query_radius
    elif kind == MESH:
        for corner in range(first, first + count, 3):
            a = wp.cw_mul(points[corner], size)
            facing = wp.cross(wp.cw_mul(points[corner + 1], size) - a, wp.cw_mul(points[corner + 2], size) - a)
            mirrored = size[0] * size[1] * size[2] < wp.float64(0.0)
            away = wp.dot(facing, along)
            if mirrored:
                away = -away
            if both_sides != 0 or away < wp.float64(0.0):
                reach = wp.where(best >= wp.float64(0.0), best, limit)
                found, normal, contact = first_contact(
                    query_kind, query_size, placed, query_radius, along, reach, kind, size, corner, 3, points,
                    shape_radius,
                )  # fmt: skip
                if found >= wp.float64(0.0) and (best < wp.float64(0.0) or found < best):
                    best = found
                    best_normal = normal
                    best_contact = contact
                    best_face = (corner - first) // 3
    else:
        best, best_normal, best_contact = first_contact(
            query_kind, query_size, placed, query_radius, along, limit, kind, size, first, count, points, shape_radius
        )
    distances[row] = best
    normals[row] = wp.transform_vector(frames[shape], best_normal)
    contacts[row] = wp.transform_point(frames[shape], best_contact)
    faces[row] = best_face
