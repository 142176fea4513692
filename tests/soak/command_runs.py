"""Runs of `usdsdg` that can be ended at any moment."""

from __future__ import annotations

import contextlib
import os
import signal
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from tests import forked
from tests.soak.processor_time import processor_seconds

ROOT = Path(__file__).parents[2]
POLL_SECONDS = 0.005


class CommandRun:
    """A run of `usdsdg` with its output."""

    def __init__(self, arguments: Sequence[str]) -> None:
        self._said = tempfile.TemporaryFile("w+")  # noqa: SIM115 - closed with the object
        self._fork = forked.Fork(["-m", "usdsdg", *arguments], cwd=ROOT, output=self._said)
        self.pid = self._fork.pid

    @property
    def returncode(self) -> int | None:
        """The exit code, -N where signal N has ended it, and None before its end."""
        return self._fork.returncode

    @property
    def processor_seconds(self) -> float:
        """What it has taken of processors, when it has ended."""
        return self._fork.processor_seconds

    def has_ended(self) -> bool:
        """Return whether it has ended."""
        return self._fork.poll() is not None

    def wait_for_processor_seconds(self, seconds: float) -> None:
        """Wait until it has run for so long on processors, or has ended."""
        while not self.has_ended() and processor_seconds(self.pid) < seconds:
            time.sleep(POLL_SECONDS)

    def send(self, number: int) -> None:
        """Send a signal, unless it has ended."""
        if not self.has_ended():
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.pid, number)

    def wait(self) -> int:
        """Wait until it has ended; return its exit code, or -N where signal N has ended it."""
        return self._fork.wait()

    def kill(self) -> None:
        """End it at once."""
        self.send(signal.SIGKILL)
        self.wait()

    @property
    def said(self) -> str:
        """The end of what it has printed."""
        self._said.seek(0)
        return self._said.read()[-2000:]
