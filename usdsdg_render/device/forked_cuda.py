"""CUDA in forked processes, where it does not work."""

from __future__ import annotations

import os

import warp as wp

from usdsdg.errors import RenderError
from usdsdg.operating_system import around_fork

_opened_by: int | None = None  # id of the process that first asked for a CUDA device


def check_not_forked(device: str) -> None:
    """Note that this process uses `device`.

    Raises:
        RenderError: it is a CUDA device, which a process that this one was forked from has used before.
    """
    global _opened_by
    if device == "cpu":
        return
    if _opened_by is None:
        _opened_by = os.getpid()
        around_fork(in_child=_silence_warp)
    if _opened_by != os.getpid():
        raise RenderError(
            f"cannot render on {device!r}: this process was forked from one that uses CUDA, which does not survive it. "
            'Start processes with the method "spawn" (DataLoader: multiprocessing_context="spawn"), or use the '
            'device "cpu".'
        )


def _silence_warp() -> None:
    """Let Warp print nothing of its failures, such as one for each array of the other process that is collected here.

    Whoever wants to render on CUDA is told by `check_not_forked`.
    """
    runtime = wp._src.context.runtime
    if runtime is not None:
        runtime.core.wp_set_error_output_enabled(0)
