"""Warp kernel over pairs of shapes that the broad phase found: leave out those whose turned boxes are apart."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

from usdsdg_physics.solver.hull_corners import HULL, farthest_corner

wp.set_module_options({"enable_backward": False})

# Of what boxes must be apart, as part of their sizes and of their distance from the origin: rounding.
TOLERANCE = wp.constant(1.0e-4)
ORIGIN_TOLERANCE = wp.constant(1.0e-6)


@wp.kernel(enable_backward=False)
def drop_separated_pairs(
    # shape
    bounded: wp.array[wp.int32],
    kind: wp.array[wp.int32],
    scale: wp.array[wp.vec3],
    source: wp.array[wp.uint64],
    lower: wp.array[wp.vec3],
    upper: wp.array[wp.vec3],
    gap: wp.array[wp.float32],
    margin: wp.array[wp.float32],
    transform: wp.array[wp.transform],
    # pair
    count: wp.array[wp.int32],
    stride: wp.int32,
    # in and out
    pairs: wp.array[wp.vec2i],
):
    """Make both shapes -1 of each pair of `bounded` ones whose boxes, in their own axes, are too far apart to touch.

    The broad phase compares boxes along the axes of the world, which are much larger than a turned body. Hulls count
    themselves in place of their boxes.
    """
    first = wp.tid()
    for i in range(first, wp.min(count[0], pairs.shape[0]), stride):
        a = pairs[i][0]
        b = pairs[i][1]
        if a < 0 or b < 0:
            continue
        if bounded[a] == 0 or bounded[b] == 0:
            continue
        half_a = 0.5 * (upper[a] - lower[a])
        half_b = 0.5 * (upper[b] - lower[b])
        center_a = wp.transform_point(transform[a], 0.5 * (lower[a] + upper[a]))
        center_b = wp.transform_point(transform[b], 0.5 * (lower[b] + upper[b]))
        reach = gap[a] + gap[b] + margin[a] + margin[b] + TOLERANCE * (wp.length(half_a) + wp.length(half_b))
        reach += ORIGIN_TOLERANCE * (wp.length(center_a) + wp.length(center_b))
        # All in the axes of the first box.
        inverse = wp.quat_inverse(wp.transform_get_rotation(transform[a]))
        turn = wp.quat_to_matrix(inverse * wp.transform_get_rotation(transform[b]))
        offset = wp.quat_rotate(inverse, center_b - center_a)
        if boxes_are_apart(half_a, half_b, offset, turn, reach):
            pairs[i] = wp.vec2i(-1, -1)
        elif kind[a] == HULL or kind[b] == HULL:
            # In the axes of the first box, with the middle of each as its origin: from one middle to the other, or to
            # the nearest point of a box, which shows that what lies beside a wall is apart from that.
            across = offset
            if kind[a] != HULL:
                across = offset - nearest_in_box(half_a, offset)
            elif kind[b] != HULL:
                across = offset + turn * nearest_in_box(half_b, -(offset * turn))
            direction = wp.normalize(wp.where(wp.length_sq(across) > 0.0, across, offset))
            point_a = farthest_of(kind[a], source[a], scale[a], lower[a], upper[a], direction)
            point_b = farthest_of(kind[b], source[b], scale[b], lower[b], upper[b], -(direction * turn))
            if wp.dot(direction, offset + turn * point_b - point_a) > reach:
                pairs[i] = wp.vec2i(-1, -1)


@wp.func
def nearest_in_box(half: wp.vec3, point: wp.vec3):
    """Return the point of a box around the origin that is nearest to another."""
    return wp.max(wp.min(point, half), -half)


@wp.func
def farthest_of(kind: int, source: wp.uint64, scale: wp.vec3, lower: wp.vec3, upper: wp.vec3, direction: wp.vec3):
    """Return the point of a hull that is farthest along a direction, of another shape that of its box.

    Both are seen from the middle of the box.
    """
    half = 0.5 * (upper - lower)
    if kind != HULL:
        return wp.vec3(
            wp.where(direction[0] > 0.0, half[0], -half[0]),
            wp.where(direction[1] > 0.0, half[1], -half[1]),
            wp.where(direction[2] > 0.0, half[2], -half[2]),
        )
    corner = farthest_corner(source, wp.cw_mul(direction, scale))
    return wp.cw_mul(wp.mesh_get(source).points[corner], scale) - 0.5 * (lower + upper)


@wp.func
def boxes_are_apart(half_a: wp.vec3, half_b: wp.vec3, offset: wp.vec3, turn: wp.mat33, reach: float):
    """Return whether two boxes are farther apart than `reach` along a face normal, or the product of two edges.

    `offset` is the center of the second box, the columns of `turn` are its axes, in the frame of the first.
    """
    size = wp.matrix_from_rows(
        wp.vec3(wp.abs(turn[0, 0]), wp.abs(turn[0, 1]), wp.abs(turn[0, 2])),
        wp.vec3(wp.abs(turn[1, 0]), wp.abs(turn[1, 1]), wp.abs(turn[1, 2])),
        wp.vec3(wp.abs(turn[2, 0]), wp.abs(turn[2, 1]), wp.abs(turn[2, 2])),
    )
    along_a = size * half_b
    along_b = half_a * size
    offset_b = offset * turn
    for i in range(3):
        if wp.abs(offset[i]) > half_a[i] + along_a[i] + reach or wp.abs(offset_b[i]) > half_b[i] + along_b[i] + reach:
            return True
    for i in range(3):
        j = (i + 1) % 3
        k = (i + 2) % 3
        for m in range(3):
            n = (m + 1) % 3
            o = (m + 2) % 3
            # The product of axis i of the first box and axis m of the second; near zero where they are parallel.
            length = wp.sqrt(turn[j, m] * turn[j, m] + turn[k, m] * turn[k, m])
            if length > 1.0e-3:
                distance = wp.abs(offset[k] * turn[j, m] - offset[j] * turn[k, m])
                extent = (
                    half_a[j] * size[k, m] + half_a[k] * size[j, m] + half_b[n] * size[i, o] + half_b[o] * size[i, n]
                )
                if distance > extent + reach * length:
                    return True
    return False
