"""Cases of slow tests: CI runs the first of them, `python -m tests.soak cases` all."""

import os
from collections.abc import Iterable
from typing import TypeVar

import pytest

SETTING = "USDSDG_ALL_CASES"

# A test that CI leaves out, since others run the same code in less time.
in_soak = pytest.mark.skipif(SETTING not in os.environ, reason="run by `python -m tests.soak cases`")

_Case = TypeVar("_Case")


def sampled(cases: Iterable[_Case]) -> list[_Case]:
    """Return the first of the cases, or all where the variable `USDSDG_ALL_CASES` is set."""
    found = list(cases)
    return found if os.environ.get(SETTING) else found[:1]
