"""Ctrl-C before a command has begun: end the process with one line."""

import os
import signal
from contextlib import suppress
from typing import Any

INTERRUPTED = 130


def end_at_once_on_interrupt() -> None:
    """Make Ctrl-C end the process, unless the caller has set it to something else than Python's default."""
    # Extension modules drop a KeyboardInterrupt that is raised while they are imported, or turn it into another error.
    # No work has begun then, so the process can end at once.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


def let_commands_be_interrupted() -> None:
    """Make Ctrl-C raise KeyboardInterrupt from here on, as in any Python program."""
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def forget_interrupts() -> None:
    """Let Python end with the exit code that it was given, whatever was interrupted before.

    CPython marks a KeyboardInterrupt that leaves `exec` or `eval` of source code, which dataclasses use, as unhandled,
    even where a caller handles it, and `python -m` then ends by SIGINT. Executing other source code clears the mark.
    """
    exec("")


def _end(*_: Any) -> None:
    with suppress(OSError):  # stderr may be a pipe without a reader
        os.write(2, b"interrupted\n")
    os._exit(INTERRUPTED)
