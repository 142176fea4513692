"""YoloWriter: pictures with one text file each, as Ultralytics' trainers read them."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, Unpack

import numpy as np
import yaml

from usdsdg.annotators import named_annotators
from usdsdg.annotators.annotator import Annotator
from usdsdg.errors import WriterError
from usdsdg.session.session import current
from usdsdg.writers.base import Writer
from usdsdg.writers.files import checked_image_format, checked_padding, write_image, write_text
from usdsdg.writers.formats import class_places
from usdsdg.writers.formats.keypoint_names import warn_of_shared_names
from usdsdg.writers.formats.picture_names import stem_of
from usdsdg.writers.formats.shapes.polygons import joined, outlines, without_holes
from usdsdg.writers.formats.shapes.visible_enough import VisibleEnough
from usdsdg.writers.formats.splits import Splits
from usdsdg.writers.formats.yolo import yolo_files as files
from usdsdg.writers.formats.yolo.oriented import fitted
from usdsdg.writers.latest import keep_latest
from usdsdg.writers.options import CommonOptions, common_backend, common_labels, typed

RGB, BOXES, INSTANCES = "rgb", "bounding_box_2d_tight_fast", "instance_segmentation_fast"
OBB, KEYPOINTS = "oriented_bounding_box_2d", "keypoints"
TASKS = ("detect", "segment", "obb", "pose")
DIGITS = 6  # of coordinates, which are fractions of the picture: a thousandth of a pixel


class YoloWriter(Writer):
    """Writes `images/<split>/N.png`, `labels/<split>/N.txt` and `data.yaml`.

    A line for each visible object: the number of its class, then for "detect" the center, width and height of its
    tight box, for "segment" the corners of its outline, for "obb" those of its oriented box, for "pose" the box and
    column, row and visibility (0 outside of the picture, 1 hidden, 2 visible) of each keypoint, all as fractions of the
    picture. A picture without objects has an empty file. Classes count from 0 in the order of the class table, which
    `data.yaml` names. A polygon has no holes; that of an object in several pieces joins them by lines without width.
    """

    version = "0.0.1"
    data_structure = "renderProduct"
    shares_arrays = True
    only_stores_pictures = True
    kept = ("_frame_id", "_keypoints")

    @typed
    def __init__(
        self,
        output_dir: str | os.PathLike | None = None,
        task: str = "detect",
        keypoints: list[str] | None = None,
        splits: dict | None = None,
        frames_per_scene: int = 1,
        min_visibility: float = 0.0,
        min_pixels: int = 1,
        image_output_format: str = "png",
        frame_padding: int = 6,
        **common: Unpack[CommonOptions],
    ) -> None:
        """
        task: "detect" (boxes), "segment" (outlines), "obb" (oriented boxes) or "pose" (keypoints).
        keypoints: names of the keypoints of "pose" in their order; default those of the first frame, sorted.
        splits: relative sizes of the parts of the dataset, such as {"train": 0.8, "val": 0.2}; default all "train".
        frames_per_scene: so many frames in a row are in the same part.
        min_visibility: objects of which less is visible, as a fraction of what they would cover alone, are left out.
        min_pixels: so are objects with fewer visible pixels.
        image_output_format, frame_padding: format of the pictures, and digits of a frame's number.
        common: as `CommonOptions`.

        Raises:
            WriterError: two options exclude each other, a value does not exist, or there is nowhere to write.
            OutputNotWritable: output_dir or the bucket cannot be written to.
        """
        if task not in TASKS:
            raise WriterError(f"YoloWriter: task is {task!r}; expected one of {', '.join(TASKS)}.")
        labels = common_labels("YoloWriter", common)
        self._task, self._splits = task, Splits("YoloWriter", splits, frames_per_scene)
        self._enough = VisibleEnough("YoloWriter", min_visibility, min_pixels)
        self._image_format, self._padding = checked_image_format(image_output_format), checked_padding(frame_padding)
        self.backend = common_backend("YoloWriter", output_dir, common)
        more = {"obb": (OBB,), "pose": (KEYPOINTS,)}.get(task, ())
        self.annotators = [
            named_annotators.get(RGB),
            *(named_annotators.get(name, labels) for name in (BOXES, INSTANCES, *more)),
        ]
        self._keypoints = keypoints
        self._listed: list[str] | None = None  # in data.yaml, once that is written
        self._frame_id = 0

    def annotators_to_skip(self) -> list[Annotator]:
        # Of the first frame, whose keypoints are those of all frames.
        return [self._annotator_called(KEYPOINTS)] if self._task == "pose" and self._keypoints is None else []

    def skip(self, data: dict[str, Any]) -> None:
        for seen in data["renderProducts"].values():
            if KEYPOINTS in seen:
                self._find_keypoints(seen)
        self._frame_id += 1

    def write(self, data: dict[str, Any]) -> None:
        several = max(len(self.render_products), len(data["renderProducts"])) > 1
        split = self._splits.of(self._frame_id)
        for product, seen in data["renderProducts"].items():
            stem = stem_of(product, self._frame_id, self._padding, several=several)
            image = files.image_of(split, stem, self._image_format)
            text = "".join(f"{line}\n" for line in self._lines(seen))
            assert self.backend is not None
            self.backend.schedule_together(
                [
                    partial(write_image, path=image, data=seen[RGB]["data"][..., :3]),
                    partial(write_text, path=files.labels_of(split, stem), text=text),
                ]
            )
        self._write_description()
        self._frame_id += 1

    def _write_description(self) -> None:
        """Write data.yaml, again where classes have been added."""
        names = class_places.names(self._table())
        if names == self._listed:
            return
        assert self.backend is not None
        self._listed = names
        described: dict[str, Any] = {split: f"{files.IMAGES}/{split}" for split in self._splits.names}
        # Ultralytics asks for both of these.
        described |= {each: described[self._splits.names[0]] for each in ("train", "val") if each not in described}
        if self._task == "pose":
            described["kpt_shape"] = [len(self._keypoints or ()), 3]
        described["names"] = dict(enumerate(names))
        text = yaml.safe_dump(described, sort_keys=False)
        keep_latest(self.backend, files.DESCRIPTION, text)
        # In turn, since it replaces the earlier file.
        with current().io_queue.of_all_frames():
            self.backend.schedule_in_turn(files.DESCRIPTION, write_text, path=files.DESCRIPTION, text=text)

    def _table(self) -> Any:
        return class_places.table_of(self._annotator_called(BOXES).label_filter)

    def _lines(self, seen: Mapping[str, Any]) -> list[str]:
        boxes, objects = seen[BOXES], seen[INSTANCES]["data"]
        height, width = objects.shape
        kinds = [boxes["idToLabels"][int(row["semanticId"])] for row in boxes["data"]]
        classes = class_places.places(self._table(), kinds)
        pixels = np.bincount(objects.ravel(), minlength=int(max(boxes["bboxIds"], default=0)) + 1)
        outlines_of = {"detect": self._box, "pose": self._box, "obb": self._oriented, "segment": self._outline}
        outline = outlines_of[self._task]
        points = self._points(seen) if self._task == "pose" else None
        lines = []
        for row, instance, number in zip(boxes["data"], boxes["bboxIds"], classes.tolist()):
            if not self._enough.holds(row, int(pixels[instance])):
                continue
            fractions = np.asarray(outline(seen, row, int(instance)), float) / (width, height)
            lines.append(f"{number} {_text(fractions)}")
            if points is not None:
                lines[-1] += "".join(
                    f" {_text(np.array(pixel) / (width, height))} {seen_as}"
                    for *pixel, seen_as in points[int(instance)]
                )
        return lines

    def _points(self, seen: Mapping[str, Any]) -> dict[int, list[tuple[float, float, int]]]:
        """Return column, row [pixels] and visibility of each keypoint of each object, by instance id.

        Raises:
            WriterError: there is a keypoint that the first frame had not.
        """
        found, names = seen[KEYPOINTS]["data"], seen[KEYPOINTS]["keypointNames"]
        place = {name: index for index, name in enumerate(self._find_keypoints(seen))}
        if missing := [name for name in names if name not in place]:
            raise WriterError(
                f"YoloWriter: the keypoints {', '.join(missing)} are new, and YOLO has as many in all frames. Name all "
                "in the writer's option keypoints."
            )
        warn_of_shared_names("YoloWriter", seen[KEYPOINTS])
        blank = [(0.0, 0.0, 0)] * len(place)
        points = {int(instance): list(blank) for instance in seen[BOXES]["bboxIds"]}
        for row in found:
            if row["visibility"] and int(row["instanceId"]) in points:
                which = place[names[int(row["keypointId"])]]
                points[int(row["instanceId"])][which] = (float(row["x"]), float(row["y"]), int(row["visibility"]))
        return points

    def _find_keypoints(self, seen: Mapping[str, Any]) -> list[str]:
        """Return the names of all keypoints: those that are given, or of the first picture."""
        if self._keypoints is None:
            self._keypoints = list(seen[KEYPOINTS]["keypointNames"])
        return self._keypoints

    def _oriented(self, seen: Mapping[str, Any], row: Any, instance: int) -> np.ndarray:
        """Return the corners of the oriented box [pixels], as `fitted` has them."""
        height, width = seen[INSTANCES]["data"].shape
        corners = seen[OBB]["data"]["corners"][np.flatnonzero(np.asarray(seen[OBB]["bboxIds"]) == instance)[0]]
        return fitted(corners, (width, height))

    def _box(self, seen: Mapping[str, Any], row: Any, instance: int) -> Sequence[tuple[float, float]]:
        """Return center and size [pixels]; the annotator's x_max and y_max are inclusive."""
        x0, y0, x1, y1 = (int(row[name]) for name in ("x_min", "y_min", "x_max", "y_max"))
        return ((x0 + x1 + 1) / 2.0, (y0 + y1 + 1) / 2.0), (x1 + 1 - x0, y1 + 1 - y0)

    def _outline(self, seen: Mapping[str, Any], row: Any, instance: int) -> np.ndarray:
        """Return the corners of the mask's outline [pixels]."""
        x, y = int(row["x_min"]), int(row["y_min"])
        objects = seen[INSTANCES]["data"][y : int(row["y_max"]) + 1, x : int(row["x_max"]) + 1]
        # What is inside of a hole is in the outline around it already, which has no holes.
        return joined(outlines(without_holes(objects == instance))) + np.array((x, y))


def _text(fractions: np.ndarray) -> str:
    return " ".join(f"{value:.{DIGITS}f}".rstrip("0").rstrip(".") or "0" for value in fractions.ravel().tolist())
