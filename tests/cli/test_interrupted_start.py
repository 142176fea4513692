"""Ctrl-C while the program is still reading its modules: one line and exit code 130, whoever is being read."""

import signal
import subprocess
import sys

import pytest

PROGRAM = """
import signal, sys

class InterruptsAtImport:
    def find_spec(self, name, *_):
        if name == "MODULE":
            signal.raise_signal(signal.SIGINT)

sys.meta_path.insert(0, InterruptsAtImport())
sys.argv = ["usdsdg", *sys.argv[1:]]
from usdsdg_program import main
main()
"""


def usdsdg(*arguments: str, module: str, on_interrupt=signal.SIG_DFL) -> subprocess.CompletedProcess[str]:
    """The installed program, which gets a Ctrl-C when it asks for `module`."""
    return subprocess.run(
        [sys.executable, "-c", PROGRAM.replace("MODULE", module), *arguments],
        capture_output=True, text=True, timeout=60, preexec_fn=lambda: signal.signal(signal.SIGINT, on_interrupt),
    )  # fmt: skip


# C++ asks for the last two of pxr: it drops a KeyboardInterrupt in one and makes a TypeError of it in the other.
@pytest.mark.parametrize("module", ["usdsdg", "numpy", "typer", "pxr.Sdf", "pxr.Kind", "pxr.Vt", "usdsdg.cli.simulate"])
def test_reading_modules_ends_with_one_line(module):
    done = usdsdg("doctor", module=module)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "interrupted\n")


def test_a_command_that_has_begun_finishes_its_files():
    done = usdsdg("doctor", module="warp")
    assert done.returncode == 130
    assert done.stderr.splitlines()[-1] == "files written so far are whole"


def test_a_program_that_was_told_to_ignore_it_does():
    done = usdsdg("--version", module="numpy", on_interrupt=signal.SIG_IGN)
    assert done.returncode == 0
    assert done.stdout.startswith("usdsdg ")
    assert done.stderr == ""
