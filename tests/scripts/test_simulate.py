"""`usdsdg simulate`: reads a stage and writes it with the simulated poses."""

import numpy as np
import pytest
from pxr import Usd

from tests.physics.impacts import calm_scenes
from tests.physics.scenes import add, fallen, new_stage, position
from tests.scripts.conftest import usdsdg


def test_a_body_falls_and_only_our_own_progress_is_printed(tmp_path):
    stage = new_stage()
    add(stage, "/World/box", at=(0, 0, 5))
    stage.Export(str(tmp_path / "scene.usda"))
    done = usdsdg("simulate", "scene.usda", "settled.usda", "--seconds=0.5", "--device=cpu", cwd=tmp_path)
    settled = Usd.Stage.Open(str(tmp_path / "settled.usda"))
    # 30 steps of 1/60 s.
    assert position(settled.GetPrimAtPath("/World/box"))[2] == pytest.approx(5 - fallen(30), abs=1e-3)
    assert done.stdout.strip() == str(tmp_path / "settled.usda")
    lines = done.stderr.splitlines()
    assert all(line.startswith("[usdsdg] ") for line in lines), done.stderr


def test_a_stage_without_rigid_bodies_says_so_and_its_file_is_never_overwritten(tmp_path):
    (tmp_path / "still.usda").write_text('#usda 1.0\ndef Cube "box" {}\n')
    done = usdsdg("simulate", "still.usda", "out.usda", "--seconds=0.1", "--device=cpu", cwd=tmp_path)
    assert "no rigid body" in done.stderr
    before = (tmp_path / "still.usda").read_bytes()
    refused = usdsdg("simulate", "still.usda", "./still.usda", "--device=cpu", cwd=tmp_path, expect=1)
    assert "give the result another name" in refused.stderr
    assert (tmp_path / "still.usda").read_bytes() == before


def test_an_output_that_cannot_be_written_is_an_error_before_the_simulation(tmp_path):
    (tmp_path / "still.usda").write_text('#usda 1.0\ndef Cube "box" {}\n')
    (tmp_path / "file").write_text("not a folder")
    done = usdsdg("simulate", "still.usda", "file/out.usda", cwd=tmp_path, expect=1)
    assert done.stderr.startswith(f"error: the stage cannot be saved to {tmp_path / 'file' / 'out.usda'}: ")


def test_settle_puts_a_box_that_starts_inside_another_on_top_of_it(tmp_path):
    """Then it is simulated from there: the two stay, since they rest; without the option they would begin to move."""
    calm_scenes.overlapping_pair().Export(str(tmp_path / "scene.usda"))
    usdsdg("simulate", "scene.usda", "settled.usda", "--settle", "--seconds=0.1", "--device=cpu", cwd=tmp_path)
    settled = Usd.Stage.Open(str(tmp_path / "settled.usda"))
    found = [position(thing) for thing in calm_scenes.things(settled)]
    np.testing.assert_allclose(found, [(0, 0, 0.1), (0, 0, 0.3)], atol=1e-3)


def test_settle_names_what_still_moves_after_ten_seconds(tmp_path):
    """A box without a floor below it, which ends where ten seconds of falling in oil bring it."""
    stage = new_stage()
    add(stage, "/World/box", at=(0, 0, 5))
    stage.Export(str(tmp_path / "scene.usda"))
    done = usdsdg("simulate", "scene.usda", "out.usda", "--settle", "--seconds=0", "--device=cpu", cwd=tmp_path)
    assert "still move" in done.stderr
    assert "/World/box" in done.stderr
    out = Usd.Stage.Open(str(tmp_path / "out.usda"))
    # At g / damping = 9.81 / 6 m/s, less what a substep of 1/120 s brakes, after 1/6 s without speed.
    assert position(out.GetPrimAtPath("/World/box"))[2] == pytest.approx(
        5 - 9.81 / 6 * (1 - 6 / 120) * (10 - 1 / 6), rel=0.01
    )


@pytest.mark.parametrize("seconds", ["inf", "nan", "1e308"])
def test_a_time_without_end_is_refused(tmp_path, seconds):
    (tmp_path / "still.usda").write_text('#usda 1.0\ndef Cube "box" {}\n')
    done = usdsdg("simulate", "still.usda", "out.usda", f"--seconds={seconds}", cwd=tmp_path, expect=2)
    assert "Invalid value for '--seconds'" in done.stderr
    assert not (tmp_path / "out.usda").exists()


def test_a_reference_that_does_not_open_is_named(tmp_path):
    scene = '#usda 1.0\ndef Xform "World"\n{\n    def "Part" (references = @./nowhere.usd@)\n    {\n    }\n}\n'
    (tmp_path / "scene.usda").write_text(scene)
    done = usdsdg("simulate", "scene.usda", "out.usda", "--seconds", "0", cwd=tmp_path)
    (warning,) = [line for line in done.stderr.splitlines() if line.startswith("warning: /World/Part")]
    assert f"refers to {tmp_path / 'nowhere.usd'}, which cannot be opened" in warning
