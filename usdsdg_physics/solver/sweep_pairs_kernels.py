"""Warp kernel over shapes on the CPU: find the pairs whose boxes overlap, as Newton's broad phase does."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018, RUF046

from pathlib import Path

import warp as wp
from newton._src.geometry.broad_phase_common import (
    is_pair_excluded,
    is_shape_pair_immovable_filtered,
    is_shape_pair_same_body_filtered,
    test_group_pair,
)

wp.set_module_options({"enable_backward": False})

_FOLDER = Path(__file__).parent
# Along which Newton sweeps: no axis of the world, along which things in rooms are beside each other.
DIRECTION = wp.constant(wp.vec3(0.5935, 0.7790, 0.1235))
# What a sweep keeps of each shape: where it begins and ends along the direction, and the bounds of its box.
ROWS = 8


@wp.func_native(f"{{\n{(_FOLDER / 'sort_boxes.cpp').read_text()}\n}}")
def sort_boxes(
    direction: wp.vec3,
    lower: wp.array[wp.vec3],
    upper: wp.array[wp.vec3],
    shapes: wp.array[int],
    order: wp.array[int],
    boxes: wp.array2d[float],
): ...


@wp.func_native(f"{{\n{(_FOLDER / 'next_overlap.cpp').read_text()}\n}}")
def next_overlap(boxes: wp.array2d[float], place: int, begin: int, end: int) -> int: ...


@wp.func_native(f"{{\n{(_FOLDER / 'end_of_overlaps.cpp').read_text()}\n}}")
def end_of_overlaps(order: wp.array[int], boxes: wp.array2d[float], place: int) -> int: ...


@wp.kernel(enable_backward=False)
def sweep_pairs(
    # shape
    lower: wp.array[wp.vec3],
    upper: wp.array[wp.vec3],
    group: wp.array[int],
    shape_body: wp.array[int],
    body_flags: wp.array[int],
    excluded: wp.array[wp.vec2i],
    excluded_count: int,
    immovable_pairs: bool,
    # those that collide
    shapes: wp.array[int],
    # in and out
    order: wp.array[int],
    boxes: wp.array2d[float],
    # out
    pairs: wp.array[wp.vec2i],
    count: wp.array[int],
):
    """Find the pairs of `shapes` (S,) whose boxes overlap, in one thread, by a sweep along `DIRECTION`.

    `order` (S,) is that in which the sweep before met them, `boxes` (ROWS, S) room for them in this order.
    """
    sort_boxes(wp.normalize(DIRECTION), lower, upper, shapes, order, boxes)
    found = int(0)
    for place in range(shapes.shape[0]):
        shape = shapes[order[place]]
        end = end_of_overlaps(order, boxes, place)
        other = next_overlap(boxes, place, place + 1, end)
        while other < end:
            shape2 = shapes[order[other]]
            pair = wp.vec2i(wp.min(shape, shape2), wp.max(shape, shape2))
            if may_touch(pair, group, shape_body, body_flags, excluded, excluded_count, immovable_pairs):
                if found < pairs.shape[0]:
                    pairs[found] = pair
                found += 1
            other = next_overlap(boxes, place, other + 1, end)
    count[0] = found


@wp.func
def may_touch(
    pair: wp.vec2i,
    group: wp.array[int],
    shape_body: wp.array[int],
    body_flags: wp.array[int],
    excluded: wp.array[wp.vec2i],
    excluded_count: int,
    immovable_pairs: bool,
):
    """Return whether two shapes collide with each other."""
    if not test_group_pair(group[pair[0]], group[pair[1]]):
        return False
    if is_shape_pair_same_body_filtered(pair[0], pair[1], shape_body):
        return False
    if is_shape_pair_immovable_filtered(pair[0], pair[1], shape_body, body_flags, immovable_pairs):
        return False
    return not is_pair_excluded(pair, excluded, excluded_count)
