"""Outlines: which pixels groups of gprims would cover if each were alone, and which of those pixels show them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

WORD = 64  # pixels in a word
# Pixel k of a word is column WORD * word + k and bit k. `covered` is what the group would cover alone, never 0;
# `visible`, a part of it, is where nothing else stands before it.
STRIP = np.dtype([("group", "<i4"), ("row", "<i4"), ("word", "<i4"), ("covered", "<u8"), ("visible", "<u8")])


class Outlines:
    """Modal and amodal masks of some groups of gprims in one picture, in words of 64 pixels.

    Args:
        shape: height, width [pixels].
        count: groups; several may share gprims.
        strips: fetches them, STRIP, ordered by group, row and word, each at most once.
        coverage: (count, 5) int64: amodal pixels, x_min, y_min, x_max, y_max (inclusive); -1 bounds for no pixels.
        visible: (count,) int64: modal pixels, in which the group is seen.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        count: int,
        strips: Callable[[], np.ndarray],
        *,
        coverage: np.ndarray,
        visible: np.ndarray,
    ) -> None:
        self.shape, self.count, self.coverage, self.visible = shape, count, coverage, visible
        self._strips = strips

    @classmethod
    def nothing(cls, shape: tuple[int, int], count: int = 0) -> Outlines:
        """Of groups that are out of view."""
        coverage = np.full((count, 5), -1, np.int64)
        coverage[:, 0] = 0
        return cls(shape, count, lambda: np.zeros(0, STRIP), coverage=coverage, visible=np.zeros(count, np.int64))

    @cached_property
    def strips(self) -> np.ndarray:
        """STRIP, ordered by group, row and word."""
        return self._strips()

    def mask(self, group: int) -> np.ndarray:
        """(H, W) bool: pixels that the group would cover alone."""
        first, last = np.searchsorted(self.strips["group"], [group, group + 1])
        own = self.strips[first:last]
        words = np.zeros((self.shape[0], -(-self.shape[1] // WORD)), "<u8")
        words[own["row"], own["word"]] = own["covered"]
        return _bits(words).reshape(self.shape[0], -1)[:, : self.shape[1]]

    def hidden(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """All hidden pixels, a group at a time: group, row and column of each, (N,) int64."""
        behind = self.strips["covered"] & ~self.strips["visible"]
        some = np.flatnonzero(behind)
        strip, bit = np.nonzero(_bits(np.ascontiguousarray(behind[some])[:, None]))
        own = self.strips[some[strip]]
        return own["group"].astype(np.int64), own["row"].astype(np.int64), own["word"].astype(np.int64) * WORD + bit


def _bits(words: np.ndarray) -> np.ndarray:
    """(R, n) words → (R, n * WORD) bool."""
    return np.unpackbits(words.view(np.uint8), axis=1, bitorder="little").astype(bool)
