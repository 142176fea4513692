"""Pixels inside of polygons."""

from __future__ import annotations

import numpy as np


def filled(corners: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return the pixels (H, W) whose center is inside a polygon (N, 2) of column and row, by the even-odd rule."""
    ends = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    # From top to bottom, so that a line there and back crosses a row at the same place.
    ends = np.where((ends[:, 0, 1] > ends[:, 1, 1])[:, None, None], ends[:, ::-1], ends)
    (x0, y0), (x1, y1) = ends[:, 0].T, ends[:, 1].T
    middles = np.arange(shape[1]) + 0.5
    inside = np.zeros(shape, bool)
    for row in range(shape[0]):
        crossing = (y0 <= row + 0.5) != (y1 <= row + 0.5)
        x = x0[crossing] + (row + 0.5 - y0[crossing]) / (y1[crossing] - y0[crossing]) * (x1[crossing] - x0[crossing])
        inside[row] = (x[:, None] > middles).sum(axis=0) % 2 == 1
    return inside
