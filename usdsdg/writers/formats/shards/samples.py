"""Samples: a picture with its labels, as WebDataset and Parquet have them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.annotators.annotator import Annotator
from usdsdg.errors import WriterError
from usdsdg.writers.formats import class_places
from usdsdg.writers.formats.shapes.visible_enough import ROUNDING, check_limits
from usdsdg.writers.formats.shards.shard_files import DEPTH, IMAGE, INSTANCES

RGB, BOXES, IDS, DEPTHS = (
    "rgb", "bounding_box_2d_tight_fast", "instance_segmentation_fast", "distance_to_image_plane",
)  # fmt: skip
_MOST_OBJECTS = 0xFFFF


@dataclass
class Sample:
    """One picture: `facts` has what identifies it, `objects` a record of each object, `arrays` the picture and more.

    `classes` has the names of the classes that were known then, in the order of their numbers.
    """

    facts: dict[str, Any]
    objects: list[dict[str, Any]]
    classes: list[str]
    arrays: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """Its name, which no other sample of the dataset has."""
        return self.facts["key"]


@dataclass(frozen=True)
class SampleOptions:
    """What samples have.

    masks: also an image of the ids of objects. depth: also distances along the optical axis [m].
    min_visibility: objects of which less is visible, as a fraction, are left out. min_pixels: so are smaller ones.
    """

    masks: bool
    depth: bool
    min_visibility: float
    min_pixels: int

    def checked(self, writer: str) -> SampleOptions:
        """Return them.

        Raises:
            WriterError: a value cannot be.
        """
        check_limits(writer, self.min_visibility, self.min_pixels)
        return self

    def annotators(self, labels: Mapping[str, Any]) -> list[Annotator]:
        """Return the annotators that samples are made of."""
        more = [named_annotators.get(DEPTHS)] if self.depth else []
        return [named_annotators.get(RGB), *(named_annotators.get(name, labels) for name in (BOXES, IDS)), *more]


def sample(key: str, frame: int, view: str, seen: Mapping[str, Any], table: Any, options: SampleOptions) -> Sample:
    """Return the sample of one render product's annotations.

    An object has the numbers `id` (from 1 in each picture, as in the image of ids), `category` (the place of its class
    in the class table, from 0), `bbox` (x, y, width, height [pixels] of what is visible), `area` (visible pixels) and
    `visibility` (1 - occlusionRatio; 1 where that is not known), and the texts `label` and `path` (of the prim).
    """
    boxes, ids = seen[BOXES], seen[IDS]["data"]
    height, width = ids.shape
    kinds = [boxes["idToLabels"][int(row["semanticId"])] for row in boxes["data"]]
    pixels = np.bincount(ids.ravel(), minlength=int(max(boxes["bboxIds"], default=0)) + 1)
    numbers = np.zeros(max(len(pixels), 1), np.uint16)
    objects: list[dict[str, Any]] = []
    for row, instance, place, labels, path in zip(
        boxes["data"], boxes["bboxIds"], class_places.places(table, kinds).tolist(), kinds, boxes["primPaths"]
    ):
        hidden = float(row["occlusionRatio"])
        visible = 1.0 - hidden if np.isfinite(hidden) else 1.0
        area = int(pixels[instance])
        if area < options.min_pixels or visible < options.min_visibility - ROUNDING:
            continue
        if len(objects) == _MOST_OBJECTS:
            raise WriterError(f"{key} has more than {_MOST_OBJECTS} objects, which 16-bit ids cannot tell apart.")
        x, y, right, bottom = (int(row[name]) for name in ("x_min", "y_min", "x_max", "y_max"))
        numbers[instance] = len(objects) + 1
        objects.append(
            {
                "id": len(objects) + 1,
                "category": place,
                "label": ",".join(labels.values()),
                "bbox": [float(x), float(y), float(right + 1 - x), float(bottom + 1 - y)],
                "area": area,
                "visibility": round(visible, 6),
                "path": str(path),
            }
        )
    facts = {"key": key, "frame": frame, "view": view, "width": width, "height": height}
    made = Sample(facts, objects, class_places.names(table), {IMAGE: seen[RGB]["data"][..., :3]})
    if options.masks:
        made.arrays[INSTANCES] = numbers[ids]
    if options.depth:
        made.arrays[DEPTH] = seen[DEPTHS]["data"].astype(np.float32)
    return made
