"""Warp kernel of the velocities that the impulse of each row of joints causes."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018, RUF046

import warp as wp

wp.set_module_options({"enable_backward": False})


@wp.kernel(enable_backward=False)
def respond_to_rows(
    factor: wp.array3d[float],
    jacobian: wp.array3d[float],
    articulation: wp.array[int],
    world_dof: wp.array[int],
    count: wp.array[int],
    # out
    response: wp.array3d[float],
    world_jacobian: wp.array3d[float],
    world_response: wp.array3d[float],
):
    """Compute M⁻¹ Jᵀ of the rows of one articulation, and copy both to those of the world.

    `factor` (A, S, S) is the lower Cholesky factor of M, `jacobian` (A, M, S) has the rows. Of a hundred bodies beside
    an arm almost all have zeros in each of its rows.
    """
    index = wp.tid()
    size = factor.shape[1]
    dof = world_dof[articulation[index]]
    for row in range(wp.min(count[0], jacobian.shape[1])):
        nonzero = int(0)
        for i in range(size):
            if jacobian[index, row, i] != 0.0:
                nonzero = 1
        if nonzero != 0:
            for i in range(size):
                value = float(jacobian[index, row, i])
                for k in range(i):
                    value -= factor[index, i, k] * response[index, row, k]
                response[index, row, i] = quotient(value, factor[index, i, i])
            for reverse in range(size):
                i = size - 1 - reverse
                value = float(response[index, row, i])
                for k in range(i + 1, size):
                    value -= factor[index, k, i] * response[index, row, k]
                response[index, row, i] = quotient(value, factor[index, i, i])
            for i in range(size):
                world_jacobian[0, row, dof + i] = jacobian[index, row, i]
                world_response[0, row, dof + i] = response[index, row, i]
        else:
            for i in range(size):
                response[index, row, i] = 0.0
                world_jacobian[0, row, dof + i] = 0.0
                world_response[0, row, dof + i] = 0.0


@wp.func
def quotient(value: float, divisor: float):
    """Return value / divisor, and 0 where that is 0."""
    result = float(0.0)
    if divisor != 0.0:
        result = value / divisor
    return result
