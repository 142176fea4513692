"""Warp functions that gather the numbers of a unit, so that sweeps read them from one place."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018, RUF046

import warp as wp

from usdsdg_physics.solver.dense_rows import dense_dot
from usdsdg_physics.solver.sweep_arrays import (
    AFTER_HEADER,
    CONTACT_ROW,
    DENSE_FRICTION,
    FREE_FRICTION,
    FREE_LIMIT,
    FRICTION_AXES,
    FRICTION_PATCH,
    FRICTION_ROWS,
    HEADER_SIZE,
    PATCH_ROWS,
    Islands,
    Rows,
)

# Ratio of two masses from which more sweeps are needed until the lighter body carries the heavier one; no ratio is a
# whole number, so that rounding does not decide.
HEAVIER = wp.constant(15.9)
HEAVIEST = wp.constant(150.9)  # from which those that 15.9 needs do not suffice
# That in stacks, where what lies on the heavier body presses, too; and where each lies on a lighter one, of which
# `burden_class` counts the contacts.
HEAVIER_IN_STACKS = wp.constant(5.9)
HEAVIER_IN_EACH = wp.constant(2.9)
MANY_CONTACTS = wp.constant(8)  # of two boxes that each lie on a lighter one
COUNTED = wp.constant(4)  # what a contact adds to a number whose rest is 3, 2, 1 or 0
MOST_BURDENED = wp.constant(3)


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
        if dof_a >= 0 and dof_b >= 0:
            islands.burdened[island] = with_burden(islands.burdened[island], carries_heavier(rows, row))
        islands.numbers[at + AFTER_HEADER] = rows.free_inverse_diagonal[0, row]
        return gather_row(rows, islands, at + CONTACT_ROW, row)
    islands.numbers[at + AFTER_HEADER] = rows.free_mu[0, row]
    set_axes(rows, islands, at, row)
    set_patch(rows, islands, at, rows.free_parent[0, row])
    return gather_row(rows, islands, gather_row(rows, islands, at + FRICTION_ROWS, row), row + 1)


@wp.func
def carries_heavier(rows: Rows, row: int):
    """Return whether one of the two bodies of a contact lies on the other, and is heavier.

    The number is `MOST_BURDENED`, 2, 1 in stacks, `COUNTED` in stacks of many such contacts, or 0.
    """
    inverse_a = float(0.0)
    inverse_b = float(0.0)
    weight = float(0.0)  # positive where gravity presses body A on body B
    for k in range(3):  # of the normal, which has length 1
        normal = rows.free_jacobian_a[0, row, k]
        inverse_a += normal * rows.free_response_a[0, row, k]
        inverse_b += rows.free_jacobian_b[0, row, k] * rows.free_response_b[0, row, k]
        weight -= normal * rows.gravity[0][k]
    below = wp.where(weight > 0.0, inverse_b, inverse_a)
    above = wp.where(weight > 0.0, inverse_a, inverse_b)
    if not wp.abs(weight) > 0.5 * wp.length(rows.gravity[0]) or not below > HEAVIER_IN_EACH * above:
        return 0
    if not below > HEAVIER_IN_STACKS * above:
        return COUNTED
    if below > HEAVIEST * above:
        return MOST_BURDENED
    return wp.where(below > HEAVIER * above, 2, 1)


@wp.func
def with_burden(before: int, found: int):
    """Return the number of an island with what `carries_heavier` found at one more contact."""
    if found == COUNTED:
        return before + COUNTED
    return before - before % COUNTED + wp.max(before % COUNTED, found)


@wp.func
def burden_class(burden: int):
    """Return 2 where a light body carries a much heavier one, or `MOST_BURDENED`, 1 where it does in a stack, or 0."""
    return wp.max(burden % COUNTED, wp.where(burden >= MANY_CONTACTS * COUNTED, 1, 0))


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
    """Copy the six numbers of a row to `numbers`; return the place after them."""
    for k in range(6):
        numbers[at + k] = rows[0, row, k]
    return at + 6


@wp.func
def set_integer(numbers: wp.array[float], at: int, value: int):
    """Store an integer's bits."""
    numbers[at] = wp.cast(value, wp.float32)


@wp.func
def set_axes(rows: Rows, islands: Islands, at: int, row: int):
    """Store the axes of two rows of friction."""
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
    store_axes(islands.numbers, at + FRICTION_AXES, first, cross, second)


@wp.func
def store_axes(numbers: wp.array[float], at: int, first: float, cross: float, second: float):
    """Store the eigenvalues and the axis of two rows that influence themselves and each other so much."""
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
    numbers[at] = scale
    numbers[at + 1] = large
    numbers[at + 2] = small
    numbers[at + 3] = axis[0]
    numbers[at + 4] = axis[1]


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
    """Return 1 / x, and 0 of what is not positive."""
    inverse = float(0.0)
    if x > 0.0:
        inverse = 1.0 / x
    return inverse
