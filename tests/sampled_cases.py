"""Cases of slow tests: CI runs the first of them, `python -m tests.soak cases` all."""

import os
from collections.abc import Iterable
from typing import TypeVar

SETTING = "USDSDG_ALL_CASES"

_Case = TypeVar("_Case")


def sampled(cases: Iterable[_Case]) -> list[_Case]:
    """Return the first of the cases, or all where the variable `USDSDG_ALL_CASES` is set."""
    found = list(cases)
    return found if os.environ.get(SETTING) else found[:1]
