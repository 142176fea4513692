"""The `usdsdg` program from its first import on: until a command has begun, Ctrl-C ends it with one line."""

from __future__ import annotations

import os
import signal
from typing import Any

INTERRUPTED = 130


def main() -> None:
    """Entry point of the `usdsdg` program."""
    # Modules that are written in C++ lose a KeyboardInterrupt that comes while they are read, or make another error of
    # it. Nothing is begun then, so the process ends at once.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)
    from usdsdg.cli.commands import main as commands

    commands()


def let_commands_be_interrupted() -> None:
    """From here on Ctrl-C is a KeyboardInterrupt, as in any Python program."""
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _end(*_: Any) -> None:
    os.write(2, b"interrupted\n")
    os._exit(INTERRUPTED)
