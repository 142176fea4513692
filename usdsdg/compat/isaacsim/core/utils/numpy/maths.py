"""`isaacsim.core.utils.numpy.maths`: functions of arrays. `device` is ignored: there is only the CPU."""

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["cos", "inverse", "matmul", "sin", "transpose_2d"]


def matmul(matrix_a: ArrayLike, matrix_b: ArrayLike) -> np.ndarray:
    """Return the product of two matrices."""
    return np.matmul(matrix_a, matrix_b)


def sin(data: ArrayLike) -> np.ndarray:
    return np.sin(data)


def cos(data: ArrayLike) -> np.ndarray:
    return np.cos(data)


def inverse(mat: np.ndarray) -> np.ndarray:
    """Return the inverse of matrices (..., N, N)."""
    return np.linalg.inv(mat)


def transpose_2d(mat: ArrayLike) -> np.ndarray:
    """Return a matrix with rows and columns exchanged."""
    return np.transpose(mat)
