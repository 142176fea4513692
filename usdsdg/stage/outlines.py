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
        strips: STRIP, ordered by group, row and word, each at most once; or what fetches them.
        coverage, visible: as the properties of these names, where they are known; else counted.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        count: int,
        strips: np.ndarray | Callable[[], np.ndarray],
        *,
        coverage: np.ndarray | None = None,
        visible: np.ndarray | None = None,
    ) -> None:
        self.shape, self.count = shape, count
        self._strips, self._coverage, self._visible = strips, coverage, visible

    @classmethod
    def nothing(cls, shape: tuple[int, int], count: int = 0) -> Outlines:
        """Of groups that are out of view."""
        return cls(shape, count, np.zeros(0, STRIP))

    @cached_property
    def strips(self) -> np.ndarray:
        """STRIP, ordered by group, row and word."""
        return self._strips() if callable(self._strips) else self._strips

    @cached_property
    def coverage(self) -> np.ndarray:
        """(count, 5) int64: amodal pixels, x_min, y_min, x_max, y_max (inclusive); -1 bounds for no pixels."""
        return self._counted() if self._coverage is None else self._coverage

    @cached_property
    def visible(self) -> np.ndarray:
        """(count,) int64: modal pixels, in which the group is seen."""
        return self._sums(self.strips["visible"]) if self._visible is None else self._visible

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

    def _counted(self) -> np.ndarray:
        result = np.full((self.count, 5), -1, np.int64)
        result[:, 0] = self._sums(self.strips["covered"])
        groups, first = np.unique(self.strips["group"], return_index=True)
        if len(groups) == 0:
            return result
        lowest, highest = _outermost_bits(self.strips["covered"])
        columns = self.strips["word"].astype(np.int64) * WORD
        result[groups, 1] = np.minimum.reduceat(columns + lowest, first)
        result[groups, 2] = np.minimum.reduceat(self.strips["row"], first)
        result[groups, 3] = np.maximum.reduceat(columns + highest, first)
        result[groups, 4] = np.maximum.reduceat(self.strips["row"], first)
        return result

    def _sums(self, words: np.ndarray) -> np.ndarray:
        """(count,) int64: bits set in the words of each group."""
        # A double counts pixels exactly up to 2^53.
        sums = np.bincount(self.strips["group"], weights=_bit_counts(words), minlength=self.count)
        return sums.astype(np.int64)


def _bits(words: np.ndarray) -> np.ndarray:
    """(R, n) words → (R, n * WORD) bool."""
    return np.unpackbits(words.view(np.uint8), axis=1, bitorder="little").astype(bool)


_COUNT_OF_BYTE = np.unpackbits(np.arange(256, dtype=np.uint8)[:, None], axis=1).sum(1, dtype=np.uint8)


def _bit_counts(words: np.ndarray) -> np.ndarray:
    return _COUNT_OF_BYTE[np.ascontiguousarray(words).view(np.uint8).reshape(-1, 8)].sum(1, dtype=np.int64)


def _outermost_bits(words: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Index of the lowest and of the highest bit of words that are not 0."""
    lowest = words & (~words + np.uint64(1))
    upper = words >> np.uint64(32)
    # Halves are exact as doubles, and the exponent of a double is the place of its highest bit.
    half = np.where(upper > 0, upper, words).astype(np.float64)
    highest = np.frexp(half)[1] - 1 + np.where(upper > 0, 32, 0)
    return np.frexp(lowest.astype(np.float64))[1] - 1, highest
