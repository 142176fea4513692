"""Warp kernels of the solver's sweeps on the CPU: arrange the rows of constraints, and solve them.

A sweep visits units: a row, or the two rows of a contact's friction. Those that share no body and no joint do not
influence each other, so that they may be visited in any order, and an island that a sweep does not change needs no
further one: the bits are those of Newton's own sweep, which visits all rows in turn, and all numbers of a row, most of
which are zero in those of joints.
"""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: SIM109, UP018, RUF046

from pathlib import Path

import warp as wp
from newton._src.solvers.steel import kernels as newton_kernels
from newton._src.solvers.steel.friction import friction_pair_candidate
from newton._src.solvers.steel.friction_patches import WARP_DETERMINISM_OFF, patch_normal_load

wp.set_module_options({"enable_backward": False, **WARP_DETERMINISM_OFF})

CONTACT = newton_kernels.PGS_CONSTRAINT_TYPE_CONTACT
FRICTION = newton_kernels.PGS_CONSTRAINT_TYPE_FRICTION
DRIVE = newton_kernels.PGS_CONSTRAINT_TYPE_JOINT_TARGET
JOINT_LIMIT = newton_kernels.PGS_CONSTRAINT_TYPE_JOINT_LIMIT
VELOCITY_LIMIT = newton_kernels.PGS_CONSTRAINT_TYPE_JOINT_VELOCITY_LIMIT

# Kinds of units. Those of free bodies have one body that moves, or one more: two.
FREE_CONTACT = wp.constant(0)
FREE_FRICTION = wp.constant(2)
FREE_LIMIT = wp.constant(4)
DENSE_ROW = wp.constant(5)
DENSE_FRICTION = wp.constant(6)
DENSE_LIMIT = wp.constant(7)
DENSE_CLAMP = wp.constant(8)

# Where in its numbers a unit has what: first kind, row, first dofs of both bodies, and island.
AFTER_HEADER = wp.constant(5)  # 1 / diagonal of a contact, friction coefficient of friction
CONTACT_ROW = wp.constant(6)  # J of each body, then M⁻¹ Jᵀ of each
FRICTION_AXES = wp.constant(6)  # scale, larger and smaller eigenvalue, and the axis of the larger
FRICTION_DIAGONALS = wp.constant(11)  # J₀ M⁻¹ J₀ᵀ, J₀ M⁻¹ J₁ᵀ, J₁ M⁻¹ J₁ᵀ
FRICTION_PATCH = wp.constant(14)  # rows of its normals, -1 after the last
PATCH_ROWS = wp.constant(9)
FRICTION_ROWS = wp.constant(23)  # of both rows what CONTACT_ROW has
HEADER_SIZE = wp.constant(8)
# Numbers that a unit of a free row needs at most, by row; friction of two bodies has 71 for two rows.
NUMBERS_PER_FREE_ROW = 36

# Steps between units in a schedule of all.
SCHEDULE_STEPS = wp.constant(1024)
# Islands that do not change any more are left out after each so many sweeps.
SWEEPS_PER_CHECK = wp.constant(4)


@wp.struct
class Rows:
    """The rows of one world, as the solver has built them: dense ones of joints, sparse ones of free bodies."""

    count: wp.array[int]  # (1,) dense rows
    type: wp.array2d[int]  # (1, M)
    parent: wp.array2d[int]  # (1, M)
    diagonal: wp.array2d[float]  # (1, M) J M⁻¹ Jᵀ
    mu: wp.array2d[float]  # (1, M)
    jacobian: wp.array3d[float]  # (1, M, D)
    response: wp.array3d[float]  # (1, M, D) M⁻¹ Jᵀ
    drive_bias: wp.array2d[float]  # (1, M), as the next three; of drives
    drive_velocity_factor: wp.array2d[float]
    drive_impulse_factor: wp.array2d[float]
    drive_max_impulse: wp.array2d[float]
    drive_max_velocity: wp.array2d[float]  # (1, M) where `clamps`
    free_count: wp.array[int]  # (1,) rows of free bodies
    free_contact_end: wp.array[int]  # (1,) where those of velocity limits begin
    free_dof_a: wp.array2d[int]  # (1, F) first of six, -1 for what does not move
    free_dof_b: wp.array2d[int]
    free_inverse_diagonal: wp.array2d[float]  # (1, F)
    free_type: wp.array2d[int]
    free_parent: wp.array2d[int]  # (1, F) of friction its normal's row, of normals the next of their patch
    free_mu: wp.array2d[float]
    free_jacobian_a: wp.array3d[float]  # (1, F, 6)
    free_jacobian_b: wp.array3d[float]
    free_response_a: wp.array3d[float]
    free_response_b: wp.array3d[float]


@wp.struct
class Islands:
    """The units of all rows in the order in which they are visited, with what is known of each island."""

    node: wp.array[int]  # (D,) body or tree of joints that a dof of the world belongs to; one of N
    dof: wp.array2d[int]  # (1, D) where the solver has the velocity of each
    velocity: wp.array[float]  # (D,) scratch of the sweeps
    count: wp.array[int]  # (1,) units
    order: wp.array[int]  # (U,) where the numbers of each begin
    active: wp.array[int]  # (U,) the same without the islands that do not change any more
    numbers: wp.array[float]
    blocks: wp.array[wp.vec4i]  # (M,) begin and end of two ranges of dofs; outside of them a dense row is zero
    changed: wp.array[int]  # (N,) whether a sweep changed something, by island
    slide: wp.array[float]  # (3,) of friction that slides: residuals, and the largest impulse
    # Scratch.
    found: wp.array[wp.vec4i]  # (U,) kind, row, the first two nodes
    root: wp.array[int]  # (N,)
    latest: wp.array[int]  # (N,)
    before: wp.array[int]  # (U,) units that have to be visited before
    step: wp.array[int]  # (U,)
    begin: wp.array[int]  # (SCHEDULE_STEPS + 1,)


@wp.func
def find_root(root: wp.array[int], node: int):
    i = int(node)
    while root[i] != i:
        root[i] = root[root[i]]
        i = root[i]
    return i


@wp.func
def join(root: wp.array[int], node: int, other: int):
    a = find_root(root, node)
    b = find_root(root, other)
    root[wp.max(a, b)] = wp.min(a, b)


@wp.kernel(enable_backward=False)
def arrange_rows(rows: Rows, clamps: int, islands: Islands):
    """Find the units of a world's rows, in which order they are visited, and gather their numbers."""
    nodes = islands.root.shape[0]
    for n in range(nodes):
        islands.root[n] = n
        islands.latest[n] = 0
    found = find_units(rows, clamps, islands)

    # A unit takes its turn by the number of units that must come before it and after it, directly or not.
    for u in range(found):
        unit = islands.found[u]
        islands.before[u] = visit(islands, unit)
        for n in range(unit[3], last_node(islands, unit) + 1):
            join(islands.root, unit[2], n)
    for n in range(nodes):
        islands.latest[n] = 0
    for s in range(SCHEDULE_STEPS + 1):
        islands.begin[s] = 0
    for reverse in range(found):
        u = found - 1 - reverse
        after = visit(islands, islands.found[u])
        before = islands.before[u]
        step = before * SCHEDULE_STEPS / (before + after + 1)
        islands.step[u] = step
        islands.begin[step + 1] += 1
    for s in range(SCHEDULE_STEPS):
        islands.begin[s + 1] += islands.begin[s]
    for u in range(found):
        step = islands.step[u]
        islands.before[islands.begin[step]] = u
        islands.begin[step] += 1

    at = int(0)
    for place in range(found):
        unit = islands.found[islands.before[place]]
        islands.order[place] = at
        at = gather(rows, islands, at, unit[0], unit[1], find_root(islands.root, unit[2]))
    islands.count[0] = found


@wp.func
def visit(islands: Islands, unit: wp.vec4i):
    """Return how many units follow each other, of those visited so far, up to this one; visit it."""
    latest = islands.latest[unit[2]]
    last = last_node(islands, unit)
    for n in range(unit[3], last + 1):
        latest = wp.max(latest, islands.latest[n])
    islands.latest[unit[2]] = latest + 1
    for n in range(unit[3], last + 1):
        islands.latest[n] = latest + 1
    return latest


@wp.func
def last_node(islands: Islands, unit: wp.vec4i):
    """Return the last node of a unit, whose second node is not that where a row connects more than two trees."""
    if unit[0] < DENSE_ROW:
        return unit[3]
    blocks = islands.blocks[unit[1]]
    return wp.max(unit[3], islands.node[wp.max(blocks[3] - 1, 0)])


@wp.func
def find_units(rows: Rows, clamps: int, islands: Islands):
    """Find the units in the order of the solver's sweep; return how many there are."""
    dense_count = wp.min(rows.count[0], rows.type.shape[1])
    free_count = wp.min(rows.free_count[0], rows.free_type.shape[1])
    free_end = wp.min(rows.free_contact_end[0], free_count)
    found = int(0)
    for i in range(dense_count):
        type = rows.type[0, i]
        other = int(i)
        if type == FRICTION:
            other = rows.parent[0, i] + 2
        islands.blocks[i] = nonzero_blocks(rows, islands, i, other)
        if type == FRICTION:
            # The first row of a pair solves the second.
            if i == rows.parent[0, i] + 1:
                islands.found[found] = dense_unit(islands, DENSE_FRICTION, i)
                found += 1
        elif type != VELOCITY_LIMIT and rows.diagonal[0, i] > 0.0:
            islands.found[found] = dense_unit(islands, DENSE_ROW, i)
            found += 1
    i = int(0)
    while i < free_end:
        row = int(i)
        i += 1
        kind = int(FREE_CONTACT)
        if rows.free_type[0, row] == FRICTION:
            if row != rows.free_parent[0, row] + 1:
                continue
            kind = int(FREE_FRICTION)
            i += 1
        elif not rows.free_inverse_diagonal[0, row] > 0.0:
            continue
        dof_a = rows.free_dof_a[0, row]
        dof_b = rows.free_dof_b[0, row]
        if dof_a >= 0 and dof_b >= 0:
            islands.found[found] = wp.vec4i(kind + 1, row, islands.node[dof_a], islands.node[dof_b])
            found += 1
        elif dof_a >= 0 or dof_b >= 0:
            node = islands.node[wp.max(dof_a, dof_b)]
            islands.found[found] = wp.vec4i(kind, row, node, node)
            found += 1
    for i in range(dense_count):
        if rows.type[0, i] == VELOCITY_LIMIT and rows.diagonal[0, i] > 0.0:
            islands.found[found] = dense_unit(islands, DENSE_LIMIT, i)
            found += 1
    if clamps != 0:
        for i in range(dense_count):
            if rows.type[0, i] == DRIVE and rows.diagonal[0, i] > 0.0:
                islands.found[found] = dense_unit(islands, DENSE_CLAMP, i)
                found += 1
    for i in range(free_end, free_count):
        dof = wp.max(rows.free_dof_a[0, i], rows.free_dof_b[0, i])
        if rows.free_type[0, i] == VELOCITY_LIMIT and rows.free_inverse_diagonal[0, i] > 0.0 and dof >= 0:
            islands.found[found] = wp.vec4i(FREE_LIMIT, i, islands.node[dof], islands.node[dof])
            found += 1
    return found


@wp.func
def nonzero_blocks(rows: Rows, islands: Islands, row: int, other: int):
    """Return a range of dofs of one node and one of others, outside of which two dense rows and responses are zero."""
    begin0 = int(0)
    end0 = int(0)
    begin1 = int(0)
    end1 = int(0)
    for d in range(islands.node.shape[0]):
        if is_nonzero(rows, row, d) or is_nonzero(rows, other, d):
            if end0 == 0:
                begin0 = d
            if end0 == 0 or (end1 == 0 and islands.node[d] == islands.node[begin0]):
                end0 = d + 1
            else:
                if end1 == 0:
                    begin1 = d
                end1 = d + 1
    if end1 == 0:
        begin1 = begin0
        end1 = begin0
    return wp.vec4i(begin0, end0, begin1, end1)


@wp.func
def is_nonzero(rows: Rows, row: int, dof: int):
    return rows.jacobian[0, row, dof] != 0.0 or rows.response[0, row, dof] != 0.0


@wp.func
def dense_unit(islands: Islands, kind: int, row: int):
    blocks = islands.blocks[row]
    return wp.vec4i(kind, row, islands.node[blocks[0]], islands.node[blocks[2]])


@wp.func
def gather(rows: Rows, islands: Islands, at: int, kind: int, row: int, island: int):
    """Gather the numbers of a unit from place `at` on; return where they end."""
    set_integer(islands.numbers, at, kind)
    set_integer(islands.numbers, at + 1, row)
    set_integer(islands.numbers, at + 4, island)
    if kind >= FREE_LIMIT:
        if kind == DENSE_FRICTION:
            islands.numbers[at + 5] = dense_dot(
                float(0.0), rows.jacobian, row, islands.blocks[row], rows.response, rows.parent[0, row] + 2
            )
        return at + HEADER_SIZE
    dof_a = rows.free_dof_a[0, row]
    dof_b = rows.free_dof_b[0, row]
    set_integer(islands.numbers, at + 2, wp.where(dof_a >= 0, dof_a, dof_b))
    set_integer(islands.numbers, at + 3, wp.max(dof_b, 0))
    if kind < FREE_FRICTION:
        islands.numbers[at + AFTER_HEADER] = rows.free_inverse_diagonal[0, row]
        return gather_row(rows, islands, at + CONTACT_ROW, row)
    islands.numbers[at + AFTER_HEADER] = rows.free_mu[0, row]
    set_axes(rows, islands, at, row)
    set_patch(rows, islands, at, rows.free_parent[0, row])
    return gather_row(rows, islands, gather_row(rows, islands, at + FRICTION_ROWS, row), row + 1)


@wp.func
def gather_row(rows: Rows, islands: Islands, begin: int, row: int):
    """Gather J and M⁻¹ Jᵀ of a row from place `begin` on; return where they end."""
    at = int(begin)
    has_a = rows.free_dof_a[0, row] >= 0
    has_b = rows.free_dof_b[0, row] >= 0
    if has_a:
        at = copy_six(islands.numbers, at, rows.free_jacobian_a, row)
    if has_b:
        at = copy_six(islands.numbers, at, rows.free_jacobian_b, row)
    if has_a:
        at = copy_six(islands.numbers, at, rows.free_response_a, row)
    if has_b:
        at = copy_six(islands.numbers, at, rows.free_response_b, row)
    return at


@wp.func
def copy_six(numbers: wp.array[float], at: int, rows: wp.array3d[float], row: int):
    for k in range(6):
        numbers[at + k] = rows[0, row, k]
    return at + 6


@wp.func
def set_integer(numbers: wp.array[float], at: int, value: int):
    """Store an integer's bits."""
    numbers[at] = wp.cast(value, wp.float32)


@wp.func
def set_axes(rows: Rows, islands: Islands, at: int, row: int):
    """Store how two rows of friction influence themselves and each other, and the eigenvalues and axes of that."""
    cross = float(0.0)
    has_a = rows.free_dof_a[0, row] >= 0
    has_b = rows.free_dof_b[0, row] >= 0
    for k in range(6):
        if has_a:
            cross += rows.free_jacobian_a[0, row, k] * rows.free_response_a[0, row + 1, k]
        if has_b:
            cross += rows.free_jacobian_b[0, row, k] * rows.free_response_b[0, row + 1, k]
    first = inverse_or_zero(rows.free_inverse_diagonal[0, row])
    second = inverse_or_zero(rows.free_inverse_diagonal[0, row + 1])
    islands.numbers[at + FRICTION_DIAGONALS] = first
    islands.numbers[at + FRICTION_DIAGONALS + 1] = cross
    islands.numbers[at + FRICTION_DIAGONALS + 2] = second

    scale = wp.max(wp.max(first, second), 1.0e-20)
    a = first / scale
    c = cross / scale
    d = second / scale
    large = 0.5 * (a + d + wp.sqrt((a - d) * (a - d) + 4.0 * c * c))
    small = float(0.0)
    if large > 0.0:
        small = wp.max((a * d - c * c) / large, 0.0)
    axis = wp.where(a >= d, wp.vec2(large - d, c), wp.vec2(c, large - a))
    if wp.length(axis) > 0.0:
        axis = wp.normalize(axis)
    else:
        axis = wp.vec2(1.0, 0.0)
    islands.numbers[at + FRICTION_AXES] = scale
    islands.numbers[at + FRICTION_AXES + 1] = large
    islands.numbers[at + FRICTION_AXES + 2] = small
    islands.numbers[at + FRICTION_AXES + 3] = axis[0]
    islands.numbers[at + FRICTION_AXES + 4] = axis[1]


@wp.func
def set_patch(rows: Rows, islands: Islands, at: int, first: int):
    """Store the rows of the normals that a unit of friction shares the load of."""
    set_integer(islands.numbers, at + FRICTION_PATCH, first)
    count = int(1)
    row = rows.free_parent[0, first]
    while row >= 0 and row != first and count < PATCH_ROWS:
        set_integer(islands.numbers, at + FRICTION_PATCH + count, row)
        count += 1
        row = rows.free_parent[0, row]
    if count < PATCH_ROWS:
        set_integer(islands.numbers, at + FRICTION_PATCH + count, -1)


@wp.func
def inverse_or_zero(x: float):
    inverse = float(0.0)
    if x > 0.0:
        inverse = 1.0 / x
    return inverse


def _snippet(name: str) -> str:
    folder = Path(__file__).parent
    return f"{{\n{(folder / 'unit.cpp').read_text()}\n{(folder / f'{name}.cpp').read_text()}\n}}"


@wp.func_native(_snippet("sweep_free"))
def sweep_free(
    rows: Rows,
    islands: Islands,
    free_bias: wp.array2d[float],
    omega: float,
    begin: int,
    count: int,
    free_impulses: wp.array2d[float],
    v: wp.array[float],
) -> int: ...


@wp.func_native(_snippet("finish_friction"))
def finish_friction(
    islands: Islands,
    place: int,
    impulse0: float,
    impulse1: float,
    free_impulses: wp.array2d[float],
    v: wp.array[float],
): ...


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
    """Sweep over the units `iterations` times, over those of each island until nothing changes."""
    v = islands.velocity
    for d in range(v.shape[0]):
        v[d] = wp.where(islands.dof[0, d] >= 0, velocity[wp.max(islands.dof[0, d], 0)], 0.0)
    count = islands.count[0]
    for place in range(count):
        islands.active[place] = islands.order[place]
    for sweep in range(iterations):
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
                if kind < FREE_LIMIT:
                    slide(islands, place, row, omega, free_impulses, v)
                elif kind == FREE_LIMIT:
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
            kept = int(0)
            for place in range(count):
                at = islands.active[place]
                if islands.changed[wp.cast(islands.numbers[at + 4], wp.int32)] != 0:
                    islands.active[kept] = at
                    kept += 1
            count = kept
    for d in range(v.shape[0]):
        if islands.dof[0, d] >= 0:
            velocity[islands.dof[0, d]] = v[d]


@wp.func
def slide(islands: Islands, place: int, row: int, omega: float, free_impulses: wp.array2d[float], v: wp.array[float]):
    """Solve friction that slides, with what `sweep_free` found of it."""
    at = islands.active[place]
    radius = islands.slide[2]
    impulse = wp.vec2(0.0)
    if radius > 0.0:
        impulse = friction_pair_candidate(
            islands.numbers[at + FRICTION_DIAGONALS],
            islands.numbers[at + FRICTION_DIAGONALS + 1],
            islands.numbers[at + FRICTION_DIAGONALS + 2],
            wp.vec2(islands.slide[0], islands.slide[1]),
            wp.vec2(free_impulses[0, row], free_impulses[0, row + 1]),
            radius,
            omega,
        )
    finish_friction(islands, place, impulse[0], impulse[1], free_impulses, v)


@wp.func
def limit_free(
    rows: Rows, row: int, free_bias: wp.array2d[float], free_impulses: wp.array2d[float], v: wp.array[float]
):
    """Take from a free body the speed that is above its limit; return whether there is some."""
    speed = float(0.0)
    dof_a = rows.free_dof_a[0, row]
    dof_b = rows.free_dof_b[0, row]
    for k in range(6):
        if dof_a >= 0:
            speed += rows.free_jacobian_a[0, row, k] * v[dof_a + k]
        if dof_b >= 0:
            speed += rows.free_jacobian_b[0, row, k] * v[dof_b + k]
    residual = speed + free_bias[0, row]
    impulse = float(0.0)
    if residual < 0.0:
        impulse = -residual * rows.free_inverse_diagonal[0, row]
    free_impulses[0, row] = impulse
    if impulse == 0.0:
        return 0
    for k in range(6):
        if dof_a >= 0:
            v[dof_a + k] = v[dof_a + k] + rows.free_response_a[0, row, k] * impulse
        if dof_b >= 0:
            v[dof_b + k] = v[dof_b + k] + rows.free_response_b[0, row, k] * impulse
    return 1


@wp.func
def dense_dot(start: float, rows: wp.array3d[float], row: int, blocks: wp.vec4i, others: wp.array3d[float], other: int):
    total = float(start)
    for d in range(blocks[0], blocks[1]):
        total += rows[0, row, d] * others[0, other, d]
    for d in range(blocks[2], blocks[3]):
        total += rows[0, row, d] * others[0, other, d]
    return total


@wp.func
def dense_speed(start: float, rows: Rows, row: int, blocks: wp.vec4i, v: wp.array[float]):
    total = float(start)
    for d in range(blocks[0], blocks[1]):
        total += rows.jacobian[0, row, d] * v[d]
    for d in range(blocks[2], blocks[3]):
        total += rows.jacobian[0, row, d] * v[d]
    return total


@wp.func
def add_dense(rows: Rows, row: int, blocks: wp.vec4i, impulse: float, v: wp.array[float]):
    """Add the change of velocities by an impulse; return whether it is one."""
    if impulse == 0.0:
        return 0
    for d in range(blocks[0], blocks[1]):
        v[d] = v[d] + rows.response[0, row, d] * impulse
    for d in range(blocks[2], blocks[3]):
        v[d] = v[d] + rows.response[0, row, d] * impulse
    return 1


@wp.func
def solve_dense(
    rows: Rows,
    blocks: wp.vec4i,
    row: int,
    bias: wp.array2d[float],
    omega: float,
    impulses: wp.array2d[float],
    v: wp.array[float],
):
    """Solve a drive, a limit, a contact or an equation of joints."""
    speed = dense_speed(float(0.0), rows, row, blocks, v)
    old = impulses[0, row]
    type = rows.type[0, row]
    impulse = float(0.0)
    if type == DRIVE:
        largest = rows.drive_max_impulse[0, row]
        impulse = (
            old * rows.drive_impulse_factor[0, row]
            + speed * rows.drive_velocity_factor[0, row]
            + rows.drive_bias[0, row]
        )
        impulse = wp.min(wp.max(impulse, -largest), largest)
    else:
        impulse = old + omega * (-(speed + bias[0, row]) / rows.diagonal[0, row])
        if impulse < 0.0 and (type == CONTACT or type == JOINT_LIMIT):
            impulse = 0.0
    impulses[0, row] = impulse
    return add_dense(rows, row, blocks, impulse - old, v)


@wp.func
def solve_dense_friction(
    rows: Rows,
    blocks: wp.vec4i,
    row: int,
    cross: float,
    bias: wp.array2d[float],
    omega: float,
    impulses: wp.array2d[float],
    v: wp.array[float],
):
    """Solve the two rows of friction of a link's contact."""
    normal = rows.parent[0, row]
    sibling = normal + 2
    radius = wp.max(rows.mu[0, row] * patch_normal_load(rows.parent, impulses, 0, normal), 0.0)
    old = wp.vec2(impulses[0, row], impulses[0, sibling])
    residual = wp.vec2(
        dense_speed(float(0.0), rows, row, blocks, v) + bias[0, row],
        dense_speed(bias[0, sibling], rows, sibling, blocks, v),
    )
    impulse = friction_pair_candidate(
        rows.diagonal[0, row], cross, rows.diagonal[0, sibling], residual, old, radius, omega
    )
    length = wp.length(impulse)
    scale = float(1.0)
    if length > radius:
        scale = radius / length
    impulse = impulse * scale
    impulses[0, row] = impulse[0]
    impulses[0, sibling] = impulse[1]
    changed = add_dense(rows, sibling, blocks, impulse[1] - old[1], v)
    return wp.max(changed, add_dense(rows, row, blocks, impulse[0] - old[0], v))


@wp.func
def limit_dense(
    rows: Rows, blocks: wp.vec4i, row: int, bias: wp.array2d[float], impulses: wp.array2d[float], v: wp.array[float]
):
    """Take from an axis the speed that is above its limit."""
    residual = dense_speed(float(0.0), rows, row, blocks, v) + bias[0, row]
    impulse = float(0.0)
    if residual < 0.0:
        impulse = -residual / rows.diagonal[0, row]
    impulses[0, row] = impulse
    return add_dense(rows, row, blocks, impulse, v)


@wp.func
def clamp_dense(rows: Rows, blocks: wp.vec4i, row: int, v: wp.array[float]):
    """Take from a driven axis the speed that is above its limit."""
    largest = rows.drive_max_velocity[0, row]
    speed = dense_speed(float(0.0), rows, row, blocks, v)
    if wp.abs(speed) <= largest:
        return 0
    return add_dense(rows, row, blocks, (wp.min(wp.max(speed, -largest), largest) - speed) / rows.diagonal[0, row], v)
