"""What a command prints, where it cannot be written, whether Python keeps a buffer or not.

A result that cannot be written to stdout is an error of one line; what cannot be written to stderr is left out.
"""

import contextlib
import os
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("arguments", [["schema"], ["--help"], ["completion", "bash"], ["compat", __file__]])
def test_a_full_disk_is_one_line(arguments, unbuffered):
    with open("/dev/full", "w") as full:
        done = run(arguments, unbuffered, stdout=full)
    assert done.stderr == "error: the results cannot be printed: No space left on device\n"
    assert done.returncode == 1


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
def test_a_run_that_prints_nothing_needs_no_room(tmp_path):
    (tmp_path / "script.py").touch()
    with open("/dev/full", "w") as full:
        done = run(["run", "-q", str(tmp_path / "script.py")], "", stdout=full)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_that_has_had_enough_hears_nothing(unbuffered):
    reading, writing = os.pipe()
    os.close(reading)
    done = run(["schema"], unbuffered, stdout=writing)
    os.close(writing)
    assert (done.returncode, done.stderr) == (1, "")


TALKING = """
import sys, warnings
print("a word", file=sys.stderr)
warnings.warn("a warning")
print("at the end")
"""


@pytest.mark.parametrize(
    ("kind", "unbuffered"), [("no reader", ""), ("no reader", "1"), ("full", ""), ("would wait", "")]
)
def test_a_run_goes_on_where_nothing_can_be_told_of_it(tmp_path, kind, unbuffered):
    script = tmp_path / "script.py"
    script.write_text(TALKING)
    if kind == "full":
        if not Path("/dev/full").exists():
            pytest.skip("a device of Linux")
        stderr = os.open("/dev/full", os.O_WRONLY)
    else:
        reading, stderr = os.pipe()
        if kind == "no reader":
            os.close(reading)
        else:
            os.set_blocking(stderr, False)
            with contextlib.suppress(BlockingIOError):
                while os.write(stderr, bytes(4096)):
                    pass
    done = run(["run", str(script)], unbuffered, stdout=subprocess.PIPE, stderr=stderr)
    os.close(stderr)
    assert (done.returncode, done.stdout) == (0, "at the end\n")


def run(arguments, unbuffered, *, stdout, stderr=subprocess.PIPE):
    environment = os.environ | {"PYTHONUNBUFFERED": unbuffered}
    command = [sys.executable, "-m", "usdsdg", *arguments]
    return subprocess.run(command, env=environment, text=True, timeout=100, stdout=stdout, stderr=stderr)
