"""A process that answers requests, with a limit of time for each."""

from __future__ import annotations

import json
import selectors
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from tests.soak.processor_time import processor_seconds

POLL_SECONDS = 0.1
# Of the clock for each second of processor time that a request may take: other work beside it may take the rest.
PATIENCE = 30.0


class Worker:
    """Answers requests in a process of its own, which is begun again after it crashed or took too long."""

    def __init__(self, log: Path, module: str = "tests.soak.meshes.worker") -> None:
        """module: reads a line of JSON for each request, and writes one for its answer."""
        self._log, self._module = log, module
        self._process: subprocess.Popen[str] | None = None

    def ask(self, file: Path, folder: Path, *, picture: bool, limit: float) -> dict[str, Any]:
        """Return what became of a file, or {"crashed": why}; `limit`: as in `answer`."""
        folder.mkdir(parents=True, exist_ok=True)
        return self.answer({"file": str(file), "folder": str(folder), "picture": picture}, limit)

    def answer(self, request: dict[str, Any], limit: float) -> dict[str, Any]:
        """Return the answer to a request, or {"crashed": why}.

        limit: seconds of processor time that it may take; a process that waits for ever is ended later.
        """
        process = self._started()
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(json.dumps(request) + "\n")
        process.stdin.flush()
        ready = _answers_in_time(process, limit)
        line = process.stdout.readline() if ready else ""
        if line:
            return json.loads(line)
        self.close()
        tail = self._log.read_text(errors="replace").strip().splitlines()[-1:] or [""]
        return {"crashed": f"took more than {limit:g} s" if not ready else f"the process ended: {tail[0]}"}

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None

    def _started(self) -> subprocess.Popen[str]:
        if self._process is None:
            with self._log.open("w") as log:
                self._process = subprocess.Popen(
                    [sys.executable, "-m", self._module],
                    stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log, text=True,
                )  # fmt: skip
        return self._process


def _answers_in_time(process: subprocess.Popen[str], limit: float) -> bool:
    """Wait until a process has written something; return False if that takes too long."""
    began, until = processor_seconds(process.pid), time.monotonic() + PATIENCE * limit
    with selectors.DefaultSelector() as selector:
        selector.register(process.stdout, selectors.EVENT_READ)  # type: ignore[arg-type] - it is a pipe
        while not selector.select(POLL_SECONDS):
            if processor_seconds(process.pid) - began > limit or time.monotonic() > until:
                return False
    return True
