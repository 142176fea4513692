"""Files about all frames: as if they were made in memory, with memory that does not grow with the frames."""

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest

from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.disk import DiskBackend
from usdsdg.writers.files import write_text
from usdsdg.writers.formats.bop.bop_tables import ModelTables, Scene
from usdsdg.writers.formats.coco.coco_file import CocoFiles

ROOT = Path(__file__).resolve().parents[2]
HEAD = {"info": {"version": "1", "keypoint_sigmas": {"mug": [0.1]}}, "licenses": []}
CATEGORIES = [{"id": 2, "name": "mug \u00fc"}, {"id": 3, "name": "can"}]


def coco(backend, frames, rows=3):
    files = CocoFiles(backend, "CocoWriter/train")
    about = {"path": "annotations/instances_train.json", "categories": CATEGORIES}
    files.note(head=HEAD, splits={"train": {"instances": about}})
    for number in range(frames):
        own = [coco_row(number, each) for each in range(rows)]
        files.add(number, split="train", image=coco_image(number), instances=own)
    return files


def coco_image(number):
    return {"id": number, "file_name": f"{number:06d}.png", "width": 640, "height": 480}


def coco_row(number, each):
    return {
        "image_id": number,
        "bbox": [0.1 * each, number, 7, 9],
        "segmentation": "oPYa0N" * 20,
    }


def test_coco_lists_every_record_once_in_order(tmp_path):
    backend = DiskBackend(tmp_path)
    coco(backend, 40).write()
    backend.wait_until_done()
    text = (tmp_path / "annotations/instances_train.json").read_text()
    rows = [coco_row(number, each) for number in range(40) for each in range(3)]
    rows = [{"id": number} | row for number, row in enumerate(rows, 1)]
    expected = {**HEAD, "images": list(map(coco_image, range(40))), "annotations": rows, "categories": CATEGORIES}
    assert list(json.loads(text).items()) == list(expected.items())
    lines = text.splitlines()
    assert lines[0] == "{"
    assert lines.index(json.dumps(rows[-1])) > lines.index(json.dumps(rows[0]) + ",") > lines.index('"annotations": [')


def test_bop_tables_are_the_text_that_json_makes(tmp_path):
    backend = DiskBackend(tmp_path)
    scene, models = Scene(backend, "train_pbr", 3, 0), ModelTables(backend, "BopWriter/models")
    scene.note(folder=scene.folder)
    cameras = {number: {"cam_K": [1.0, 2.5e-9], "depth_scale": 0.1} for number in (0, 2, 11)}
    poses = {0: [], 2: [{"obj_id": 1, "cam_t_m2c": [0.1, -0.0]}], 11: [{"obj_id": 2}, {"obj_id": 1}]}
    infos = {0: [], 2: [{"bbox_obj": [-1] * 4}], 11: [{}, {"visib_fract": 0.5}]}
    for number in cameras:
        tables = {"scene_camera": cameras[number], "scene_gt": poses[number], "scene_gt_info": infos[number]}
        scene.add(number, number=number, **tables)
    known = (1, 1001, 2, 1002)
    models.note(infos={n: {"diameter": 0.1 * n} for n in known}, names={n: f"class {n}" for n in known})
    for frame, seen in enumerate(([1002], [1, 2], [2])):
        models.add(frame, models=seen, camera={"fx": 1.5 + frame})
    scene.write()
    models.write()
    backend.wait_until_done()
    for name, values in {"scene_camera": cameras, "scene_gt": poses, "scene_gt_info": infos}.items():
        text = (tmp_path / f"train_pbr/000003/{name}.json").read_text()
        assert text == json.dumps({str(key): value for key, value in values.items()}, indent=1)
    info = {str(number): {"diameter": 0.1 * number} for number in (1, 2, 1002)}
    assert (tmp_path / "models/models_info.json").read_text() == json.dumps(info, indent=1)
    names = {str(number): f"class {number}" for number in (1, 2, 1002)}
    assert (tmp_path / "models/names.json").read_text() == json.dumps(names, indent=1)
    assert (tmp_path / "camera.json").read_text() == json.dumps({"fx": 1.5}, indent=1)


def test_without_models_the_table_is_empty(tmp_path):
    backend = DiskBackend(tmp_path)
    models = ModelTables(backend, "BopWriter/models")
    models.note(infos={}, names={})
    models.add(0, models=[], camera={})
    models.write()
    backend.wait_until_done()
    assert json.loads((tmp_path / "models/models_info.json").read_text()) == {}


def test_files_are_written_again_only_where_there_is_more(tmp_path):
    backend = DiskBackend(tmp_path)
    files, path = coco(backend, 2), tmp_path / "annotations/instances_train.json"
    files.write()
    backend.wait_until_done()
    path.unlink()
    files.write()
    backend.wait_until_done()
    assert not path.exists()
    about = {"path": "annotations/instances_train.json", "categories": CATEGORIES[:1]}
    files.note(head=HEAD, splits={"train": {"instances": about}})
    files.write()
    backend.wait_until_done()
    assert json.loads(path.read_text())["categories"] == CATEGORIES[:1]


def test_what_is_added_while_a_file_waits_is_not_in_it(tmp_path):
    backend = DiskBackend(tmp_path)
    files = coco(backend, 2)
    backend.schedule(time.sleep, 0.2)
    files.write()
    files.add(2, split="train", image=coco_image(2), instances=[])
    backend.wait_until_done()
    assert len(json.loads((tmp_path / "annotations/instances_train.json").read_text())["images"]) == 2


def test_the_file_waits_for_its_pictures():
    class Slow(BaseBackend):
        def __init__(self):
            self.paths = []

        def write_blob(self, path, data):
            if path.endswith("png"):
                time.sleep(0.2)
            self.paths.append(path)

    backend = Slow()
    backend.schedule(write_text, path="picture.png", text="")
    coco(backend, 1).write()
    backend.wait_until_done()
    assert backend.paths == ["picture.png", "annotations/instances_train.json"]


GROWN = """
import pathlib, resource, sys
from tests.writers.test_aggregate import coco
from usdsdg.writers.backends.disk import DiskBackend
backend = DiskBackend(sys.argv[1])
def peak_after(frames):
    coco(backend, frames).write()
    backend.wait_until_done()
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024  # bytes
few, many = peak_after(100), peak_after(20_000)
print(many - few)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the unit of ru_maxrss is another one")
def test_memory_does_not_grow_with_the_frames(tmp_path):
    """The records of 20,000 frames are 13 MB, and as Python's objects several times that."""
    done = subprocess.run([sys.executable, "-c", GROWN, str(tmp_path)], cwd=ROOT, capture_output=True, timeout=300)
    assert (tmp_path / ".usdsdg/aggregates/CocoWriter/train.jsonl").stat().st_size > 1.3e7
    assert len((tmp_path / "annotations/instances_train.json").read_bytes().splitlines()) > 80_000
    assert int(done.stdout) < 4e6, done.stderr.decode()


@pytest.mark.parametrize("frames", [1, 5])
def test_a_writer_that_is_made_again_begins_anew(tmp_path, frames):
    backend = DiskBackend(tmp_path)
    first = coco(backend, 3)
    first.write()
    coco(backend, frames).write()
    backend.wait_until_done()
    assert len(json.loads((tmp_path / "annotations/instances_train.json").read_text())["images"]) == frames
