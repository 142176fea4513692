"""Files about all frames that grow with them, such as names of classes, where parts are made in any order."""

from __future__ import annotations

import pytest

import usdsdg as rep
from tests.capture.part_runs import differences, run, run_again, run_parts
from tests.sampled_cases import sampled
from usdsdg.verify.verify import verify_all

WRITERS = {"yolo": "YoloWriter", "voc": "VocWriter", "cvat": "CvatWriter"}


def classes_come_later(folder):
    """Capture frames, of which each but the first has a class that the ones before lack."""
    camera = rep.create.camera(position=(8, 0, 3), look_at=(0, 0, 0))
    product = rep.create.render_product(camera, (32, 24))
    for name, kind in WRITERS.items():
        writer = rep.writers.get(kind)
        writer.initialize(output_dir=str(folder / name))
        writer.attach(product)
    for frame in range(4):
        rep.create.cube(position=(0, frame - 1.5, 0), scale=0.6, semantics=[("class", f"class_{frame}")])
        rep.orchestrator.step()


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    run(classes_come_later, folder)
    assert "class_3" in (folder / "yolo/data.yaml").read_text()
    return folder


@pytest.mark.parametrize(
    "portions", sampled([("2:4", "0:2"), ("3:4", "1:3", "0:1"), ("1/2", "0/2"), ("0/2", "1/2")], 2)
)
def test_parts_that_end_in_another_order_leave_the_files_of_the_last_frames(whole, portions, tmp_path):
    run_parts(classes_come_later, tmp_path, *portions)
    assert differences(tmp_path, whole) == []
    assert not [fault for report in verify_all(tmp_path) for fault in report.faults]


def test_a_run_that_goes_on_leaves_them(whole, tmp_path):
    run_again(classes_come_later, tmp_path / "again", whole, 2)
    assert differences(tmp_path / "again", whole) == []
