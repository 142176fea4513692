"""The annotations of one COCO image: boxes, masks, keypoints, and the segments of the panoptic form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from usdsdg.writers.formats.coco import coco_keypoints
from usdsdg.writers.formats.coco.coco_categories import Category
from usdsdg.writers.formats.keypoint_names import warn_of_shared_names
from usdsdg.writers.formats.shapes import run_length
from usdsdg.writers.formats.shapes.polygons import outlines
from usdsdg.writers.formats.shapes.visible_enough import VisibleEnough

RGB, BOXES, CLASSES = "rgb", "bounding_box_2d_tight_fast", "semantic_segmentation"
INSTANCES, KEYPOINTS = "instance_segmentation_fast", "keypoints"


@dataclass(frozen=True)
class Thing:
    """A visible object."""

    instance: int
    category: Category
    box: tuple[int, int, int, int]  # x, y, width, height [pixels]
    area: int  # visible pixels
    lengths: np.ndarray  # run lengths of its mask, down the columns


def things(seen: Mapping[str, Any], categories: Any, enough: VisibleEnough) -> list[Thing]:
    """Return the objects of one image that are visible enough, in the order of the boxes."""
    boxes, runs = seen[BOXES], run_length.runs_of_ids(seen[INSTANCES]["data"])
    found = []
    for row, instance in zip(boxes["data"], boxes["bboxIds"].tolist()):
        category = categories.of(boxes["idToLabels"][int(row["semanticId"])])
        lengths = runs[instance]
        area = int(lengths[1::2].sum())
        if enough.holds(row, area):
            x, y = int(row["x_min"]), int(row["y_min"])
            # The annotator's x_max and y_max are inclusive.
            box = (x, y, int(row["x_max"]) + 1 - x, int(row["y_max"]) + 1 - y)
            found.append(Thing(instance, category, box, area, lengths))
    return found


def run_lengths(thing: Thing, shape: tuple[int, int]) -> dict[str, Any]:
    """Return a mask as compressed run lengths. shape: height and width of the image."""
    return {"size": list(shape), "counts": run_length.encoded(thing.lengths)}


def polygons(thing: Thing, instances: np.ndarray) -> list[list[float]]:
    """Return the outlines of a mask's parts, each x, y, x, y, ... along the edges of pixels; holes are filled."""
    x, y, width, height = thing.box
    parts = outlines(instances[y : y + height, x : x + width] == thing.instance)
    corner = np.array((x, y))
    return [(part + corner).ravel().tolist() for part in parts]


def keypoints(seen: Mapping[str, Any], own: Sequence[Thing], table: coco_keypoints.Keypoints) -> list[dict[str, Any]]:
    """Return what the keypoints of each object add to its annotation."""
    warn_of_shared_names("CocoWriter", seen[KEYPOINTS])
    rows = coco_keypoints.rows(seen[KEYPOINTS])
    return [table.numbers(each.category, rows.get(each.instance, {})) for each in own]


def segments(instances: np.ndarray, own: Sequence[Thing]) -> tuple[np.ndarray, list[dict[str, Any]]]:
    """Return the panoptic picture, uint8 (H, W, 3), and the record of each segment.

    Each object is a segment whose id is its instance id; all of a category of stuff are one, with the smallest of
    theirs. Pixels of no segment are black. A pixel's id is R + 256 G + 256² B.
    """
    groups: dict[int, list[Thing]] = {}
    first: dict[int, int] = {}  # id of the segment of a category of stuff
    for each in sorted(own, key=lambda thing: thing.instance):
        is_thing = bool(each.category.get("isthing", 1))
        number = each.instance if is_thing else first.setdefault(each.category["id"], each.instance)
        groups.setdefault(number, []).append(each)
    palette = np.zeros(int(instances.max(initial=0)) + 1, np.int64)
    records = []
    for number, members in groups.items():
        palette[[each.instance for each in members]] = number
        records.append(
            {
                "id": number,
                "category_id": members[0].category["id"],
                "iscrowd": 0,
                "bbox": _around([each.box for each in members]),
                "area": sum(each.area for each in members),
            }
        )
    ids = palette[instances]
    return np.stack([ids & 255, ids >> 8 & 255, ids >> 16 & 255], axis=-1).astype(np.uint8), records


def _around(boxes: Sequence[tuple[int, int, int, int]]) -> list[int]:
    """Return the box around several."""
    x, y = min(box[0] for box in boxes), min(box[1] for box in boxes)
    return [x, y, max(box[0] + box[2] for box in boxes) - x, max(box[1] + box[3] for box in boxes) - y]
