"""SIGKILL of the process of `--workers N` ends those that it has started, so that `--resume` goes on at once."""

import os
import subprocess
import textwrap
import time

from tests import forked
from tests.cli.datasets import content
from tests.forked.client import EXECUTABLE
from tests.signaled import started

# Longer than the test waits, so that a process that goes on is seen.
LONG, SOON = 90.0, 30.0
SCRIPT = f"""
import os, sys, time
from pathlib import Path
import omni.replicator.core as rep

assert sys.stdin.read() == ""
is_first = not Path("counted").exists()
Path("counted").touch()
cube = rep.create.cube(semantics=[("class", "cube")])
product = rep.create.render_product(rep.create.camera(position=(4, 4, 3), look_at=cube), (32, 24))
with rep.trigger.on_frame():
    with cube:
        rep.modify.pose(position=rep.distribution.uniform((-1, -1, -1), (1, 1, 1)))
writer = rep.writers.get("BasicWriter")
writer.initialize(output_dir=os.path.abspath("out"), rgb=True)
writer.attach(product)
for frame in range(6):
    rep.orchestrator.step()
    if "SLOW" in os.environ and not is_first and frame == 1:
        Path(f"made_{{os.getpid()}}").touch()
        time.sleep({LONG})
"""
ALONE = ["-m", "usdsdg", "run", "-q", "--device", "cpu"]
RUN = [*ALONE, "--workers", "2"]


def test_workers_end_with_the_process_that_has_started_them(tmp_path):
    whole, folder = tmp_path / "whole", tmp_path / "killed"
    for each in (whole, folder):
        each.mkdir()
        (each / "script.py").write_text(textwrap.dedent(SCRIPT))
    done = forked_run(*ALONE, "script.py", folder=whole)
    assert done.returncode == 0, done.stderr
    # Its own input has ended from the beginning, which is no reason to end.
    with started([*RUN, "script.py"], cwd=folder, env=os.environ | {"SLOW": "1"}, stdin=subprocess.DEVNULL) as process:
        until = time.monotonic() + LONG
        while len(list(folder.glob("made_*"))) < 2:
            assert time.monotonic() < until
            assert process.poll() is None
            time.sleep(0.05)
        process.kill()
    until = time.monotonic() + SOON
    again = resumed(folder)
    while again.returncode and "another process is writing" in again.stderr:
        assert time.monotonic() < until, "the workers go on"
        time.sleep(0.2)
        again = resumed(folder)
    assert again.returncode == 0, again.stderr
    assert content(folder / "out") == content(whole / "out")


def resumed(folder):
    return forked_run(*RUN, "--resume", "script.py", folder=folder)


def forked_run(*arguments, folder):
    """Run a command whose input has ended, in forks; what is killed above are processes of their own."""
    environment = os.environ | {EXECUTABLE: forked.executable()}
    return subprocess.run(
        [*forked.command(), *arguments],
        cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True,
    )  # fmt: skip
