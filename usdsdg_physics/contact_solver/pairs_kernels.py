"""Warp kernels that sort contacts to pairs of bodies, and list the pairs by color."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

from usdsdg_physics.contact_solver.arrays import GROUND, OPEN, OVERFLOW, Bodies, Pairs


@wp.kernel(enable_backward=False)
def set_keys(
    # contact
    count: wp.array[wp.int32],
    shape0: wp.array[wp.int32],
    shape1: wp.array[wp.int32],
    # scene
    shape_body: wp.array[wp.int32],
    bodies: Bodies,
    world: wp.int32,
    bits: wp.int64,
    # out
    key: wp.array[wp.int64],
    contact_of: wp.array[wp.int32],
):
    """Give each contact the pair of its bodies as a key; contacts that move nothing come last."""
    contact = wp.tid()
    contact_of[contact] = contact
    key[contact] = (wp.int64(1) << (wp.int64(2) * bits)) - wp.int64(1)
    if contact >= count[0]:
        return
    first = body_of(shape0[contact], shape_body, world)
    second = body_of(shape1[contact], shape_body, world)
    if first == second or bodies.moves[first] + bodies.moves[second] == 0:
        return
    key[contact] = (wp.int64(wp.min(first, second)) << bits) | wp.int64(wp.max(first, second))


@wp.func
def body_of(shape: int, shape_body: wp.array[wp.int32], world: int):
    """Return the row of a shape's body; `world` for none."""
    if shape < 0 or shape_body[shape] < 0:
        return world
    return shape_body[shape]


@wp.kernel(enable_backward=False)
def mark_first_rows(
    key: wp.array[wp.int64],
    bits: wp.int64,
    # out
    is_first: wp.array[wp.int32],
):
    """Mark the first row of each pair."""
    row = wp.tid()
    none = (wp.int64(1) << (wp.int64(2) * bits)) - wp.int64(1)
    is_first[row] = 0
    if key[row] == none:
        return
    # Warp would read key[-1] in `row == 0 or ...`.
    is_first[row] = 1
    if row > 0:
        is_first[row] = wp.where(key[row - 1] != key[row], 1, 0)


@wp.kernel(enable_backward=False)
def find_pairs(
    key: wp.array[wp.int64],
    pair_number: wp.array[wp.int32],
    bits: wp.int64,
    bodies: Bodies,
    world: wp.int32,
    # out
    pairs: Pairs,
    degree: wp.array[wp.int32],
):
    """Fill in the bodies and rows of the pairs; `pair_number` of a row counts from one."""
    row = wp.tid()
    last = pair_number.shape[0] - 1
    if row == last:
        pairs.count[0] = pair_number[last]
    none = (wp.int64(1) << (wp.int64(2) * bits)) - wp.int64(1)
    if key[row] == none:
        return
    pair = pair_number[row] - 1
    is_first = bool(row == 0)
    if row > 0:
        is_first = key[row - 1] != key[row]
    is_last = bool(row == last)
    if row < last:
        is_last = key[row + 1] != key[row]
    if is_last:
        pairs.end[pair] = row + 1
    if not is_first:
        return
    first = int(key[row] >> bits)
    second = int(key[row] & ((wp.int64(1) << bits) - wp.int64(1)))
    pairs.begin[pair] = row
    pairs.first[pair] = first
    pairs.second[pair] = second
    color = OPEN
    if second == world:
        color = GROUND
        wp.atomic_add(pairs.group_size, GROUND, 1)
    else:
        if bodies.moves[first] != 0:
            wp.atomic_add(degree, first, 1)
        if bodies.moves[second] != 0:
            wp.atomic_add(degree, second, 1)
    pairs.color[pair] = color


@wp.kernel(enable_backward=False)
def count_colors(
    bodies: Bodies,
    # in and out
    pairs: Pairs,
):
    """Count the pairs of each color, and the pairs without one of each body."""
    pair = wp.tid()
    if pair >= pairs.count[0]:
        return
    if pairs.color[pair] == OPEN:
        pairs.color[pair] = OVERFLOW
    color = pairs.color[pair]
    if color == GROUND:
        return
    wp.atomic_add(pairs.group_size, color, 1)
    if color == OVERFLOW:
        wp.atomic_add(bodies.overflow_count, pairs.first[pair], 1)
        wp.atomic_add(bodies.overflow_count, pairs.second[pair], 1)


@wp.kernel(enable_backward=False)
def order_pairs(
    # in and out
    pairs: Pairs,
):
    """List the pairs by color; where a pair is among those of its color makes no difference to any result."""
    pair = wp.tid()
    if pair >= pairs.count[0]:
        return
    color = pairs.color[pair]
    place = pairs.group_begin[color] + wp.atomic_add(pairs.group_filled, color, 1)
    pairs.order[place] = pair
