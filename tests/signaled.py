"""Programs that are sent signals."""

import contextlib
import signal
import subprocess
import sys
import textwrap
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any


def heed_signals() -> None:
    """Heed the signals that a process ignores which `nohup`, or a shell in its background, has started."""
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT, signal.SIGXCPU):
        signal.signal(number, signal.SIG_DFL)


@contextlib.contextmanager
def started(arguments: Sequence[str], **options: Any) -> Iterator[subprocess.Popen[str]]:
    """Start `python ARGUMENTS`, which heeds signals, with pipes for what it prints; yield it, and kill it at the end.

    options: other arguments of `subprocess.Popen`.
    """
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    process = subprocess.Popen([sys.executable, *arguments], text=True, preexec_fn=heed_signals, **pipes | options)
    with process:
        try:
            yield process
        finally:
            process.kill()


def run_and_signal(folder: Path, script: str, number: signal.Signals) -> tuple[int, str]:
    """Run a script in `folder`, send it a signal once it has printed "ready"; return its exit code and its stderr."""
    (folder / "script.py").write_text(textwrap.dedent(script))
    with started(["-m", "usdsdg", "run", "--quiet", "script.py"], cwd=folder) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        process.send_signal(number)
        _, stderr = process.communicate(timeout=60)
    return process.returncode, stderr
