"""Cases of slow tests: CI runs the first of them, `python -m tests.soak cases` all."""

import os
from collections.abc import Iterable
from typing import TypeVar

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
