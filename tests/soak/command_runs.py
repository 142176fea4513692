"""Runs of `usdsdg` that can be ended at any moment: in a new process, or in a copy of this one."""

from __future__ import annotations

import atexit
import functools
import importlib
import os
import pkgutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import IO, NoReturn

import usdsdg_physics
import usdsdg_render
from tests.soak.processor_time import processor_seconds

ROOT = Path(__file__).parents[2]
POLL_SECONDS = 0.005
# What copies of this process have imported: most of the processor time of a small run.
ENGINES = (usdsdg_physics, usdsdg_render)
MODULES = (
    "newton._src.solvers.steel",
    "usdsdg.cli.commands.generate",
    "usdsdg.orchestrator",
    "usdsdg.scenarios.bin_picking.job",
)


class CommandRun:
    """A run of `usdsdg` with its output, in a new process."""

    def __init__(self, arguments: Sequence[str]) -> None:
        self._said = tempfile.TemporaryFile("w+")  # noqa: SIM115 - closed with the object
        self.returncode: int | None = None
        self.pid = self._begin(list(arguments), self._said)

    def _begin(self, arguments: list[str], said: IO[str]) -> int:
        command = [sys.executable, "-m", "usdsdg", *arguments]
        self._process = subprocess.Popen(command, cwd=ROOT, stdout=said, stderr=subprocess.STDOUT)
        return self._process.pid

    def has_ended(self) -> bool:
        """Return whether it has ended."""
        if self.returncode is None:
            self.returncode = self._process.poll()
        return self.returncode is not None

    def wait_for_processor_seconds(self, seconds: float) -> None:
        """Wait until it has run for so long on processors, or has ended."""
        while not self.has_ended() and processor_seconds(self.pid) < seconds:
            time.sleep(POLL_SECONDS)

    def send(self, number: int) -> None:
        """Send a signal, unless it has ended."""
        if not self.has_ended():
            os.kill(self.pid, number)

    def wait(self) -> int:
        """Wait until it has ended; return its exit code, or -N where signal N has ended it."""
        while not self.has_ended():
            time.sleep(POLL_SECONDS)
        assert self.returncode is not None
        return self.returncode

    def kill(self) -> None:
        """End it at once."""
        self.send(signal.SIGKILL)
        self.wait()

    @property
    def said(self) -> str:
        """The end of what it has printed."""
        self._said.seek(0)
        return self._said.read()[-2000:]


class CopiedRun(CommandRun):
    """A run in a copy of this process, which has imported what it needs and must have no threads of its own."""

    def _begin(self, arguments: list[str], said: IO[str]) -> int:
        _import_engines()
        assert threading.active_count() == 1, threading.enumerate()
        sys.stdout.flush()
        pid = os.fork()
        if pid == 0:
            _become(arguments, said)
        return pid

    def has_ended(self) -> bool:
        """Return whether it has ended."""
        if self.returncode is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            self.returncode = os.waitstatus_to_exitcode(status) if pid else None
        return self.returncode is not None


@functools.cache
def _import_engines() -> None:
    for package in ENGINES:
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            importlib.import_module(module.name)
    for name in MODULES:
        importlib.import_module(name)


def _become(arguments: list[str], said: IO[str]) -> NoReturn:
    """Do what a new process of the command does, to its end."""
    code = 70
    try:
        os.chdir(ROOT)
        os.dup2(said.fileno(), 1)
        os.dup2(said.fileno(), 2)
        sys.argv = ["usdsdg", *arguments]
        importlib.import_module("usdsdg.cli.program").main()
        code = 0
    except SystemExit as ended:
        code = ended.code if isinstance(ended.code, int) else int(ended.code is not None)
    except BaseException:  # noqa: BLE001 - as Python does at the end of a program
        traceback.print_exc()
        code = 1
    finally:
        atexit._run_exitfuncs()
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
