"""Masks: from run lengths, as pictures, and their extents."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def from_runs(lengths: Sequence[int] | np.ndarray, size: Sequence[int]) -> np.ndarray:
    """Return the mask (H, W) bool of run lengths down the columns, first of pixels outside, then inside, ...

    size: height and width.
    """
    inside = np.arange(len(lengths)) % 2 == 1
    return np.repeat(inside, lengths).reshape(size[1], size[0]).T


def extent(mask: np.ndarray) -> tuple[int, int, int, int] | None:
    """Return first column, first row, last column and last row of a mask (H, W); None if it is empty."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return (int(columns[0]), int(rows[0]), int(columns[-1]), int(rows[-1])) if len(rows) else None


def picture(mask: np.ndarray) -> np.ndarray:
    """Return a mask as a gray picture, uint8 (H, W): 255 inside, 0 outside."""
    return mask.astype(np.uint8) * 255
