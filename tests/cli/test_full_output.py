"""What a command prints, where it cannot be written: one line, whether Python keeps a buffer or not."""

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


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_that_has_had_enough_hears_nothing(unbuffered):
    reading, writing = os.pipe()
    os.close(reading)
    done = run(["schema"], unbuffered, stdout=writing)
    os.close(writing)
    assert (done.returncode, done.stderr) == (1, "")


def run(arguments, unbuffered, **streams):
    environment = os.environ | {"PYTHONUNBUFFERED": unbuffered}
    command = [sys.executable, "-m", "usdsdg", *arguments]
    return subprocess.run(command, env=environment, stderr=subprocess.PIPE, text=True, timeout=100, **streams)
