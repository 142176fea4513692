"""Exact overlap of convex shapes: GJK distance between their cores, in double precision.

The core of a sphere or capsule is its center or axis; its radius is added to the distance.
"""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018, RUF046, SIM109

from typing import Any

import warp as wp

# Indices in SHAPE_KINDS.
BOX, SPHERE, CAPSULE, CYLINDER, CONE, PLANE, HULL, MESH = range(8)

Simplex = wp.types.matrix(shape=(4, 3), dtype=wp.float64)


@wp.func
def core_support(kind: int, size: wp.vec3d, first: int, count: int, points: wp.array[wp.vec3d], d: wp.vec3d):
    """Support function of a shape's core: its farthest point along d, in the shape's frame."""
    zero = wp.float64(0.0)
    if kind == BOX:
        return wp.vec3d(
            wp.where(d[0] < zero, -size[0], size[0]),
            wp.where(d[1] < zero, -size[1], size[1]),
            wp.where(d[2] < zero, -size[2], size[2]),
        )
    if kind == CAPSULE:
        return wp.vec3d(zero, zero, wp.where(d[2] < zero, -size[1], size[1]))
    if kind == CYLINDER or kind == CONE:
        flat = wp.sqrt(d[0] * d[0] + d[1] * d[1])
        x = size[0]
        y = zero
        if flat > wp.float64(1.0e-30):
            x = size[0] * d[0] / flat
            y = size[0] * d[1] / flat
        if kind == CYLINDER:
            return wp.vec3d(x, y, wp.where(d[2] < zero, -size[1], size[1]))
        if d[2] * size[1] > x * d[0] + y * d[1] - d[2] * size[1]:
            return wp.vec3d(zero, zero, size[1])
        return wp.vec3d(x, y, -size[1])
    if kind == HULL or kind == MESH:
        best = wp.cw_mul(points[first], size)
        reach = wp.dot(best, d)
        for i in range(1, count):
            candidate = wp.cw_mul(points[first + i], size)
            along = wp.dot(candidate, d)
            if along > reach:
                reach = along
                best = candidate
        return best
    return wp.vec3d(zero, zero, zero)


@wp.func
def nearest_on_segment(a: wp.vec3d, b: wp.vec3d):
    """Return the point of a segment nearest to the origin, and a bit mask of the ends that span it."""
    along = b - a
    t = -wp.dot(a, along)
    length = wp.dot(along, along)
    if t <= wp.float64(0.0) or length <= wp.float64(0.0):
        return a, int(1)
    if t >= length:
        return b, int(2)
    return a + along * (t / length), int(3)


@wp.func
def nearest_on_triangle(a: wp.vec3d, b: wp.vec3d, c: wp.vec3d):
    """Return the point of a triangle nearest to the origin, and a bit mask of the corners that span it."""
    zero = wp.float64(0.0)
    normal = wp.cross(b - a, c - a)
    area = wp.dot(normal, normal)
    if area > zero:
        u = wp.dot(wp.cross(b, c), normal)
        v = wp.dot(wp.cross(c, a), normal)
        w = wp.dot(wp.cross(a, b), normal)
        if u > zero and v > zero and w > zero:
            return normal * (wp.dot(a, normal) / area), int(7)
    best, mask = nearest_on_segment(a, b)
    p, m = nearest_on_segment(b, c)
    if wp.dot(p, p) < wp.dot(best, best):
        best = p
        mask = m * 2
    p, m = nearest_on_segment(a, c)
    if wp.dot(p, p) < wp.dot(best, best):
        best = p
        mask = (m & 1) | ((m & 2) * 2)
    return best, mask


@wp.func
def nearest_on_simplex(s: Any, count: int):
    """Return the point of a simplex nearest to the origin, and a bit mask of the vertices that span it (15: inside)."""
    if count == 1:
        return s[0], int(1)
    if count == 2:
        return nearest_on_segment(s[0], s[1])
    if count == 3:
        return nearest_on_triangle(s[0], s[1], s[2])
    best = wp.vec3d(wp.float64(0.0), wp.float64(0.0), wp.float64(0.0))
    mask = int(15)
    shortest = wp.float64(1.0e300)
    for opposite in range(4):
        i = wp.where(opposite == 0, 1, 0)
        j = wp.where(opposite <= 1, 2, 1)
        k = wp.where(opposite <= 2, 3, 2)
        normal = wp.cross(s[j] - s[i], s[k] - s[i])
        inner = wp.dot(s[opposite] - s[i], normal)
        # The origin is outside this face when it lies on the other side than the fourth vertex; a flat
        # tetrahedron has no inside at all.
        if wp.dot(-s[i], normal) * inner <= wp.float64(0.0):
            p, m = nearest_on_triangle(s[i], s[j], s[k])
            length = wp.dot(p, p)
            if length < shortest:
                shortest = length
                best = p
                mask = 0
                if (m & 1) != 0:
                    mask = mask | (1 << i)
                if (m & 2) != 0:
                    mask = mask | (1 << j)
                if (m & 4) != 0:
                    mask = mask | (1 << k)
    return best, mask


@wp.func
def separated(
    query_kind: int,
    query_size: wp.vec3d,
    query_first: int,
    query_count: int,
    query_to_shape: wp.transformd,
    kind: int,
    size: wp.vec3d,
    first: int,
    count: int,
    points: wp.array[wp.vec3d],
    radius: wp.float64,
):
    """Return whether the cores are farther apart than `radius`; everything is in the frame of the shape."""
    shape_to_query = wp.transform_inverse(query_to_shape)
    v = wp.transform_point(query_to_shape, wp.vec3d(wp.float64(0.0), wp.float64(0.0), wp.float64(0.0)))
    simplex = Simplex()
    n = int(0)
    for _ in range(64):
        length = wp.dot(v, v)
        if length <= wp.float64(1.0e-24):
            return False
        away = -v
        # Minkowski difference, the query's core minus the shape's: v is its point nearest to the origin so far.
        far = wp.transform_point(
            query_to_shape,
            core_support(
                query_kind, query_size, query_first, query_count, points, wp.transform_vector(shape_to_query, away)
            ),
        )
        w = far - core_support(kind, size, first, count, points, v)
        reach = wp.dot(v, w)
        if reach > wp.float64(0.0) and reach * reach > radius * radius * length:
            return True
        if length - reach <= wp.float64(1.0e-12) * length:
            return length > radius * radius
        simplex[n] = w
        n += 1
        v, mask = nearest_on_simplex(simplex, n)
        if mask == 15:
            return False
        kept = int(0)
        for i in range(n):
            if (mask & (1 << i)) != 0:
                simplex[kept] = simplex[i]
                kept += 1
        n = kept
    return wp.dot(v, v) > radius * radius


@wp.kernel(enable_backward=False)
def overlaps(
    # scene
    enabled: wp.array[wp.bool],
    bodies: wp.array[wp.int32],
    frames: wp.array[wp.transformd],
    bounds: wp.array[wp.vec4d],
    kinds: wp.array[wp.int32],
    sizes: wp.array[wp.vec3d],
    first_points: wp.array[wp.int32],
    point_counts: wp.array[wp.int32],
    points: wp.array[wp.vec3d],
    # body
    poses: wp.array[wp.transformd],
    # query
    query_kind: int,
    query_size: wp.vec3d,
    query_frame: wp.transformd,
    # out
    hit: wp.array[wp.int32],
):
    """Set hit[i] = 1 where the enabled shape i and the query box or sphere overlap, else 0.

    `frames` are in the body's frame, in the world where `bodies` is -1; `bounds` are center and radius of a sphere
    around each shape. The points of a mesh are the corners of its triangles, three in a row.
    """
    shape = wp.tid()
    hit[shape] = 0
    if not enabled[shape]:
        return
    frame = frames[shape]
    if bodies[shape] >= 0:
        pose = poses[bodies[shape]]
        rotation = wp.normalize(wp.transform_get_rotation(pose))
        frame = wp.transform_multiply(wp.transformd(wp.transform_get_translation(pose), rotation), frame)
    # Most shapes are far away, or entirely inside.
    bound = bounds[shape]
    center = wp.transform_point(frame, wp.vec3d(bound[0], bound[1], bound[2]))
    center = wp.transform_point(wp.transform_inverse(query_frame), center)
    gap = wp.length(center) - query_size[0]
    farthest = gap
    if query_kind == BOX:
        beyond = wp.vec3d()
        farthest = wp.abs(center[0]) - query_size[0]
        for i in range(3):
            farthest = wp.max(farthest, wp.abs(center[i]) - query_size[i])
            beyond[i] = wp.max(wp.abs(center[i]) - query_size[i], wp.float64(0.0))
        gap = wp.length(beyond)
    if gap > bound[3]:
        return
    if farthest + bound[3] <= wp.float64(0.0):
        hit[shape] = 1
        return
    # Of most that overlap, a vertex or the center is inside.
    inner = wp.vec3d()
    if kinds[shape] == HULL or kinds[shape] == MESH:
        inner = wp.cw_mul(points[first_points[shape]], sizes[shape])
    inner = wp.transform_point(wp.transform_inverse(query_frame), wp.transform_point(frame, inner))
    outside = wp.length(inner) - query_size[0]
    if query_kind == BOX:
        outside = wp.abs(inner[0]) - query_size[0]
        for i in range(1, 3):
            outside = wp.max(outside, wp.abs(inner[i]) - query_size[i])
    if outside < wp.float64(0.0):
        hit[shape] = 1
        return
    apart = is_apart(
        query_kind,
        query_size,
        0,
        0,
        wp.transform_multiply(wp.transform_inverse(frame), query_frame),
        kinds[shape],
        sizes[shape],
        first_points[shape],
        point_counts[shape],
        points,
    )
    if not apart:
        hit[shape] = 1


@wp.kernel(enable_backward=False)
def pairs_overlap(
    # scene
    kinds: wp.array[wp.int32],
    sizes: wp.array[wp.vec3d],
    frames: wp.array[wp.transformd],
    first_points: wp.array[wp.int32],
    point_counts: wp.array[wp.int32],
    points: wp.array[wp.vec3d],
    pairs: wp.array2d[wp.int32],
    # out
    hit: wp.array[wp.int32],
):
    """Set hit[i] = 1 where the convex shape pairs[i, 0] and the shape pairs[i, 1] overlap."""
    row = wp.tid()
    query = pairs[row, 0]
    shape = pairs[row, 1]
    apart = is_apart(
        kinds[query],
        sizes[query],
        first_points[query],
        point_counts[query],
        wp.transform_multiply(wp.transform_inverse(frames[shape]), frames[query]),
        kinds[shape],
        sizes[shape],
        first_points[shape],
        point_counts[shape],
        points,
    )
    hit[row] = wp.where(apart, 0, 1)


@wp.func
def is_apart(
    query_kind: int,
    query_size: wp.vec3d,
    query_first: int,
    query_count: int,
    query_to_shape: wp.transformd,
    kind: int,
    size: wp.vec3d,
    first: int,
    count: int,
    points: wp.array[wp.vec3d],
):
    """Return whether a convex shape and one of any kind do not overlap."""
    radius = wp.float64(0.0)
    if query_kind == SPHERE or query_kind == CAPSULE:
        radius += query_size[0]
    if kind == SPHERE or kind == CAPSULE:
        radius += size[0]
    apart = bool(True)
    if kind == PLANE:
        up = wp.vec3d(wp.float64(0.0), wp.float64(0.0), wp.float64(-1.0))
        down = wp.transform_vector(wp.transform_inverse(query_to_shape), up)
        support = core_support(query_kind, query_size, query_first, query_count, points, down)
        lowest = wp.transform_point(query_to_shape, support)
        apart = lowest[2] > radius
    elif kind == MESH:
        for corner in range(first, first + count, 3):
            if apart:
                apart = separated(
                    query_kind,
                    query_size,
                    query_first,
                    query_count,
                    query_to_shape,
                    kind,
                    size,
                    corner,
                    3,
                    points,
                    radius,
                )
    else:
        apart = separated(
            query_kind, query_size, query_first, query_count, query_to_shape, kind, size, first, count, points, radius
        )
    return apart
