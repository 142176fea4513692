"""`rep.get_stage` and `rep.save_stage`."""

import subprocess
import sys

import pytest
from pxr import Usd

import usdsdg as rep
from usdsdg import errors
from usdsdg.session.stage_context import current_stage

SCRIPT = """
import usdsdg as rep
cube = rep.create.cube(semantics=[("class", "crate")])
with rep.trigger.on_frame():
    with cube:
        rep.modify.pose(position=rep.distribution.uniform((0, 0, 0), (1, 1, 1)))
rep.orchestrator.run(num_frames=2)
rep.save_stage("saved.usda")
"""


def test_the_stage_is_the_one_that_scripts_author(stage):
    cube = rep.create.cube()
    assert rep.get_stage() is current_stage()
    assert rep.get_stage().GetPrimAtPath(cube.prims[0])


def test_a_saved_stage_is_that_of_the_option(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    command = [
        sys.executable,
        "-m",
        "usdsdg",
        "run",
        "-q",
        "--device",
        "cpu",
        "--save-stage",
        "option.usda",
        "script.py",
    ]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "saved.usda").read_bytes() == (tmp_path / "option.usda").read_bytes()


def test_a_saved_stage_opens_again(tmp_path, stage):
    cube = rep.create.cube(position=(1, 2, 3))
    path = rep.save_stage(tmp_path / "scene.usd")
    assert Usd.Stage.Open(str(path)).GetPrimAtPath(cube.prims[0])


def test_a_stage_is_saved_as_usd_only(tmp_path, stage):
    with pytest.raises(errors.Unsupported, match="usdc"):
        rep.save_stage(tmp_path / "scene.png")
