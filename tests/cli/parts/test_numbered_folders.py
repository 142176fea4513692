"""Writers of which each wants a folder of its own, as CocoWriter: a run that goes on gives each the one that it had."""

import os
import signal
import subprocess
import sys

import pytest

from tests.cli.datasets import ROOT, content, merge, run

# A writer for each of three scenes, with one output_dir; may end in the middle of the last one.
SCRIPT = """
import os, signal, sys
import omni.replicator.core as rep

rep.create.light(light_type="dome", intensity=1000)
product = rep.create.render_product(rep.create.camera(position=(0, -5, 3), look_at=(0, 0, 0)), (32, 24))
cube = rep.create.cube(semantics=[("class", "cube")])
with rep.trigger.on_frame(), cube:
    rep.modify.pose(position=rep.distribution.uniform((-1, -1, 0), (1, 1, 1)))
for scene in range(3):
    coco = rep.writers.get("CocoWriter")
    coco.initialize(output_dir=os.path.join(sys.argv[1], "coco"))
    coco.attach([product])
    for frame in range(2):
        rep.orchestrator.step()
        if (scene, frame) == (2, 0) and "DIE" in os.environ:
            os.kill(os.getpid(), signal.SIGTERM)
    rep.orchestrator.wait_until_complete()
    coco.detach()
"""
NAMES, LATER = ["coco", "coco_0001", "coco_0002"], ["coco_0003", "coco_0004", "coco_0005"]
COMMAND = ["-m", "usdsdg", "run", "-q", "--device", "cpu"]


@pytest.fixture(scope="module")
def script(tmp_path_factory):
    file = tmp_path_factory.mktemp("script") / "script.py"
    file.write_text(SCRIPT)
    return str(file)


@pytest.fixture(scope="module")
def whole(script, tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    done = run([*COMMAND, script, str(folder)], fresh=True)
    assert done.returncode == 0, done.stderr
    assert sorted(each.name for each in folder.iterdir()) == NAMES
    return content(folder)


def runs_in(folder):
    """The files of two runs, under the names of the first one."""
    assert sorted(each.name for each in folder.iterdir()) == NAMES + LATER
    return [
        {
            f"{first}/{name}": data
            for first, own in zip(NAMES, each, strict=True)
            for name, data in content(folder / own).items()
        }
        for each in (NAMES, LATER)
    ]


def test_a_run_that_goes_on_gives_each_writer_the_folder_that_it_had_last(script, whole, tmp_path):
    assert run([*COMMAND, script, str(tmp_path)]).returncode == 0
    ended = subprocess.run(
        [sys.executable, *COMMAND, script, str(tmp_path)], cwd=ROOT, env={**os.environ, "DIE": "1"}, capture_output=True
    )
    assert ended.returncode == 128 + signal.SIGTERM, ended.stderr
    done = run([*COMMAND, "--resume", script, str(tmp_path)])
    assert done.returncode == 0, done.stderr
    assert runs_in(tmp_path) == [whole, whole]


def test_several_processes_leave_what_one_leaves_beside_an_earlier_run(script, whole, tmp_path):
    for _ in range(2):
        done = run([*COMMAND, "--workers", "2", script, str(tmp_path)])
        assert done.returncode == 0, done.stderr
    assert runs_in(tmp_path) == [whole, whole]


def test_parts_that_begin_at_the_same_moment_are_of_one_dataset(script, whole, tmp_path):
    """A folder is made some time before its recipe is written there, as the jobs of an array find it."""
    (tmp_path / "coco").mkdir()
    for shard in ("0/2", "1/2"):
        done = run([*COMMAND, "--shard", shard, script, str(tmp_path)])
        assert done.returncode == 0, done.stderr
    assert merge(tmp_path).returncode == 0
    assert content(tmp_path) == whole
