"""Warp kernels of the solver's sweeps on the CPU: arrange the rows of constraints, and solve them.

A sweep visits units: a row, or the two rows of a contact's friction. Those that share no body and no joint do not
influence each other, so that they may be visited in any order, and an island that a sweep does not change needs no
further one: the bits are those of Newton's own sweep, which visits all rows in turn, and all numbers of a row, most of
which are zero in those of joints.
"""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018, RUF046

import warp as wp
from newton._src.solvers.steel.friction_patches import WARP_DETERMINISM_OFF

from usdsdg_physics.solver.dense_rows import clamp_dense, limit_dense, solve_dense, solve_dense_friction
from usdsdg_physics.solver.find_units import find_root, find_units, join, last_node, visit
from usdsdg_physics.solver.free_rows import limit_free, sweep_free
from usdsdg_physics.solver.gather_units import MOST_BURDENED, burden_class, gather
from usdsdg_physics.solver.sweep_arrays import (
    DENSE_FRICTION,
    DENSE_LIMIT,
    DENSE_ROW,
    DRIVE,
    FREE_LIMIT,
    KINDS,
    Islands,
    Rows,
)

wp.set_module_options({"enable_backward": False, **WARP_DETERMINISM_OFF})

# Islands that do not change any more are left out after each so many sweeps.
SWEEPS_PER_CHECK = wp.constant(4)
# Times as many sweeps where light bodies carry heavy ones: 150 kg on 1 kg stand, as in PhysX. In islands of more
# units, such as heaps, others carry the load too, and a step would take half as long again.
MORE_SWEEPS = wp.constant(5)
# Likewise where one is hundreds of times as heavy as what it lies on.
MOST_SWEEPS = wp.constant(20)
MOST_UNITS = wp.constant(100)
STACK_UNITS = wp.constant(30)  # two boxes, one on the other, have fewer, and stand without


@wp.kernel(enable_backward=False)
def arrange_rows(rows: Rows, clamps: int, islands: Islands):
    """Find the units of a world's rows, in which order they are visited, and gather their numbers."""
    nodes = islands.root.shape[0]
    for n in range(nodes):
        islands.root[n] = n
        islands.latest[n] = 0
        islands.burdened[n] = 0
    found = find_units(rows, clamps, islands)

    # A unit takes its turn by the number of units that must come before it and after it, directly or not.
    for u in range(found):
        unit = islands.found[u]
        islands.before[u] = visit(islands, unit)
        for n in range(unit[3], last_node(islands, unit) + 1):
            join(islands.root, unit[2], n)
    for n in range(nodes):
        islands.latest[n] = 0
    longest = int(1)
    for reverse in range(found):
        u = found - 1 - reverse
        islands.after[u] = visit(islands, islands.found[u])
        longest = wp.max(longest, islands.before[u] + islands.after[u] + 1)
    # As many steps as units follow each other keep those apart in which one must come before the other, so that all of
    # a step may be visited in any order: kind by kind, which the processor foresees.
    for s in range(KINDS * longest + 1):
        islands.begin[s] = 0
    for u in range(found):
        before = islands.before[u]
        step = wp.int32(wp.int64(before) * wp.int64(longest) / wp.int64(before + islands.after[u] + 1))
        place = KINDS * step + wp.min(islands.found[u][0], KINDS - 1)
        islands.step[u] = place
        islands.begin[place + 1] += 1
    for s in range(KINDS * longest):
        islands.begin[s + 1] += islands.begin[s]
    for u in range(found):
        place = islands.step[u]
        islands.before[islands.begin[place]] = u
        islands.begin[place] += 1

    at = int(0)
    for place in range(found):
        unit = islands.found[islands.before[place]]
        islands.order[place] = at
        island = find_root(islands.root, unit[2])
        islands.latest[island] += 1
        at = gather(rows, islands, at, unit[0], unit[1], island)
    islands.count[0] = found
    for n in range(nodes):
        units = islands.latest[n]
        islands.burdened[n] = burden_class(islands.burdened[n])
        if units > MOST_UNITS or (islands.burdened[n] == 1 and units <= STACK_UNITS):
            islands.burdened[n] = 0


@wp.func
def keep_marked(islands: Islands, marked: wp.array[int], least: int, count: int):
    """Keep of the first `count` active units those of islands with a mark of at least `least`; return their number."""
    kept = int(0)
    for place in range(count):
        at = islands.active[place]
        if marked[wp.cast(islands.numbers[at + 4], wp.int32)] >= least:
            islands.active[kept] = at
            kept += 1
    return kept


@wp.kernel(enable_backward=False)
def solve_rows(
    rows: Rows,
    islands: Islands,
    bias: wp.array2d[float],
    free_bias: wp.array2d[float],
    iterations: int,
    omega: float,
    freeze_drives: int,
    # in and out
    impulses: wp.array2d[float],
    free_impulses: wp.array2d[float],
    velocity: wp.array[float],
):
    """Sweep over the units `iterations` times, over those of each island until nothing changes.

    Small islands in which light bodies carry heavy ones get `MORE_SWEEPS` times as many, or `MOST_SWEEPS`.
    """
    v = islands.velocity
    for d in range(v.shape[0]):
        v[d] = wp.where(islands.dof[0, d] >= 0, velocity[wp.max(islands.dof[0, d], 0)], 0.0)
    count = islands.count[0]
    for place in range(count):
        islands.active[place] = islands.order[place]
    for sweep in range(MOST_SWEEPS * iterations):
        if sweep == iterations:
            count = keep_marked(islands, islands.burdened, 1, count)
        if sweep == MORE_SWEEPS * iterations:
            count = keep_marked(islands, islands.burdened, MOST_BURDENED, count)
        if count == 0:
            break
        checks = (sweep + 1) % SWEEPS_PER_CHECK == 2
        if checks:
            for n in range(islands.changed.shape[0]):
                islands.changed[n] = 0
        place = int(0)
        while place < count:
            place = sweep_free(rows, islands, free_bias, omega, place, count, free_impulses, v)
            if place < count:
                at = islands.active[place]
                kind = wp.cast(islands.numbers[at], wp.int32)
                row = wp.cast(islands.numbers[at + 1], wp.int32)
                changed = int(0)
                if kind == FREE_LIMIT:
                    changed = limit_free(rows, row, free_bias, free_impulses, v)
                elif kind == DENSE_ROW:
                    if freeze_drives == 0 or rows.type[0, row] != DRIVE:
                        changed = solve_dense(rows, islands.blocks[row], row, bias, omega, impulses, v)
                elif kind == DENSE_FRICTION:
                    cross = islands.numbers[at + 5]
                    changed = solve_dense_friction(rows, islands.blocks[row], row, cross, bias, omega, impulses, v)
                elif kind == DENSE_LIMIT:
                    changed = limit_dense(rows, islands.blocks[row], row, bias, impulses, v)
                else:
                    changed = clamp_dense(rows, islands.blocks[row], row, v)
                if changed != 0:
                    islands.changed[wp.cast(islands.numbers[at + 4], wp.int32)] = 1
                place += 1
        if checks:
            count = keep_marked(islands, islands.changed, 1, count)
    for d in range(v.shape[0]):
        if islands.dof[0, d] >= 0:
            velocity[islands.dof[0, d]] = v[d]
