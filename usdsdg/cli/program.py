"""Entry point of the `usdsdg` program; until a command begins, Ctrl-C ends it with one line."""

from __future__ import annotations

import os
import signal

INTERRUPTED = 130


def main() -> None:
    """Run the `usdsdg` program."""
    # Extension modules drop a KeyboardInterrupt that is raised while they are imported, or turn it into another error.
    # No work has begun then, so the process can end at once.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)
    from usdsdg.cli.commands import main as run_command

    run_command()


def let_commands_be_interrupted() -> None:
    """Make Ctrl-C raise KeyboardInterrupt from here on, as in any Python program."""
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _end(*_: object) -> None:
    os.write(2, b"interrupted\n")
    os._exit(INTERRUPTED)
