"""A table of the values of gprims, in which the pixels of pictures are looked up."""

from __future__ import annotations

from typing import Any

import numpy as np

from usdsdg.annotators.pixels.launch import Pixels


class LookUpTable:
    """The value of each gprim, and a last one for pixels that show none; copies on devices are kept.

    Args:
        values: (G + 1, *channels); entries have 4 bytes or a multiple. They must not be written into afterward.
        is_of_all: whether it is the same for all pictures of a capture, so that these may be looked up together.
    """

    def __init__(self, values: np.ndarray, *, is_of_all: bool = False) -> None:
        self.values, self.is_of_all = np.ascontiguousarray(values), is_of_all
        self._copies: dict[str, Pixels] = {}

    @property
    def words(self) -> int:
        """How many words of 4 bytes an entry has."""
        return self.values.nbytes // len(self.values) // 4

    def on(self, image: Pixels) -> Pixels:
        """Return the words of all entries, uint32, where an image is."""
        words = self.values.reshape(-1).view(np.uint32)
        if isinstance(image, np.ndarray):
            return words
        import warp as wp

        device = str(image.device)
        if device not in self._copies:
            number: Any = wp.uint32  # Warp declares `dtype: type[float]`
            self._copies[device] = wp.array(words, dtype=number, device=device)
        return self._copies[device]
