"""Warp kernel that finds where light bodies carry heavy ones, of which sweeps have to go over many times."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018, RUF046

import warp as wp

from usdsdg_physics.contact_solver.arrays import MOST_BURDENED, Bodies, Pairs, Rows
from usdsdg_physics.contact_solver.thread_barrier import wait_for_all

HEAVIER = wp.constant(16.0)  # ratio of two masses from which on the lighter body is burdened
# That in stacks, where what lies on the heavier body presses, too, and how many pairs of bodies these have at least.
HEAVIER_IN_STACKS = wp.constant(6.0)
STACK_PAIRS = wp.constant(4)
REACH = wp.constant(8)  # how many bodies from one that is burdened others belong to it


@wp.kernel(enable_backward=False)
def find_burdened(
    threads: wp.int32,
    blocks: wp.int32,
    gravity: wp.array[wp.vec3],
    rows: Rows,
    # in and out
    counter: wp.array[wp.int32],
    bodies: Bodies,
    pairs: Pairs,
):
    """Mark the bodies near those that lie on much lighter ones, and count and list the pairs of marked ones.

    A mark is the number of the round in which it was made, so the result does not depend on the order of threads.
    """
    thread = wp.tid()
    count = pairs.count[0]
    passed = int(0)
    for pair in range(thread, count, threads):
        first = pairs.first[pair]
        second = pairs.second[pair]
        if bodies.moves[first] != 0 and bodies.moves[second] != 0:
            n = rows.normal[pairs.begin[pair]]
            weight = wp.dot(n, gravity[0])  # negative where the second body is above
            light0 = wp.dot(n, wp.cw_mul(bodies.inverse_mass[first], n))
            light1 = wp.dot(n, wp.cw_mul(bodies.inverse_mass[second], n))
            below = wp.where(weight < 0.0, light0, light1)
            above = wp.where(weight < 0.0, light1, light0)
            if wp.abs(weight) > 0.5 * wp.length(gravity[0]) and below > HEAVIER_IN_STACKS * above:
                bodies.burden[first] = 1
                bodies.burden[second] = 1
                wp.atomic_max(pairs.burdened, 0, wp.where(below > HEAVIER * above, 2, 1))
    passed = wait_for_all(counter, blocks, passed)
    most = pairs.burdened[0]
    if most == 0:
        return
    for turn in range(1, REACH):
        for pair in range(thread, count, threads):
            spread(pairs.first[pair], pairs.second[pair], turn, bodies)
            spread(pairs.second[pair], pairs.first[pair], turn, bodies)
        passed = wait_for_all(counter, blocks, passed)
    found = int(0)
    for pair in range(thread, count, threads):
        if is_burdened(pair, bodies, pairs):
            found += 1
    if found > 0:
        wp.atomic_add(pairs.burdened, 0, found)
    passed = wait_for_all(counter, blocks, passed)
    if thread == 0 and most == 1 and pairs.burdened[0] - most < STACK_PAIRS:
        pairs.burdened[0] = 0
    if pairs.burdened[0] > MOST_BURDENED:
        return
    for pair in range(thread, count, threads):
        if is_burdened(pair, bodies, pairs):
            group = pairs.color[pair]
            place = wp.atomic_add(pairs.burdened_size, group, 1)
            if place < MOST_BURDENED:
                pairs.burdened_order[group, place] = pair


@wp.func
def is_burdened(pair: int, bodies: Bodies, pairs: Pairs):
    """Return whether one of the bodies of a pair has a `burden`."""
    return bodies.burden[pairs.first[pair]] != 0 or bodies.burden[pairs.second[pair]] != 0


@wp.func
def spread(body: int, other: int, turn: int, bodies: Bodies):
    """Mark a body that moves next to one that was marked before this turn."""
    mark = bodies.burden[body]
    if mark > 0 and mark <= turn and bodies.moves[other] != 0 and bodies.burden[other] == 0:
        bodies.burden[other] = turn + 1
