"""Which objects are visible enough to be labeled."""

from __future__ import annotations

from typing import Any

import numpy as np

from usdsdg.errors import WriterError

# `occlusionRatio` is a float32, of which three fifths are a little more than 0.6.
ROUNDING = 1e-6


def is_hidden_more(box: Any, limit: float) -> bool:
    """Return whether more than a fraction of an object is hidden, by its row of a box annotator; False if unknown."""
    return float(box["occlusionRatio"]) > limit + ROUNDING


def check_limits(writer: str, min_visibility: float, min_pixels: int) -> None:
    """Check the limits that a writer was given.

    Raises:
        WriterError: `min_visibility` is no fraction, or `min_pixels` less than 1.
    """
    if not 0.0 <= min_visibility <= 1.0:
        raise WriterError(f"{writer}: min_visibility is {min_visibility}; expected a fraction, 0 to 1.")
    if not min_pixels >= 1:
        raise WriterError(f"{writer}: min_pixels is {min_pixels}; expected 1 or more.")


class VisibleEnough:
    """The limits `min_visibility` and `min_pixels` of a writer."""

    def __init__(self, writer: str, min_visibility: float, min_pixels: int) -> None:
        """
        min_visibility: least visible fraction of what an object would cover alone. min_pixels: least visible pixels.

        Raises:
            WriterError: as `check_limits`.
        """
        check_limits(writer, min_visibility, min_pixels)
        self._visibility, self._pixels = min_visibility, min_pixels

    def holds(self, box: Any, pixels: int) -> bool:
        """Return whether an object is visible enough, by its row of a box annotator and its visible pixels."""
        hidden = float(box["occlusionRatio"])
        return pixels >= self._pixels and not (np.isfinite(hidden) and 1.0 - hidden < self._visibility - ROUNDING)
