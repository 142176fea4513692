"""A script that is sent a signal once it has printed "ready"."""

import signal
import subprocess
import sys
import textwrap
from pathlib import Path


def _heed_signals() -> None:
    """Heed the signals that a process ignores which `nohup`, or a shell in its background, has started."""
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
        signal.signal(number, signal.SIG_DFL)


def run_and_signal(folder: Path, script: str, number: signal.Signals) -> tuple[int, str]:
    """Run a script in `folder`, send it the signal; return its exit code and what it printed to stderr."""
    (folder / "script.py").write_text(textwrap.dedent(script))
    process = subprocess.Popen(
        [sys.executable, "-m", "usdsdg", "run", "--quiet", "script.py"], cwd=folder, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True, preexec_fn=_heed_signals,
    )  # fmt: skip
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        process.send_signal(number)
        _, stderr = process.communicate(timeout=60)
    finally:
        process.kill()
    return process.returncode, stderr
