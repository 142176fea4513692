"""A run of several writers whose folders have not come equally far, and what it goes on to."""

from __future__ import annotations

import re
import shutil

import pytest

import usdsdg as rep
from tests.capture.part_runs import cut, differences, run
from tests.sampled_cases import crossed
from usdsdg.errors import UsdsdgWarning
from usdsdg.session.stage_context import new_stage
from usdsdg.writers.journal.earlier_run import Mode

BASIC = {"keypoints": True, "normals": True, "occlusion": True, "bounding_box_3d": True, "motion_vectors": True}
WRITERS = {
    "basic": ("BasicWriter", BASIC),
    "yolo": ("YoloWriter", {"task": "pose"}),
    "voc": ("VocWriter", {}),
    "coco": ("CocoWriter", {"plain_names": True}),
    "text": ("KittiWriter", {"semantic_types": ["class"]}),
}


def script(folder):
    """Write four frames of two cubes, of which one has keypoints, with all writers."""
    new_stage()
    rep.create.light(light_type="dome")
    cube = rep.functional.create.cube(position=(0, 0, 0), semantics={"class": "cube"})
    rep.functional.modify.keypoints(cube, {"top": (0, 0, 0.5), "far": (50, 0, 0)})
    other = rep.functional.create.cube(position=(1, 1, 0), semantics={"class": "other"})
    product = rep.create.render_product(rep.functional.create.camera(position=(1, -6, 1), look_at=(0, 0, 0)), (48, 32))
    for name, (kind, options) in WRITERS.items():
        writer = rep.writers.get(kind)
        writer.initialize(output_dir=str(folder / name), **options)
        writer.attach(product)
    for frame in range(4):
        rep.functional.modify.position(other, (1 - 0.3 * frame, 1, 0))
        rep.orchestrator.step(delta_time=0.0)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    run(script, folder)
    return folder


@pytest.mark.parametrize(("name", "is_gone"), crossed(WRITERS, [True, False]))
def test_a_folder_that_is_behind_gets_the_bytes_that_it_would_have(whole, tmp_path, name, is_gone):
    folder = shutil.copytree(whole, tmp_path / "out")
    if is_gone:
        shutil.rmtree(folder / name)
    else:
        cut(folder / name, 2)
    run(script, folder, mode=Mode.RESUME)
    assert not differences(folder, whole)


@pytest.mark.parametrize(
    ("lost", "frames"),
    [("yolo/metadata.txt", 2), ("yolo/data.yaml", 4), ("voc/.usdsdg/classes.json", 4), ("voc/labelmap.txt", 4)],
)
def test_files_about_all_frames_that_are_not_made_again_are_named(whole, tmp_path, lost, frames):
    folder = shutil.copytree(whole, tmp_path / "out")
    name = lost.partition("/")[0]
    if frames < 4:
        cut(folder / name, frames)
    (folder / lost).unlink()
    with pytest.warns(UsdsdgWarning, match=f"missing or changed: {re.escape(lost.partition('/')[2])} about all frames"):
        run(script, folder, mode=Mode.RESUME)


def test_no_file_is_named_where_all_are_there(whole, tmp_path, recwarn):
    folder = shutil.copytree(whole, tmp_path / "out")
    cut(folder / "yolo", 2)
    run(script, folder, mode=Mode.RESUME)
    assert not [each for each in recwarn if "missing or changed" in str(each.message)]
