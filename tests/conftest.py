"""The fixture of all tests that need a stage."""

import os

import pytest

from usdsdg.graph.sampling import set_global_seed
from usdsdg.session import session
from usdsdg.session.stage_context import new_stage

# No test asks a server for an asset, but those that have one of their own.
os.environ.setdefault("USDSDG_FETCH_ASSETS", "0")


@pytest.fixture(autouse=True)
def _classes_of_its_own():
    """No test has ids of the classes of the tests before."""
    for tables in session.current()._made("class_tables"):
        tables.reset()


@pytest.fixture
def stage():
    """The empty stage of a new session: Z up, meters, /World; the global seed is 1. Nothing of it outlives the test."""
    session.restart()
    set_global_seed(1)
    yield new_stage()
    session.restart()
