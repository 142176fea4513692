"""`isaacsim.replicator.writers.scripts.utils`: what writers of scripts take from the module of the pose writers."""

from __future__ import annotations

from typing import Any

import numpy as np


def calculate_truncation_ratio_simple(corners: Any, img_width: float, img_height: float) -> float:
    """Return the fraction of the bounding rectangle of projected points that is outside the image.

    Args:
        corners: (N, 2) pixels.

    Returns:
        0 if the rectangle is inside the image, 1 if it is outside or has no area.
    """
    pixels, size = np.asarray(corners, np.float64), np.array([img_width, img_height], np.float64)
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    whole = float(np.prod(high - low))
    inside = float(np.prod(np.clip(high, 0, size) - np.clip(low, 0, size)))
    return 1 - inside / whole if whole > 0 else 1.0
