"""Parts of line segments inside a rectangle."""

import numpy as np


def clip_to_rectangle(segment: np.ndarray, left: float, top: float, right: float, bottom: float) -> np.ndarray | None:
    """Return the part (2, 2) of a segment inside a rectangle, or None (Liang-Barsky clipping)."""
    start, along = segment[0].astype(np.float64), (segment[1] - segment[0]).astype(np.float64)
    enter, leave = 0.0, 1.0
    for axis, low, high in ((0, left, right), (1, top, bottom)):
        if abs(along[axis]) < 1e-9:
            if not low <= start[axis] <= high:
                return None
            continue
        first, second = sorted(((low - start[axis]) / along[axis], (high - start[axis]) / along[axis]))
        enter, leave = max(enter, first), min(leave, second)
    return np.stack([start + enter * along, start + leave * along]) if enter <= leave else None
