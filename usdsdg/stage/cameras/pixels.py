"""Pixel coordinates: column to the right, row downwards, and (0, 0) at the top left corner of the image."""

import numpy as np

# Pixel (column, row) covers [column, column + 1) x [row, row + 1).
PIXEL_CENTER = 0.5


def pixel_centers(columns: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the coordinates (…, 2) of pixel centers."""
    return np.stack([columns, rows], axis=-1) + PIXEL_CENTER
