"""Warp kernel that colors pairs of bodies, so that those of one color can be solved at the same time."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018, RUF046

import warp as wp

from usdsdg_physics.contact_solver.arrays import COLORS, OPEN, OVERFLOW, Bodies, Pairs
from usdsdg_physics.contact_solver.thread_barrier import wait_for_all

ALL_COLORS = wp.constant(wp.uint32(0xFFFFFFFF))
# Rounds in which pairs choose their colors; in each, those choose that come first at both of their bodies.
MAX_ROUNDS = 256
ROUNDS = wp.constant(MAX_ROUNDS)
HASH_BITS = wp.constant(wp.int64(26))
DEGREE_BITS = wp.constant(wp.int64(10))
MAX_DEGREE = wp.constant((1 << 10) - 1)


@wp.kernel(enable_backward=False)
def color_pairs(
    threads: wp.int32,
    blocks: wp.int32,
    bodies: Bodies,
    degree: wp.array[wp.int32],
    # in and out
    counter: wp.array[wp.int32],
    bid: wp.array[wp.int64],
    taken: wp.array[wp.uint32],
    still_open: wp.array[wp.int32],
    pairs: Pairs,
):
    """Give each pair the first color that no other pair of its moving bodies has, pairs of busy bodies first.

    The result depends neither on the number of threads nor on their order. `taken` has a bit for each color.
    """
    thread = wp.tid()
    count = pairs.count[0]
    passed = int(0)
    for turn in range(ROUNDS):
        for pair in range(thread, count, threads):
            if pairs.color[pair] == OPEN:
                first = pairs.first[pair]
                second = pairs.second[pair]
                if (taken[first] | taken[second]) == ALL_COLORS:
                    pairs.color[pair] = OVERFLOW
                else:
                    offer = priority(pair, first, second, turn, degree)
                    if bodies.moves[first] != 0:
                        wp.atomic_max(bid, first, offer)
                    if bodies.moves[second] != 0:
                        wp.atomic_max(bid, second, offer)
        passed = wait_for_all(counter, blocks, passed)
        left = int(0)
        for pair in range(thread, count, threads):
            if pairs.color[pair] == OPEN:
                first = pairs.first[pair]
                second = pairs.second[pair]
                offer = priority(pair, first, second, turn, degree)
                moves0 = bodies.moves[first] != 0
                moves1 = bodies.moves[second] != 0
                if (not moves0 or bid[first] == offer) and (not moves1 or bid[second] == offer):
                    color = lowest_free(taken[first] | taken[second])
                    pairs.color[pair] = color
                    if moves0:
                        taken[first] = taken[first] | (wp.uint32(1) << wp.uint32(color))
                    if moves1:
                        taken[second] = taken[second] | (wp.uint32(1) << wp.uint32(color))
                else:
                    left += 1
        if left > 0:
            wp.atomic_add(still_open, turn, left)
        passed = wait_for_all(counter, blocks, passed)
        if still_open[turn] == 0:
            break


@wp.func
def priority(pair: int, first: int, second: int, turn: int, degree: wp.array[wp.int32]):
    """Return which of the pairs of a body goes first; no two are equal, and those of later turns are higher."""
    busy = wp.int64(wp.min(wp.max(degree[first], degree[second]), MAX_DEGREE))
    mixed = (wp.int64(pair) * wp.int64(40503161)) & ((wp.int64(1) << HASH_BITS) - wp.int64(1))
    return (((wp.int64(turn + 1) << DEGREE_BITS) | busy) << HASH_BITS) | mixed


@wp.func
def lowest_free(taken: wp.uint32):
    """Return the lowest color whose bit is not set; the last one where all are taken."""
    color = int(0)
    while color < COLORS - 1 and (taken & (wp.uint32(1) << wp.uint32(color))) != wp.uint32(0):
        color += 1
    return color
