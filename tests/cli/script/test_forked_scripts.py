"""Scripts that fork while a run is active: the copies leave the dataset to the process that captures its frames."""

import os

import pytest

from tests import forked
from usdsdg.verify.verify import verify
from usdsdg.writers.journal import journal

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")

SCENE = """
import os, signal, sys, time
import usdsdg as rep

camera = rep.create.camera(position=(3, 0, 0), look_at=(0, 0, 0))
cube = rep.create.cube(semantics=[("class", "cube")])
writer = rep.writers.get("BasicWriter")
writer.initialize(output_dir=os.path.abspath("out"), rgb=True, bounding_box_2d_tight=True)
writer.attach(rep.create.render_product(camera, (8, 8)))

def step():
    with cube:
        rep.modify.pose(position=(0, 0.1 * step.frames, 0))
    step.frames += 1
    rep.orchestrator.step()

step.frames = 0
step()
"""
ENDS = """
if not (child := os.fork()):
    END
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == CODE
step()
"""
DAEMON = """
if os.fork():
    os._exit(0)
step()
"""
CAPTURES = """
    try:
        step()
    except Exception as error:
        print(error)
    sys.exit()
"""
POOL = """
import multiprocessing
with multiprocessing.get_context("fork").Pool(2) as pool:
    print(pool.map(abs, [-1, 2]))
step()
"""
AT_EXIT = """
import atexit
atexit.register(step)
"""


def done(folder, source, *, runs):
    (folder / "script.py").write_text(SCENE + source)
    command = ["-m", "usdsdg", "run", "--device", "cpu", "script.py"] if runs else ["script.py"]
    return forked.run(command, cwd=folder, fresh=True)


def is_whole(folder, frames):
    told = journal.read(folder / "out/.usdsdg/journal.jsonl")
    return told.is_complete and told.frames == frames and verify(folder / "out").faults == []


def test_a_copy_that_ends_leaves_the_dataset_to_the_program(tmp_path):
    ended = done(tmp_path, ENDS.replace("END", "sys.exit(3)").replace("CODE", "3"), runs=False)
    assert (ended.returncode, "error" in ended.stderr) == (0, False), ended.stderr
    assert is_whole(tmp_path, {0, 1})


def test_copies_leave_the_dataset_to_the_command_and_end_without_a_word(tmp_path):
    source = ENDS.replace("    END", CAPTURES.strip("\n")).replace("CODE", "0") + POOL
    ended = done(tmp_path, source, runs=True)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.startswith(f"{tmp_path / 'out'}: this process is a copy, by fork, of the one that writes to")
    assert ended.stdout.endswith("\n[1, 2]\n")
    assert not any(each in ended.stderr for each in ("error", "SIGTERM")), ended.stderr
    assert ended.stderr.count("next:") == 1
    assert is_whole(tmp_path, {0, 1, 2})


def test_a_copy_that_captures_goes_on_with_the_run_and_has_no_frames_after_its_end(tmp_path):
    ended = done(tmp_path, DAEMON + AT_EXIT, runs=True)  # which waits for the pipes that the daemon has, too
    assert "frames that a function of atexit captures would be in none of them" in ended.stderr
    assert is_whole(tmp_path, {0, 1})
