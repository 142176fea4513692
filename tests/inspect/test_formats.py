"""Pages of every format that is written: they show what was rendered, by the record of the frames."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.inspect.page import Page
from tests.verify import datasets
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.parts import parts
from usdsdg.datasets.reading import FORMATS, images, objects_of
from usdsdg.errors import DatasetError
from usdsdg.inspect import inspect

FRAMES = 2
# Formats that list the visible boxes of objects, with the fewest pixels and rows of what they list.
BOXES = {
    "basic": (1, 1), "coco": (1, 1), "kitti": (1, 3), "kitti_plain": (1, 3), "yolo": (1, 1), "outlines": (5, 1),
    "bop": (1, 1), "voc": (1, 1), "cvat": (1, 1), "cvat_polygons": (4, 1),
}  # fmt: skip
POSES = ("pose", "dope", "centerpose")
# In pixels; of texts with few digits, and keypoints in whole pixels.
NEAR, WHOLE = 0.02, 1.0


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    return datasets.make(tmp_path_factory.mktemp("formats"), frames=FRAMES)


def edges(box) -> tuple[float, ...]:
    """The edges of first and last pixels."""
    return (box[0], box[1], box[2] + 1, box[3] + 1)


@pytest.mark.parametrize("name", BOXES)
def test_visible_boxes_are_those_of_the_record(made, name):
    fewest, rows = BOXES[name]
    for seen in images(Folder(made / name), set()):
        assert seen.truth is not None
        (key, *_) = seen.truth.product.selections
        things = [each for each in seen.truth.things(key) if each.box and each.visible >= fewest]
        expected = sorted(edges(each.box) for each in things if each.box[3] - each.box[1] >= rows - 1)
        found = sorted(each.box for each in objects_of(seen) if each.box is not None)
        assert len(found) == len(expected) > 0
        assert np.array(found) == pytest.approx(np.array(expected), abs=NEAR)


@pytest.mark.parametrize("name", [*POSES, "bop"])
def test_cuboids_are_where_the_recorded_camera_sees_them(made, name):
    checked = 0
    for seen in images(Folder(made / name), set()):
        truth = seen.truth
        assert truth is not None
        assert truth.camera is not None
        (key, *_) = truth.product.selections
        centers = [(each.bounds.mean(axis=0), each.local_to_world) for each in truth.things(key)]
        world = np.array([center @ pose[:3, :3] + pose[3, :3] for center, pose in centers])
        pixels, _ = truth.camera.project(world)
        for each in objects_of(seen):
            if each.cuboid is not None:
                # A model of BOP is the object without its labeled parts, so its center may be elsewhere.
                near = 6 * WHOLE if name == "bop" else WHOLE
                assert np.abs(pixels - each.cuboid[0]).max(axis=1).min() <= near
                checked += 1
    assert checked >= FRAMES


@pytest.mark.parametrize("name", datasets.DATASETS)
def test_a_page_is_made_of_every_format_without_a_problem(made, name):
    page = Page(inspect(made / name, made / f"{name}.html"))
    frames = page.values["frames"]
    assert len(frames) == FRAMES * datasets.DATASETS[name][2]
    assert page.values["problems"] == []
    assert all(frame["picture"] is not None or frame["layers"] for frame in frames)
    assert all(frame["size"] == list(datasets.SIZE) for frame in frames)


def test_masks_of_annotations_are_a_layer(made):
    for name in ("coco", "bop"):
        page = Page(inspect(made / name, made / f"{name}.html"))
        layer = page.values["frames"][0]["layers"]["instance_segmentation"]
        shown = np.asarray(page.image(layer["image"]).convert("RGBA"))
        (seen, *_) = images(Folder(made / name), set())
        assert seen.truth is not None
        (key, *_) = seen.truth.product.selections
        members = seen.truth.members(key)
        assert members is not None
        assert np.array_equal(shown[..., 3] > 0, members >= 0), name


def test_a_folder_of_all_formats_is_one_page(made, tmp_path):
    page = Page(inspect(made, tmp_path / "all.html"))
    assert len(page.values["frames"]) == FRAMES * sum(each[2] for each in datasets.DATASETS.values())
    assert page.values["problems"] == []
    assert {view.split("/")[0] for view in page.values["views"]} == set(datasets.DATASETS)
    assert {name.split(",")[0] for name in page.values["writers"]} == {each[0] for each in datasets.DATASETS.values()}


def test_parts_are_found_without_what_is_noted_beside_them(made, tmp_path):
    for name in ("coco", "yolo", "bop", "basic"):
        shutil.copytree(made / name, tmp_path / name, ignore=shutil.ignore_patterns(".usdsdg"))
    assert [part for part, _ in parts(tmp_path)] == ["", "bop", "coco", "yolo"]
    # BasicWriter's names tell what they are anywhere.
    assert all(file.startswith("basic/") for file in dict(parts(tmp_path))[""])
    assert Page(inspect(tmp_path)).values["problems"] == []


def test_every_format_has_a_name_of_its_own():
    assert len({each.NAME for each in FORMATS}) == len(FORMATS)


def test_what_is_broken_is_one_line(made, tmp_path):
    (tmp_path / "empty").mkdir()
    shutil.copytree(made / "coco", tmp_path / "coco")
    (table,) = (tmp_path / "coco").glob("*.json")
    table.write_bytes(table.read_bytes()[:200])
    for image in (tmp_path / "coco").rglob("*.png"):
        image.unlink()
    for name, expected in (("empty", "is empty"), ("coco", "is not valid JSON at line")):
        with pytest.raises(DatasetError, match=expected) as caught:
            inspect(tmp_path / name)
        assert "\n" not in str(caught.value)


def test_pictures_and_labels_without_each_other_are_one_line_each(made, tmp_path):
    shutil.copytree(made / "yolo", tmp_path / "yolo")
    first, second = sorted((tmp_path / "yolo" / "labels" / "train").iterdir())
    first.unlink()
    (tmp_path / "yolo" / "images" / "train" / second.with_suffix(".png").name).unlink()
    told = Page(inspect(tmp_path / "yolo")).problems()
    assert told == {
        "picture without labels": ["images/train/000000.png: there are no labels of it"],
        "labels without picture": ["labels/train/000001.txt: there is no picture of it"],
    }


def test_values_that_are_not_as_their_format_has_them_are_a_problem(made, tmp_path):
    shutil.copytree(made / "kitti", tmp_path / "kitti")
    label = next(path for path in (tmp_path / "kitti").rglob("*.txt") if path.parent.name == "object_detection")
    label.write_text("mug 0 0\n")
    scene = next((shutil.copytree(made / "bop", tmp_path / "bop")).rglob("scene_gt.json"))
    values = json.loads(scene.read_text())
    del values["0"][0]["cam_t_m2c"]
    scene.write_text(json.dumps(values))
    for name in ("kitti", "bop"):
        (told,) = Page(inspect(tmp_path / name)).problems()["unreadable file"]
        assert "is not as its format has it" in told
