"""Oriented boxes as Ultralytics' trainers take them."""

from __future__ import annotations

import numpy as np

# Fraction of the picture by which a box may be larger, as rounding of its corners makes it.
_ROUNDING = 1e-5


def fitted(corners: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return the corners (4, 2) [pixels] of an oriented box, moved into a picture that is not as wide or high as they.

    Ultralytics takes a picture for damaged, and leaves it out of the training, where the corners of a box are further
    apart than the picture is wide or high, as those around a bar from one corner of the picture to another. It moves
    corners into pictures itself when it augments them. size: width and height of the picture.
    """
    if (np.ptp(corners, axis=0) <= np.asarray(size) * (1 + _ROUNDING)).all():
        return corners
    return corners.clip(0, size)
