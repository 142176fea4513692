"""Warp functions that solve the rows of free bodies."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

from pathlib import Path

import warp as wp

from usdsdg_physics.solver.sweep_arrays import Islands, Rows

_FOLDER = Path(__file__).parent
UNIT = (_FOLDER / "unit.cpp").read_text()


@wp.func_native(f"{{\n{UNIT}\n{(_FOLDER / 'sweep_free.cpp').read_text()}\n}}")
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


@wp.func
def limit_free(
    rows: Rows, row: int, free_bias: wp.array2d[float], free_impulses: wp.array2d[float], v: wp.array[float]
):
    """Take from a free body the speed that is above its limit; return whether there is some."""
    speed = 0.0
    dof_a = rows.free_dof_a[0, row]
    dof_b = rows.free_dof_b[0, row]
    for k in range(6):
        if dof_a >= 0:
            speed += rows.free_jacobian_a[0, row, k] * v[dof_a + k]
        if dof_b >= 0:
            speed += rows.free_jacobian_b[0, row, k] * v[dof_b + k]
    residual = speed + free_bias[0, row]
    impulse = 0.0
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
