"""The stage that Isaac Sim's wrappers and helpers work on: that of a `use_stage` block, else the current one.

Replicator, `omni.usd` and the engines stay with the current stage inside such a block, as in Isaac Sim.
"""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Generator
from pathlib import Path

from pxr import Usd, UsdUtils

from usdsdg.session import stage_context
from usdsdg.stage import flatten


class _Used(threading.local):
    """Each thread has blocks of its own."""

    stage: Usd.Stage | None = None


_used = _Used()


@contextlib.contextmanager
def use_stage(stage: Usd.Stage) -> Generator[None, None, None]:
    """Let wrappers of prims, and helpers that name prims by path, work on another stage inside the `with` block.

    Raises:
        AssertionError: `stage` is no stage.
    """
    assert isinstance(stage, Usd.Stage), f"use_stage takes a Usd.Stage, not {type(stage).__name__}"
    before, _used.stage = _used.stage, stage
    try:
        yield
    finally:
        _used.stage = before


def is_stage_set() -> bool:
    """Return whether this is inside a `use_stage` block."""
    return _used.stage is not None


def current_stage() -> Usd.Stage:
    return _used.stage if _used.stage is not None else stage_context.current_stage()


def stage_id(stage: Usd.Stage) -> int:
    """Return the id of a stage in USD's stage cache, to which it is added if it is not in it."""
    cache = UsdUtils.StageCache.Get()
    return (cache.GetId(stage) if cache.Contains(stage) else cache.Insert(stage)).ToLongInt()


def save(path: str | os.PathLike[str]) -> Path:
    """Write the stage as one file; return its absolute path.

    Raises:
        as `stage_context.save_stage`.
    """
    if _used.stage is None:
        return stage_context.save_stage(path)
    file = Path(path).absolute()
    flatten.check_writable(file)
    return flatten.write_layer(flatten.flattened(_used.stage, file.parent), file)
