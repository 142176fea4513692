"""Kinds of label faults of annotated pictures: plain COCO with keypoints, polygons and segments, Pascal VOC, CVAT."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

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


# Pascal VOC


def edit_text(folder: Path, pattern: str, change: Callable[[str], str]) -> None:
    """Change texts of files."""
    for path in folder.glob(pattern):
        path.write_text(change(path.read_text()))


def _shifted(found: re.Match) -> str:
    return f"{found[1]}{int(found[2]) - 1}{found[3]}"


@kind("boxes counted from 0", "voc")
def _(folder: Path) -> None:
    edit_text(folder, "Annotations/*.xml", lambda text: re.sub(r"(<[xy](?:min|max)>)(\d+)(<)", _shifted, text))


@kind("truncated and occluded swapped", "voc")
def _(folder: Path) -> None:
    edit_text(
        folder,
        "Annotations/*.xml",
        lambda text: text.replace("truncated", "?").replace("occluded", "truncated").replace("?", "occluded"),
    )


@kind("no object is difficult", "voc")
def _(folder: Path) -> None:
    edit_text(
        folder, "Annotations/*.xml", lambda text: text.replace("<difficult>1</difficult>", "<difficult>0</difficult>")
    )


@kind("names of two classes swapped in the XML", "voc")
def _(folder: Path) -> None:
    edit_text(
        folder,
        "Annotations/*.xml",
        lambda text: text.replace(">mug<", ">?<").replace(">can<", ">mug<").replace(">?<", ">can<"),
    )


@kind("stale segments of objects", "voc")
def _(folder: Path) -> None:
    first, second, *_ = sorted(folder.glob("SegmentationObject/Replicator_0*.png")) or sorted(
        folder.glob("SegmentationObject/*.png")
    )
    shutil.copy(first, second)


@kind("indices of classes counted from 0", "voc")
def _(folder: Path) -> None:
    for path in folder.glob("SegmentationClass/*.png"):
        with Image.open(path) as image:
            palette, indices = image.getpalette(), np.array(image)
        made = Image.fromarray(np.where(indices > 0, indices - 1, 0).astype(np.uint8), "P")
        made.putpalette(palette)
        made.save(path)


@kind("segments without a palette", "voc")
def _(folder: Path) -> None:
    for path in folder.glob("SegmentationClass/*.png"):
        with Image.open(path) as image:
            indices = np.array(image)
        Image.fromarray(indices).save(path)


@kind("pictures that are in both parts", "voc")
def _(folder: Path) -> None:
    edit_text(folder, "ImageSets/Main/val.txt", lambda text: text + (folder / "ImageSets/Main/train.txt").read_text())


@kind("lists of classes of others", "voc")
def _(folder: Path) -> None:
    edit_text(folder, "ImageSets/Main/mug_*.txt", lambda text: text.replace(" 1", " -1"))


# CVAT


def _cvat(folder: Path, pattern: str, change: Callable[[re.Match], str]) -> None:
    edit_text(folder, "annotations.xml", lambda text: re.sub(pattern, change, text))


@kind("masks one pixel lower", "cvat")
def _(folder: Path) -> None:
    _cvat(folder, r'top="(\d+)"', lambda found: f'top="{max(int(found[1]) - 1, 0)}"')


@kind("run lengths that begin inside", "cvat")
def _(folder: Path) -> None:
    def turn(found: re.Match) -> str:
        lengths = [int(each) for each in found[1].split(",")]
        return f'rle="{", ".join(map(str, [0, *lengths] if lengths[0] else lengths[1:]))}"'

    _cvat(folder, r'rle="([^"]+)"', turn)


@kind("labels of shapes that the task has not", "cvat")
def _(folder: Path) -> None:
    _cvat(folder, r'label="mug"', lambda found: 'label="cup"')


@kind("occluded flags turned", "cvat")
def _(folder: Path) -> None:
    _cvat(folder, r'occluded="(\d)"', lambda found: f'occluded="{1 - int(found[1])}"')


@kind("instances of the next object", "cvat")
def _(folder: Path) -> None:
    _cvat(folder, r'name="instance">(\d+)<', lambda found: f'name="instance">{int(found[1]) + 1}<')


@kind("shapes of the picture before", "cvat")
def _(folder: Path) -> None:
    names = iter(
        sorted(path.name for path in (folder / "images").iterdir())[-1:]
        + sorted(path.name for path in (folder / "images").iterdir())
    )
    _cvat(folder, r'(<image id="\d+" name=)"[^"]+"', lambda found: f'{found[1]}"{next(names)}"')


@kind("polygons with y before x", "cvat_polygons")
def _(folder: Path) -> None:
    def swap(found: re.Match) -> str:
        return 'points="' + ";".join(",".join(pair.split(",")[::-1]) for pair in found[1].split(";")) + '"'

    _cvat(folder, r'points="([^"]+)"', swap)


@kind("a shape dropped", "cvat_polygons")
def _(folder: Path) -> None:
    edit_text(
        folder, "annotations.xml", lambda text: re.sub(r"    <polygon.*?</polygon>\n", "", text, count=1, flags=re.S)
    )
