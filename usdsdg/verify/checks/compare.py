"""Comparison of arrays and of lists of things, with texts for faults."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from usdsdg.datasets.faults import Fault
from usdsdg.datasets.seen import Seen

LISTED = 3


def of_pixels(wrong: np.ndarray) -> str:
    """Return how many pixels are wrong, and where the first is."""
    row, column = np.argwhere(wrong)[0].tolist()
    return f"{int(wrong.sum())} of {wrong.size} pixels, first in column {column} of row {row}"


def shapes_agree(seen: Seen, file: str, found: tuple[int, ...], expected: tuple[int, int]) -> Iterator[Fault]:
    """Yield a fault if an image has another size."""
    if tuple(found[:2]) != tuple(expected):
        yield Fault(file, seen.name, "has another size", _size(expected), _size(found))


def _size(shape: Sequence[int]) -> str:
    return f"{shape[1]} x {shape[0]} pixels"


def differs(found: Any, expected: Any, *, relative: float, absolute: float = 0.0) -> bool:
    """Return whether any number is farther off than allowed; what is not finite must be equal."""
    found, expected = np.asarray(found, np.float64), np.asarray(expected, np.float64)
    if found.shape != expected.shape:
        return True
    # Numbers of one matrix are as accurate as the largest of them.
    scale = np.abs(expected[np.isfinite(expected)]).max(initial=0.0)
    return not np.allclose(found, expected, rtol=0.0, atol=absolute + relative * scale, equal_nan=True)


def beyond(off: Any, limit: Any) -> np.ndarray:
    """Return where a deviation is larger than allowed, or no number."""
    with np.errstate(invalid="ignore"):
        return ~(np.asarray(off) <= limit)


def is_rotation(axes: np.ndarray, *, absolute: float) -> bool:
    """Return whether rows (3, 3) are perpendicular unit vectors, and not mirrored."""
    return not differs(axes @ axes.T, np.eye(3), relative=0.0, absolute=absolute) and np.linalg.det(axes) > 0


def angles_differ(found: float, expected: float, *, absolute: float) -> bool:
    """Return whether two angles [radians] are farther apart than allowed, whole turns aside; or no numbers."""
    off = found - expected
    return not math.isfinite(off) or abs(math.remainder(off, math.tau)) > absolute


def text(values: Any) -> str:
    """Return numbers as short text."""
    return "[" + ", ".join(f"{float(value):.6g}" for value in np.ravel(values)) + "]"


def by_key(keys: Sequence[str]) -> dict[str, list[int]]:
    """Return the indices of each key, in order."""
    found: dict[str, list[int]] = {}
    for index, key in enumerate(keys):
        found.setdefault(key, []).append(index)
    return found


def pairs(
    seen: Seen, file: str, found: Sequence[str], expected: Sequence[str], what: str
) -> tuple[list[tuple[int, int]], list[Fault]]:
    """Match two lists by name; return pairs of indices (found, expected), and faults for those left over."""
    mine, theirs = by_key(found), by_key(expected)
    matched: list[tuple[int, int]] = []
    faults = []
    for key in dict.fromkeys([*theirs, *mine]):
        here, there = mine.get(key, []), theirs.get(key, [])
        matched += zip(here, there)
        if len(here) < len(there):
            faults.append(Fault(file, seen.name, f"{what} {key} is missing", str(len(there)), str(len(here))))
        elif len(here) > len(there):
            faults.append(Fault(file, seen.name, f"{what} {key} is there too often", str(len(there)), str(len(here))))
    return matched, faults
