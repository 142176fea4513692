"""CUDA in forked processes, where it does not work."""

from __future__ import annotations

import os

from usdsdg.errors import RenderError

_opened_by: int | None = None  # id of the process that first asked for a CUDA device


def check_not_forked(device: str) -> None:
    """Note that this process uses `device`.

    Raises:
        RenderError: it is a CUDA device, which a process that this one was forked from has used before.
    """
    global _opened_by
    if device == "cpu":
        return
    _opened_by = _opened_by or os.getpid()
    if _opened_by != os.getpid():
        raise RenderError(
            f"cannot render on {device!r}: this process was forked from one that uses CUDA, which does not survive it. "
            'Start processes with the method "spawn" (DataLoader: multiprocessing_context="spawn"), or use the '
            'device "cpu".'
        )
