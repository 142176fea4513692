"""The fixture of all tests that need a stage."""

import gc
import os
import sys

import pytest
from hypothesis import HealthCheck, settings

from usdsdg import errors
from usdsdg.graph.sampling import set_global_seed
from usdsdg.session import session
from usdsdg.session.stage_context import new_stage
from usdsdg.stage import assets

# No test asks a server for an asset, but those that have one of their own.
os.environ.setdefault("USDSDG_FETCH_ASSETS", "0")

# Tests that give assets another cache leave kernels where they are: in an empty folder all would be compiled anew.
if sys.platform == "linux":
    _caches = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    os.environ.setdefault("WARP_CACHE_PATH", os.path.join(_caches, "warp"))

# How long an example takes depends on what else the machine does.
settings.register_profile("usdsdg", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("usdsdg")


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Keep modules and tests, a million objects that stay, out of the garbage collector's sight.

    A full collection would take half a second among them, and tests cause hundreds. Garbage of collecting, which takes
    no memory to speak of, stays with them.
    """
    gc.disable()
    result = yield
    gc.freeze()
    gc.enable()
    return result


# What takes longest comes first, so that no process of several is left alone with it at the end.
_FIRST = ("tests/site/", "tests/stream/", "tests/security/")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put tests of the rooms that take longest first; all others keep their order."""
    items.sort(key=lambda item: not item.nodeid.startswith(_FIRST))


@pytest.fixture(autouse=True)
def _classes_of_its_own():
    """No test has ids of the classes of the tests before."""
    for tables in session.current()._made("class_tables"):
        tables.reset()


@pytest.fixture(autouse=True)
def _warnings_of_its_own():
    """Warnings that tests before have caused are given again."""
    errors.forget_warnings()


@pytest.fixture(autouse=True)
def _no_conditions_of_a_command():
    """What a command sets for its process, which is a test's own, does not outlive the test."""
    yield
    assets.set_on_missing(assets.OnMissing.RAISE)
    assets.set_maps(())
    errors.set_lenient(False)
    errors.take_swallowed()


@pytest.fixture
def stage():
    """The empty stage of a new session: Z up, meters, /World; the global seed is 1. Nothing of it outlives the test."""
    session.restart()
    set_global_seed(1)
    yield new_stage()
    session.restart()
