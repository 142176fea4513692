"""Run Python programs as processes that do not import everything again: forks of one that has done nothing but import.

On other systems than Linux, and where `fresh` asks for it, the programs are ordinary processes.
"""

from __future__ import annotations

import atexit
import functools
import io
import locale
import os
import select
import selectors
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO

from tests.forked.client import EXECUTABLE, ask, told
from tests.signaled import heed_signals

ROOT = Path(__file__).resolve().parents[2]
CLIENT = Path(__file__).with_name("client.py")
SERVER = "USDSDG_TESTS_SERVER"  # variable with the socket of a server for all processes that run tests


@functools.cache
def server() -> Path:
    """Return the socket of the server: the one that `python -m tests` has started, or else this process's own."""
    return Path(os.environ[SERVER]) if SERVER in os.environ else start(os.environ)


def start(environment: Mapping[str, str]) -> Path:
    """Start a server, which ends with this process; return its socket."""
    # Not below a test's own folder: paths of sockets have to be short.
    folder = tempfile.TemporaryDirectory()
    path = Path(folder.name) / "socket"
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.forked.server", str(path)],
        cwd=ROOT, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    )  # fmt: skip
    assert process.stdin is not None
    assert process.stdout is not None
    # The end of its input ends it, also where this process is killed.
    atexit.register(folder.cleanup)
    atexit.register(process.wait)
    atexit.register(process.stdin.close)
    assert process.stdout.readline() == b"ready\n"
    return path


def command() -> list[str]:
    """Return a command that does what `python` does with the arguments that follow, in a fork."""
    if not hasattr(os, "pidfd_open"):
        return [sys.executable]
    return [sys.executable, "-I", "-S", str(CLIENT), str(server())]


def executable() -> str:
    """Return a file that does what `python` does, in a fork: what a program starts that is given it in EXECUTABLE."""
    path = server().with_name("python")
    if not path.exists():
        own = path.with_name(f"python_{os.getpid()}")  # others may write theirs, or run the one that is there
        own.write_text(f'#!/bin/sh\nexec {shlex.join(command())} "$@"\n')
        own.chmod(0o755)
        own.replace(path)
    return str(path)


def run(
    arguments: Sequence[str],
    *,
    cwd: Path,
    env: Mapping[str, str] | None = None,
    timeout: float = 280,
    fresh: bool = False,
) -> subprocess.CompletedProcess[str]:
    """Run `python ARGUMENTS` and return what it has printed; what it starts by `sys.executable` are forks, too.

    fresh: as a process that imports everything itself, for programs that set what libraries read when they are loaded.

    Raises:
        subprocess.TimeoutExpired: it took longer than `timeout` [s], and was killed.
    """
    if not fresh and hasattr(os, "pidfd_open"):
        return _run_fork(list(arguments), cwd, os.environ if env is None else env, timeout)
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=cwd,
        env=env,
        capture_output=True,
        text=True,
        timeout=timeout,
        preexec_fn=heed_signals,
    )


def _run_fork(
    arguments: list[str], folder: Path, variables: Mapping[str, str], timeout: float
) -> subprocess.CompletedProcess[str]:
    """Do what `subprocess.run` does with the client, which would start one process more."""
    variables = {**variables, EXECUTABLE: executable()}  # starts the server, which is no time of the program
    until = time.monotonic() + timeout
    outputs, ends = zip(os.pipe(), os.pipe(), strict=True)
    printed = {output: b"" for output in outputs}
    with open(os.devnull) as nothing, selectors.DefaultSelector() as open_outputs:
        streams = [nothing.fileno(), *ends]
        connection = ask(server(), arguments, os.path.abspath(folder), streams, variables)
        for end in ends:
            os.close(end)
        with connection:  # whose end kills the fork
            told(connection)
            for output in outputs:
                open_outputs.register(output, selectors.EVENT_READ)
            while open_outputs.get_map():
                ready = open_outputs.select(max(0.0, until - time.monotonic()))
                if not ready:
                    raise subprocess.TimeoutExpired(arguments, timeout)
                for key, _ in ready:
                    data = os.read(key.fd, 1 << 16)
                    printed[key.fd] += data
                    if not data:
                        open_outputs.unregister(key.fd)
                        os.close(key.fd)
            code = int(told(connection))
    texts = [io.TextIOWrapper(io.BytesIO(data), encoding=locale.getencoding()).read() for data in printed.values()]
    return subprocess.CompletedProcess(arguments, code, *texts)


class Fork:
    """A program in a fork that can be sent signals at any moment, on Linux only.

    Args:
        arguments: as after `python`.
        output: where what it prints goes, also its errors.
    """

    def __init__(self, arguments: Sequence[str], *, cwd: Path, output: IO[str]) -> None:
        with open(os.devnull) as nothing:
            streams = [nothing.fileno(), output.fileno(), output.fileno()]
            self._connection = ask(server(), list(arguments), str(cwd), streams)
        self.pid = int(told(self._connection))
        self.returncode: int | None = None
        self.processor_seconds = 0.0  # when it has ended: what it has taken of processors, with processes that it began

    def poll(self) -> int | None:
        """Return its exit code, -N where signal N has ended it; None before its end."""
        if self.returncode is None and select.select([self._connection], [], [], 0)[0]:
            self.wait()
        return self.returncode

    def wait(self) -> int:
        """Wait for its end; return its exit code."""
        if self.returncode is None:
            self.returncode, self.processor_seconds = int(told(self._connection)), told(self._connection)
            self._connection.close()
        return self.returncode
