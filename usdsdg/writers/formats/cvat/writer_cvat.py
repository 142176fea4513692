"""CvatWriter: pictures with shapes as the annotation tool CVAT imports them."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from functools import partial
from typing import Any, Unpack

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.annotators.class_table import ClassTable
from usdsdg.errors import WriterError
from usdsdg.session.session import current
from usdsdg.writers.aggregate_writer import AggregateWriter
from usdsdg.writers.files import checked_image_format, checked_padding, write_image, write_text
from usdsdg.writers.formats import class_places
from usdsdg.writers.formats.class_names import class_name, class_names
from usdsdg.writers.formats.cvat import cvat_xml, files
from usdsdg.writers.formats.picture_names import stem_of
from usdsdg.writers.formats.shapes.polygons import outlines
from usdsdg.writers.formats.shapes.visible_enough import VisibleEnough, is_hidden_more
from usdsdg.writers.latest import keep_latest
from usdsdg.writers.options import CommonOptions, common_backend, common_labels, typed

RGB, BOXES, INSTANCES = "rgb", "bounding_box_2d_tight_fast", "instance_segmentation_fast"
SHAPES = ("mask", "polygon", "box")


class CvatWriter(AggregateWriter):
    """Writes `images/N.png`, `annotations.xml` ("CVAT for images 1.1") and `labels.json`, the labels of the task.

    To import: create a task with the pictures and, as raw labels, the content of labels.json; then upload
    annotations.xml as "CVAT 1.1". Every visible object is a shape, whose attribute "instance" is its id in
    instance_segmentation.
    """

    version = "0.0.1"
    data_structure = "renderProduct"
    shares_arrays = True
    only_stores_pictures = True

    @typed
    def __init__(
        self,
        output_dir: str | os.PathLike | None = None,
        shape: str = "mask",
        min_visibility: float = 0.0,
        min_pixels: int = 1,
        occluded_threshold: float = 0.05,
        image_output_format: str = "png",
        frame_padding: int = 6,
        **common: Unpack[CommonOptions],
    ) -> None:
        """
        shape: "mask" is exact; "polygon" is an outline for each part, in which holes are filled, with one group for the
            parts of an object; "box" is the rectangle of the visible pixels.
        min_visibility: objects of which less is visible, as a fraction of what they would cover alone, are left out.
        min_pixels: so are objects with fewer visible pixels.
        occluded_threshold: shapes are `occluded` where more than this fraction of their object is hidden by others.
        common: as `CommonOptions`.

        Raises:
            WriterError: two options exclude each other, a value does not exist, or there is nowhere to write.
            OutputNotWritable: output_dir or the bucket cannot be written to.
        """
        if shape not in SHAPES:
            raise WriterError(f"CvatWriter: shape is {shape!r}; expected one of {', '.join(SHAPES)}.")
        labels = common_labels("CvatWriter", common)
        self._shape, self._occluded = shape, occluded_threshold
        self._enough = VisibleEnough("CvatWriter", min_visibility, min_pixels)
        self._image_format, self._padding = checked_image_format(image_output_format), checked_padding(frame_padding)
        self.backend = common_backend("CvatWriter", output_dir, common)
        self.annotators = [
            named_annotators.get(RGB),
            *(named_annotators.get(name, labels) for name in (BOXES, INSTANCES)),
        ]
        self._file = cvat_xml.CvatFile(self.backend, "CvatWriter/task")
        self._frame_id = 0
        self._listed: list[dict[str, Any]] | None = None

    def skip(self, data: dict[str, Any]) -> None:
        self._frame_id += 1

    def write(self, data: dict[str, Any]) -> None:
        several = max(len(self.render_products), len(data["renderProducts"])) > 1
        assert self.backend is not None
        for product, seen in data["renderProducts"].items():
            shapes = self._shapes(seen)
            self._write_labels()
            stem = stem_of(product, self._frame_id, self._padding, several=several)
            path = files.picture(stem, self._image_format)
            # With `schedule_together` the picture is whole before the XML names it.
            self.backend.schedule_together([partial(write_image, path=path, data=seen[RGB]["data"][..., :3])])
            name, size = path.removeprefix(f"{files.PICTURES}/"), [int(each) for each in seen["resolution"]]
            self._file.add(self.num_written, name=name, size=size, shapes=shapes)
        self._frame_id += 1

    def on_final_frame(self) -> None:
        self._file.write()

    def _shapes(self, seen: Mapping[str, Any]) -> list[str]:
        """Return the shapes of the objects of one picture."""
        boxes, instances = seen[BOXES], seen[INSTANCES]["data"]
        self._table().add(boxes["idToLabels"].values())
        found = []
        for row, instance in zip(boxes["data"], boxes["bboxIds"].tolist()):
            left, top, right, bottom = (int(row[side]) for side in ("x_min", "y_min", "x_max", "y_max"))
            pixels = instances[top : bottom + 1, left : right + 1] == instance
            if not self._enough.holds(row, int(pixels.sum())):
                continue
            name = class_name(boxes["idToLabels"][int(row["semanticId"])], files.UNFIT)
            about = {"instance": instance, "occluded": is_hidden_more(row, self._occluded)}
            if self._shape == "box":
                found.append(cvat_xml.box(name, (left, top, right + 1, bottom + 1), **about))
            elif self._shape == "mask":
                found.append(cvat_xml.mask(name, pixels, (left, top), **about))
            else:
                parts, corner = outlines(pixels), np.array((left, top))
                group = instance if len(parts) > 1 else 0
                found += [cvat_xml.polygon(name, part + corner, group=group, **about) for part in parts]
        return found

    def _labels(self) -> list[dict[str, Any]]:
        """Return the classes as labels of a task."""
        attribute = {"name": cvat_xml.INSTANCE, "input_type": "text", "mutable": False, "values": [""]}
        listed = self._table().listed()
        names = class_names("CvatWriter", [row["labels"] for row in listed], files.UNFIT)
        colors = ["#{:02x}{:02x}{:02x}".format(*row["color"][:3]) for row in listed]
        return [{"name": name, "color": color, "attributes": [attribute]} for name, color in zip(names, colors)]

    def _table(self) -> ClassTable:
        return class_places.table_of(self._annotator_called(BOXES).label_filter)

    def _write_labels(self) -> None:
        """Write labels.json, again where classes have been added, and tell the XML of them."""
        labels = self._labels()
        self._file.note(labels=[{name: each[name] for name in ("name", "color")} for each in labels])
        if labels == self._listed:
            return
        assert self.backend is not None
        self._listed = labels
        text = json.dumps(labels, indent=1)
        keep_latest(self.backend, files.LABELS, text)
        with current().io_queue.of_all_frames():
            self.backend.schedule_after_all(write_text, path=files.LABELS, text=text)
