"""Processes of this machine that make the parts of a dataset."""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import IO

from usdsdg.errors import WorkerFailed
from usdsdg.operating_system import IS_WINDOWS
from usdsdg.session.endings import parent_process
from usdsdg.stores.temporary import temporary_root
from usdsdg.workers.plan import Part

# How often a part is begun, the first time and after its process has died.
ATTEMPTS = 4
POLL_SECONDS = 0.1
TAIL = 4000  # characters of what a process has printed that an error shows
_REFUSED = 1  # exit code of an error that the next attempt would meet again
# Exit code of a process that has made its part, and whose script caught an error meanwhile.
CAUGHT = 79


@dataclass
class _Process:
    part: Part
    attempt: int
    child: subprocess.Popen[bytes]
    output: IO[bytes]

    def close_input(self) -> None:
        if self.child.stdin is not None:
            self.child.stdin.close()

    def tail(self) -> str:
        self.output.seek(0, 2)
        self.output.seek(max(0, self.output.tell() - TAIL))
        return self.output.read().decode(errors="replace").strip()


def make_parts(
    command: Callable[[Part], Sequence[str]], parts: Sequence[Part], count: int, tick: Callable[[], None]
) -> list[str]:
    """Run the command of each part, `count` at a time; where a process dies, its part is resumed by another.

    tick: called again and again meanwhile.

    Returns what the processes printed whose scripts caught an error.

    Raises:
        WorkerFailed: a process ended with an error, or died several times at the same part.
    """
    waiting = deque((part, 1) for part in parts)
    running: list[_Process] = []
    caught: list[str] = []
    try:
        while waiting or running:
            while waiting and len(running) < count:
                part, attempt = waiting.popleft()
                running.append(_start(command(part), part, attempt))
            time.sleep(POLL_SECONDS)
            tick()
            for process in [each for each in running if each.child.poll() is not None]:
                running.remove(process)
                process.close_input()
                if process.child.returncode == 0:
                    continue
                if process.child.returncode == CAUGHT:
                    caught.append(process.tail())
                    continue
                if process.child.returncode == _REFUSED or process.attempt == ATTEMPTS:
                    raise WorkerFailed(
                        f"the process of the frames {process.part.frames} ended with exit code "
                        f"{process.child.returncode}:\n{process.tail()}"
                    )
                waiting.appendleft((process.part, process.attempt + 1))
    finally:
        _end(running)
    return caught


def _start(command: Sequence[str], part: Part, attempt: int) -> _Process:
    output = tempfile.TemporaryFile(dir=temporary_root())  # noqa: SIM115 - closed with the object
    child = subprocess.Popen(
        command,
        stdin=subprocess.PIPE,  # which ends with this process, and nothing is written to
        env={**os.environ, parent_process.VARIABLE: "1"},
        stdout=output,
        stderr=subprocess.STDOUT,
        start_new_session=not IS_WINDOWS,  # not Ctrl-C of the terminal: the first process passes it on, once
    )
    return _Process(part, attempt, child, output)


def _end(running: Sequence[_Process]) -> None:
    """Ask the processes to finish their frames, and wait until they have."""
    for process in running:
        process.child.terminate()
    try:
        for process in running:
            process.child.wait()
            process.close_input()
    except BaseException:  # Ctrl-C again
        for process in running:
            process.child.kill()
        raise
