"""A script that is sent a signal once it has printed "ready"."""

import signal
import subprocess
import sys
import textwrap
from pathlib import Path


def run_and_signal(folder: Path, script: str, number: signal.Signals) -> tuple[int, str]:
    """Run a script in `folder`, send it the signal; return its exit code and what it printed to stderr."""
    (folder / "script.py").write_text(textwrap.dedent(script))
    process = subprocess.Popen(
        [sys.executable, "-m", "usdsdg", "run", "--quiet", "script.py"], cwd=folder, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True, preexec_fn=lambda: signal.signal(number, signal.SIG_DFL),
    )  # fmt: skip
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        process.send_signal(number)
        _, stderr = process.communicate(timeout=60)
    finally:
        process.kill()
    return process.returncode, stderr
