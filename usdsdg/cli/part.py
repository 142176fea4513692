"""Making of one part of a dataset in a process that makes several, so that kernels and assets stay loaded."""

from __future__ import annotations

import contextlib
import gc
import io
from collections.abc import Sequence

import click


def run_here(command: click.Command, arguments: Sequence[str]) -> tuple[int, str]:
    """Run a command in this process, as a process of its own would; return its exit code and what it printed.

    arguments: those after the name of the command. Call it on the main thread.
    """
    from usdsdg.session import session

    session.restart()
    printed = io.StringIO()
    try:
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            ended = command.main(list(arguments), standalone_mode=False)
    finally:
        session.current().run.release()
        session.current().io_queue.forget_at_exit()
        session.restart()
        _free()
    return (ended if isinstance(ended, int) else 0), printed.getvalue()


def _free() -> None:
    """Free what the part has left.

    The import of Newton has put what was there then out of the garbage collector's sight.
    """
    gc.unfreeze()
    gc.collect()
    gc.freeze()
