"""Colors in the layout of Isaac Sim 4: one uint32 per pixel, whose bytes are R, G, B, A."""

from collections.abc import Mapping
from typing import Any

import numpy as np


def packed(image: np.ndarray) -> np.ndarray:
    """Return uint8 (H, W, 4) as uint32 (H, W), of the same memory where that is contiguous."""
    return np.ascontiguousarray(image).view(np.uint32)[..., 0]


def unpacked(segmentation: Mapping[str, Any]) -> np.ndarray:
    """Return the array of a segmentation ("data", "idToLabels"): packed colors as uint8 (H, W, 4), all others as is."""
    data = segmentation["data"]
    # The tables of colors have colors as keys: tuples, or their text.
    colorized = str(next(iter(segmentation["idToLabels"]), "")).startswith("(")
    if data.dtype != np.uint32 or not colorized:
        return data
    return np.ascontiguousarray(data).view(np.uint8).reshape(*data.shape, 4)
