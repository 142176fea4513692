"""`usdsdg view` in a process of its own, as a user starts it."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Iterator
from pathlib import Path

from tests.signaled import started

ROOT = Path(__file__).resolve().parents[2]
SECONDS = 120.0


@contextlib.contextmanager
def viewing(*arguments: object, folder: Path) -> Iterator[str]:
    """Start the command in a folder, yield the address that it prints, and end it as Ctrl-C does."""
    command = ["-m", "usdsdg", "view", "--quiet", "--device", "cpu", *map(str, arguments)]
    with (
        (folder / "errors.txt").open("w") as errors,
        started(command, cwd=folder, stderr=errors, env=os.environ | {"PYTHONPATH": str(ROOT)}) as process,
    ):
        # A command that says nothing is ended, so that reading its address ends too.
        timer = threading.Timer(SECONDS, process.kill)
        timer.start()
        try:
            assert process.stdout is not None
            address = process.stdout.readline().strip()
            timer.cancel()
            assert address.startswith("http://127.0.0.1:"), (folder / "errors.txt").read_text()
            yield address
            process.send_signal(signal.SIGINT)
            assert process.wait(SECONDS) == 130, (folder / "errors.txt").read_text()
        finally:
            timer.cancel()
