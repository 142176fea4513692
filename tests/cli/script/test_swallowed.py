"""Errors that a script catches: noted where they were raised by usdsdg, and not where usdsdg itself caught them."""

import contextlib

import pytest

from usdsdg import errors
from usdsdg.errors import AssetError, PhysicsError, WriterError


@pytest.fixture
def watched(monkeypatch):
    # Tests are no installed package, so this file is a script to the watcher.
    errors.watch_swallowed()
    yield
    errors.take_swallowed()


def raise_(error: Exception) -> None:
    raise error


@pytest.mark.parametrize("kind", [AssetError, PhysicsError, WriterError, errors.OutputNotWritable])
def test_an_error_that_a_script_catches_is_noted_with_its_line(watched, kind):
    with contextlib.suppress(OSError, kind):
        raise_(kind("the disk is full"))
    (line,) = errors.take_swallowed()
    assert line.startswith("test_swallowed.py:")
    assert line.endswith(f"{kind.__name__}: the disk is full")


def test_an_error_that_is_kept_is_noted_too(watched):
    kept = []
    try:
        raise_(WriterError("kept"))
    except WriterError as error:
        kept.append(error)
    assert len(errors.take_swallowed()) == 1


def test_an_error_that_is_caught_below_the_script_is_not_noted(watched, tmp_path, monkeypatch):
    from usdsdg.stage import assets

    assets.set_on_missing(assets.OnMissing.SKIP)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    try:
        assert assets.resolve("omniverse://host/gone.usd").endswith("gone_empty.usda")
    finally:
        assets.set_on_missing(assets.OnMissing.RAISE)
    assert errors.take_swallowed() == []


def test_errors_of_other_kinds_are_the_scripts_own_affair(watched):
    with contextlib.suppress(errors.ConfigError):
        raise_(errors.ConfigError("odd"))
    assert errors.take_swallowed() == []


def test_nothing_is_noted_unless_it_is_watched():
    errors.take_swallowed()
    with contextlib.suppress(WriterError):
        raise_(WriterError("unseen"))
    assert errors.take_swallowed() == []
