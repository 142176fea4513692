"""Kinds of label faults of plain COCO, with keypoints, polygons and segments."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.verify.label_faults import edit_image, edit_json, kind

# COCO's keypoints


def _instances(folder: Path, change: Callable[[dict], None]) -> None:
    """Change every annotation of every part of the dataset."""
    for path in folder.glob("annotations/instances_*.json"):
        edit_json(path, lambda values: [change(each) for each in values["annotations"]] and None)


def _keypoints(folder: Path, change: Callable[[np.ndarray], np.ndarray]) -> None:
    def each(values: dict) -> None:
        if "keypoints" in values:
            values["keypoints"] = change(np.array(values["keypoints"], float).reshape(-1, 3)).ravel().tolist()

    _instances(folder, each)


@kind("keypoints with y before x", "coco_plain")
def _(folder: Path) -> None:
    _keypoints(folder, lambda rows: rows[:, (1, 0, 2)])


@kind("keypoints in another order than their names", "coco_plain")
def _(folder: Path) -> None:
    _keypoints(folder, lambda rows: rows[::-1])


@kind("keypoints half a pixel off", "coco_plain")
def _(folder: Path) -> None:
    _keypoints(folder, lambda rows: rows - np.where(rows[:, 2:] > 0, (0.5, 0.5, 0), 0))


@kind("keypoints that are all visible", "coco_plain")
def _(folder: Path) -> None:
    _keypoints(folder, lambda rows: np.where([False, False, True], 2, rows))


@kind("num_keypoints of all that the category names", "coco_plain")
def _(folder: Path) -> None:
    def count(values: dict) -> None:
        if "keypoints" in values:
            values["num_keypoints"] = len(values["keypoints"]) // 3

    _instances(folder, count)


@kind("category without its keypoints", "coco_plain")
def _(folder: Path) -> None:
    for path in folder.glob("annotations/instances_*.json"):
        edit_json(path, lambda values: [each.pop("keypoints", None) for each in values["categories"]] and None)


# COCO's list of images


def _leave_out(file: Path) -> None:
    def leave_out(values: dict) -> None:
        number = values["images"].pop(0)["id"]
        values["annotations"] = [each for each in values["annotations"] if each["image_id"] != number]

    edit_json(file, leave_out)


@kind("picture that Replicator's annotation file does not list", "coco")
def _(folder: Path) -> None:
    _leave_out(next(folder.glob("coco_annotations_*.json")))


@kind("picture that no annotation file lists", "coco_polygons")
def _(folder: Path) -> None:
    _leave_out(folder / "annotations/instances_train.json")


@kind("picture that only the panoptic file lists", "coco_plain")
def _(folder: Path) -> None:
    _leave_out(folder / "annotations/instances_train.json")


# COCO's polygons


@kind("polygons one pixel lower", "coco_polygons")
def _(folder: Path) -> None:
    def lower(values: dict) -> None:
        values["segmentation"] = [[value + place % 2 for place, value in enumerate(p)] for p in values["segmentation"]]

    _instances(folder, lower)


@kind("polygons from center to center of pixels", "coco_polygons")
def _(folder: Path) -> None:
    def narrow(values: dict) -> None:
        x, y, width, height = values["bbox"]
        ends = (x + width, y + height)
        values["segmentation"] = [
            [value - (value == ends[place % 2]) for place, value in enumerate(p)] for p in values["segmentation"]
        ]

    _instances(folder, narrow)


@kind("boxes as polygons", "coco_polygons")
def _(folder: Path) -> None:
    def box(values: dict) -> None:
        x, y, width, height = values["bbox"]
        values["segmentation"] = [[x, y, x + width, y, x + width, y + height, x, y + height]]

    _instances(folder, box)


@kind("small objects dropped", "coco_polygons")
def _(folder: Path) -> None:
    def drop(values: dict) -> None:
        areas = sorted(each["area"] for each in values["annotations"])
        values["annotations"] = [each for each in values["annotations"] if each["area"] > areas[1]]

    for path in folder.glob("annotations/instances_*.json"):
        edit_json(path, drop)


# COCO's splits and segments


@kind("training pictures for validation", "coco_plain")
def _(folder: Path) -> None:
    for name in ("instances", "panoptic"):
        shutil.copy(folder / f"annotations/{name}_train.json", folder / f"annotations/{name}_val.json")


@kind("category ids counted from 1", "coco_plain")
def _(folder: Path) -> None:
    for path in folder.glob("annotations/*.json"):
        edit_json(path, lambda values: [each.update(id=each["id"] - 1) for each in values["categories"]] and None)


def _panoptic(folder: Path, change: Callable[[dict], None]) -> None:
    for path in folder.glob("annotations/panoptic_*.json"):
        edit_json(
            path,
            lambda values: [change(each) for one in values["annotations"] for each in one["segments_info"]] and None,
        )


@kind("panoptic categories with the names of others", "coco_plain")
def _(folder: Path) -> None:
    def turn(values: dict) -> None:
        names = [each["name"] for each in values["categories"]]
        for each, name in zip(values["categories"], names[1:] + names[:1]):
            each["name"] = each["supercategory"] = name

    for path in folder.glob("annotations/panoptic_*.json"):
        edit_json(path, turn)


@kind("panoptic images of another size", "coco_plain")
def _(folder: Path) -> None:
    for path in folder.glob("annotations/panoptic_*.json"):
        edit_json(path, lambda values: [each.update(width=2 * each["width"]) for each in values["images"]] and None)


@kind("segments that are crowds", "coco_plain")
def _(folder: Path) -> None:
    _panoptic(folder, lambda each: each.update(iscrowd=1))


@kind("ids of segments as BGR", "coco_plain")
def _(folder: Path) -> None:
    for path in folder.glob("annotations/panoptic_*/*.png"):
        edit_image(path, lambda image: image[..., ::-1])


@kind("areas of segments of boxes", "coco_plain")
def _(folder: Path) -> None:
    _panoptic(folder, lambda each: each.update(area=each["bbox"][2] * each["bbox"][3]))


@kind("boxes of segments as corners", "coco_plain")
def _(folder: Path) -> None:
    def corners(each: dict) -> None:
        x, y, width, height = each["bbox"]
        each["bbox"] = [x, y, x + width, y + height]

    _panoptic(folder, corners)


@kind("stale picture of segments", "coco_plain")
def _(folder: Path) -> None:
    first, second, *_ = sorted(folder.glob("annotations/panoptic_train/*.png"))
    shutil.copy(first, second)


@kind("categories of segments swapped", "coco_plain")
def _(folder: Path) -> None:
    def swap(values: dict) -> None:
        first, second, *_ = sorted(each["id"] for each in values["categories"])
        for one in values["annotations"]:
            for each in one["segments_info"]:
                number = each["category_id"]
                each["category_id"] = {first: second, second: first}.get(number, number)

    for path in folder.glob("annotations/panoptic_*.json"):
        edit_json(path, swap)


@kind("two objects as one segment", "coco_plain")
def _(folder: Path) -> None:
    path = folder / "annotations/panoptic_train.json"
    merged: dict[str, tuple[int, int]] = {}

    def merge(values: dict) -> None:
        one = next(each for each in values["annotations"] if len(each["segments_info"]) > 1)
        kept, gone = one["segments_info"][:2]
        merged[one["file_name"]] = (kept["id"], gone["id"])
        one["segments_info"].remove(gone)

    edit_json(path, merge)
    ((name, (kept, gone)),) = merged.items()
    edit_image(
        folder / "annotations/panoptic_train" / name,
        lambda image: np.where((image[..., :1] == gone) & (image[..., 1:2] == 0), (kept, 0, 0), image).astype(np.uint8),
    )
