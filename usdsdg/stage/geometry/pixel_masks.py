"""Bit-packed modal and amodal masks: the pixels that show groups of gprims, and those that each would cover alone."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

WORD_PIXELS = 64  # pixels of a mask word, one bit each
# Bit k of a word is the pixel in column WORD_PIXELS * word + k. `covered` (amodal, never 0): pixels that the group
# would cover alone. `visible` (modal): those of them in which nothing occludes it.
MASK_WORD = np.dtype([("group", "<i4"), ("row", "<i4"), ("word", "<i4"), ("covered", "<u8"), ("visible", "<u8")])


class PixelMasks:
    """Modal and amodal masks of some groups of gprims in one image, in words of 64 pixels.

    Args:
        shape: height, width [pixels].
        count: groups; several may share gprims.
        words: fetches the words, rows of MASK_WORD, ordered by group, row and word, each at most once.
        coverage: (count, 5) int64: amodal pixels, x_min, y_min, x_max, y_max (inclusive); -1 bounds for no pixels.
        visible: (count,) int64: modal pixels, in which the group is seen.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        count: int,
        words: Callable[[], np.ndarray],
        *,
        coverage: np.ndarray,
        visible: np.ndarray,
    ) -> None:
        self.shape, self.count, self.coverage, self.visible = shape, count, coverage, visible
        self._words = words

    @classmethod
    def nothing(cls, shape: tuple[int, int], count: int = 0) -> PixelMasks:
        """Masks of groups that are out of view."""
        coverage = np.full((count, 5), -1, np.int64)
        coverage[:, 0] = 0
        return cls(shape, count, lambda: np.zeros(0, MASK_WORD), coverage=coverage, visible=np.zeros(count, np.int64))

    @cached_property
    def words(self) -> np.ndarray:
        """Rows of MASK_WORD, ordered by group, row and word."""
        return self._words()

    def mask(self, group: int) -> np.ndarray:
        """Amodal mask, (H, W) bool: pixels that the group would cover alone."""
        first, last = np.searchsorted(self.words["group"], [group, group + 1])
        own = self.words[first:last]
        bits = np.zeros((self.shape[0], -(-self.shape[1] // WORD_PIXELS)), "<u8")
        bits[own["row"], own["word"]] = own["covered"]
        return _bits(bits).reshape(self.shape[0], -1)[:, : self.shape[1]]

    def crop(self, group: int) -> np.ndarray:
        """Amodal mask within its bounds in `coverage`, bool; of no pixels if the group has none."""
        pixels, left, top, right, bottom = self.coverage[group].tolist()
        if pixels == 0:
            return np.zeros((0, 0), bool)
        first, last = np.searchsorted(self.words["group"], [group, group + 1])
        own = self.words[first:last]
        start = left // WORD_PIXELS
        bits = np.zeros((bottom - top + 1, right // WORD_PIXELS - start + 1), "<u8")
        bits[own["row"] - top, own["word"] - start] = own["covered"]
        left -= start * WORD_PIXELS
        return _bits(bits)[:, left : left + right - self.coverage[group, 1] + 1]

    def hidden(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """All occluded pixels, ordered by group: group, row and column of each, (N,) int64."""
        behind = self.words["covered"] & ~self.words["visible"]
        some = np.flatnonzero(behind)
        word, bit = np.nonzero(_bits(np.ascontiguousarray(behind[some])[:, None]))
        own = self.words[some[word]]
        return (
            own["group"].astype(np.int64),
            own["row"].astype(np.int64),
            own["word"].astype(np.int64) * WORD_PIXELS + bit,
        )


def _bits(words: np.ndarray) -> np.ndarray:
    """(R, n) words → (R, n * WORD_PIXELS) bool."""
    return np.unpackbits(words.view(np.uint8), axis=1, bitorder="little").astype(bool)
