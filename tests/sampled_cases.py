"""Cases of slow tests: CI runs the first of them, `python -m tests.soak cases` all."""

import itertools
import os
from collections.abc import Iterable
from typing import Any, TypeVar

import pytest

SETTING = "USDSDG_ALL_CASES"

# A test that CI leaves out, since others run the same code in less time.
in_soak = pytest.mark.skipif(SETTING not in os.environ, reason="run by `python -m tests.soak cases`")

_Case = TypeVar("_Case")


def sampled(cases: Iterable[_Case], count: int = 1) -> list[_Case]:
    """Return `count` of the cases, evenly spread from the first on; all where `USDSDG_ALL_CASES` is set."""
    found = list(cases)
    if SETTING in os.environ or len(found) <= count:
        return found
    return [found[number * len(found) // count] for number in range(count)]


def crossed(*axes: Iterable[Any]) -> list[tuple[Any, ...]]:
    """Return as many cases as the longest axis has values; all combinations where `USDSDG_ALL_CASES` is set.

    Each value of each axis is in one of them at least, beside other values each time as far as that goes.
    """
    values = [list(axis) for axis in axes]
    if SETTING in os.environ:
        return list(itertools.product(*values))
    places = list(
        itertools.product(*([(axis, index) for index in range(len(each))] for axis, each in enumerate(values)))
    )
    seen: set[tuple[tuple[int, int], ...]] = set()
    found = []
    for _ in range(max(map(len, values))):
        best = max(places, key=lambda place: [len({*itertools.combinations(place, n)} - seen) for n in (1, 2)])
        seen.update(itertools.combinations(best, 1), itertools.combinations(best, 2))
        found.append(tuple(values[axis][i] for axis, i in best))
    return found
