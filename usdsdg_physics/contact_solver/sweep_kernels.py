"""Warp kernel that solves all rows, pair after pair of bodies, over and over."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018, RUF046

import warp as wp

from usdsdg_physics.contact_solver.arrays import GROUND, GROUPS, MOST_BURDENED, OVERFLOW, Bodies, Pairs, Rows
from usdsdg_physics.contact_solver.thread_barrier import any_of_block, wait_for_all

# How often a pair of bodies with as many contacts or more solves them before the next pair has its turn. What lies on
# something with its corners comes to rest by that in a fourth of the sweeps.
ROUNDS_OF_PAIR = wp.constant(4)
VISITS = wp.constant(16)  # of the contacts of one pair, which others wait for
SETTLED = wp.constant(1.0e-4)  # part of its loads that a pair may still change before the next has its turn
# Units of an overflow change in 1 m/s or rad/s.
FIXED_POINT = wp.constant(wp.float64(2.0**36))
# A velocity that changes by less than this [m/s], [rad/s] and this part of it, which is rounding, counts as settled.
LEAST_CHANGE = wp.constant(1.0e-6)
ROUNDING = wp.constant(4.0e-7)


@wp.kernel(enable_backward=False)
def sweep(
    threads: wp.int32,
    blocks: wp.int32,
    iterations: wp.int32,
    # in and out
    counter: wp.array[wp.int32],
    bodies: Bodies,
    pairs: Pairs,
    rows: Rows,
):
    """Solve the rows of all pairs `iterations` times: color by color, those without a color, then those on the world.

    Threads solve pairs of one color at the same time and wait for each other before the next.
    """
    thread = wp.tid()
    passed = int(0)
    for _ in range(iterations):
        for color in range(OVERFLOW):
            begin = pairs.group_begin[color]
            end = pairs.group_begin[color + 1]
            if end == begin:  # pairs have the lowest colors that they can
                break
            for place in range(begin + thread, end, threads):
                solve_pair(pairs.order[place], bodies, pairs, rows)
            passed = wait_for_all(counter, blocks, passed)
        begin = pairs.group_begin[OVERFLOW]
        end = pairs.group_begin[OVERFLOW + 1]
        if end > begin:
            for place in range(begin + thread, end, threads):
                solve_overflowing_pair(pairs.order[place], bodies, pairs, rows)
            passed = wait_for_all(counter, blocks, passed)
            for body in range(thread, bodies.overflow_count.shape[0], threads):
                apply_overflow(body, bodies)
            passed = wait_for_all(counter, blocks, passed)
        begin = pairs.group_begin[GROUND]
        end = pairs.group_begin[GROUND + 1]
        if end > begin:
            for place in range(begin + thread, end, threads):
                solve_pair(pairs.order[place], bodies, pairs, rows)
            passed = wait_for_all(counter, blocks, passed)


@wp.kernel(enable_backward=False)
def sweep_burdened(
    threads: wp.int32,
    iterations: wp.int32,
    # in and out
    bodies: Bodies,
    pairs: Pairs,
    rows: Rows,
):
    """Solve the rows of the pairs near where light bodies carry heavy ones, until they change no more.

    All threads are of one block: there are few such pairs, and waiting for other blocks takes longer than solving them.
    """
    if pairs.burdened[0] == 0 or pairs.burdened[0] > MOST_BURDENED:
        return
    thread = wp.tid()
    for _ in range(iterations):
        changed = int(0)
        for group in range(GROUPS):
            size = pairs.burdened_size[group]
            if size > 0:
                for place in range(thread, size, threads):
                    pair = pairs.burdened_order[group, place]
                    if group == OVERFLOW:
                        solve_overflowing_pair(pair, bodies, pairs, rows)
                        changed = 1
                    else:
                        changed = wp.max(changed, solve_pair(pair, bodies, pairs, rows))
                changed = any_of_block(changed)
                if group == OVERFLOW:
                    for body in range(thread, bodies.overflow_count.shape[0], threads):
                        apply_overflow(body, bodies)
                    changed = any_of_block(changed)
        if changed == 0:
            break


@wp.func
def solve_pair(pair: int, bodies: Bodies, pairs: Pairs, rows: Rows):
    """Change the velocities of two bodies so that their contacts have what their rows ask for.

    Return 1 if a velocity has changed, else 0.
    """
    first = pairs.first[pair]
    second = pairs.second[pair]
    v0, w0, v1, w1 = solved(pair, first, second, 1.0, 1.0, bodies, pairs, rows)
    changed = int(0)
    if bodies.moves[first] != 0:
        changed = differ(bodies.velocity[first], v0, changed)
        changed = differ(bodies.angular[first], w0, changed)
        bodies.velocity[first] = v0
        bodies.angular[first] = w0
    if bodies.moves[second] != 0:
        changed = differ(bodies.velocity[second], v1, changed)
        changed = differ(bodies.angular[second], w1, changed)
        bodies.velocity[second] = v1
        bodies.angular[second] = w1
    return changed


@wp.func
def differ(before: wp.vec3, after: wp.vec3, already: int):
    """Return 1 if a velocity [m/s] or [rad/s] has changed by more than rounding does, or another `already` has."""
    return wp.where(wp.length(after - before) > LEAST_CHANGE + ROUNDING * wp.length(after), 1, already)


@wp.func
def solve_overflowing_pair(pair: int, bodies: Bodies, pairs: Pairs, rows: Rows):
    """Note by how much a pair would change the velocities of two bodies if these were as light as their share in it."""
    first = pairs.first[pair]
    second = pairs.second[pair]
    share0 = float(bodies.overflow_count[first])
    share1 = float(bodies.overflow_count[second])
    v0, w0, v1, w1 = solved(pair, first, second, share0, share1, bodies, pairs, rows)
    if bodies.moves[first] != 0:
        note_change(first, v0 - bodies.velocity[first], w0 - bodies.angular[first], bodies)
    if bodies.moves[second] != 0:
        note_change(second, v1 - bodies.velocity[second], w1 - bodies.angular[second], bodies)


@wp.func
def note_change(body: int, linear: wp.vec3, angular: wp.vec3, bodies: Bodies):
    """Add to what the pairs without a color change of a body: its velocities [m/s], [rad/s]."""
    for i in range(3):
        wp.atomic_add(bodies.overflow_change, body, i, wp.int64(wp.float64(linear[i]) * FIXED_POINT))
        wp.atomic_add(bodies.overflow_change, body, 3 + i, wp.int64(wp.float64(angular[i]) * FIXED_POINT))


@wp.func
def apply_overflow(body: int, bodies: Bodies):
    """Give a body the mean of the changes that its pairs without a color have noted."""
    count = bodies.overflow_count[body]
    if count == 0 or bodies.moves[body] == 0:
        return
    scale = wp.float64(1.0) / (FIXED_POINT * wp.float64(count))
    linear = wp.vec3(0.0)
    angular = wp.vec3(0.0)
    for i in range(3):
        linear[i] = wp.float32(wp.float64(bodies.overflow_change[body, i]) * scale)
        angular[i] = wp.float32(wp.float64(bodies.overflow_change[body, 3 + i]) * scale)
        bodies.overflow_change[body, i] = wp.int64(0)
        bodies.overflow_change[body, 3 + i] = wp.int64(0)
    bodies.velocity[body] = bodies.velocity[body] + linear
    bodies.angular[body] = bodies.angular[body] + angular


@wp.func
def solved(
    pair: int,
    first: int,
    second: int,
    share0: float,
    share1: float,
    bodies: Bodies,
    pairs: Pairs,
    rows: Rows,
):
    """Solve the rows of a pair, one after the other and several times, and return the velocities of both bodies.

    Their inverse masses count `share0` and `share1` times.
    """
    mass0 = share0 * bodies.inverse_mass[first]
    mass1 = share1 * bodies.inverse_mass[second]
    inertia0 = share0 * bodies.inverse_inertia[first]
    inertia1 = share1 * bodies.inverse_inertia[second]
    v0 = wp.vec3(bodies.velocity[first])
    w0 = wp.vec3(bodies.angular[first])
    v1 = wp.vec3(bodies.velocity[second])
    w1 = wp.vec3(bodies.angular[second])
    begin = pairs.begin[pair]
    end = pairs.end[pair]
    count = end - begin
    for _ in range(wp.clamp(VISITS // count, 1, wp.min(ROUNDS_OF_PAIR, count))):
        change = float(0.0)
        loads = float(0.0)
        for row in range(begin, end):
            n = rows.normal[row]
            arm0 = rows.arm0[row]
            arm1 = rows.arm1[row]
            surface = rows.surface[row]
            old = rows.impulse[row]
            t0 = rows.tangent[row]
            t1 = wp.cross(n, t0)

            relative = (v1 + wp.cross(w1, arm1)) - (v0 + wp.cross(w0, arm0)) - surface
            # What makes the surfaces stick, or where that takes more than the load allows, a step toward the force
            # that opposes their motion.
            block = rows.friction_mass[row]
            x = wp.dot(t0, relative)
            y = wp.dot(t1, relative)
            along0 = old[1] - (block[0] * x + block[1] * y)
            along1 = old[2] - (block[1] * x + block[2] * y)
            limit = rows.friction[row] * old[0]
            if along0 * along0 + along1 * along1 > limit * limit:
                along0 = old[1] - block[3] * x
                along1 = old[2] - block[3] * y
                size = wp.sqrt(along0 * along0 + along1 * along1)
                if size > limit:
                    along0 = along0 * (limit / size)
                    along1 = along1 * (limit / size)
            push = (along0 - old[1]) * t0 + (along1 - old[2]) * t1
            v0 = v0 - wp.cw_mul(mass0, push)
            w0 = w0 - inertia0 * wp.cross(arm0, push)
            v1 = v1 + wp.cw_mul(mass1, push)
            w1 = w1 + inertia1 * wp.cross(arm1, push)

            relative = (v1 + wp.cross(w1, arm1)) - (v0 + wp.cross(w0, arm0)) - surface
            load = wp.max(old[0] - rows.mass[row] * (wp.dot(n, relative) + rows.bias[row]), 0.0)
            change += wp.abs(load - old[0]) + wp.abs(along0 - old[1]) + wp.abs(along1 - old[2])
            loads += load
            push = (load - old[0]) * n
            v0 = v0 - wp.cw_mul(mass0, push)
            w0 = w0 - inertia0 * wp.cross(arm0, push)
            v1 = v1 + wp.cw_mul(mass1, push)
            w1 = w1 + inertia1 * wp.cross(arm1, push)
            rows.impulse[row] = wp.vec3(load, along0, along1)
        if change <= SETTLED * loads:
            break
    return v0, w0, v1, w1
