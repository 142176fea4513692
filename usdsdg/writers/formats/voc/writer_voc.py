"""VocWriter: pictures with boxes and segments, as Pascal VOC's development kit has them."""

from __future__ import annotations

import itertools
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, Unpack

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.annotators.class_table import ClassTable
from usdsdg.errors import WriterError, warn_once
from usdsdg.image_files.png import encode_png
from usdsdg.session.session import current
from usdsdg.writers.aggregate_writer import AggregateWriter
from usdsdg.writers.files import checked_image_format, checked_padding, write_bytes, write_image, write_text
from usdsdg.writers.formats import class_places
from usdsdg.writers.formats.class_names import class_name, class_names
from usdsdg.writers.formats.picture_names import stem_of
from usdsdg.writers.formats.shapes import cuboid
from usdsdg.writers.formats.shapes.camera_projection import project
from usdsdg.writers.formats.shapes.pose import Pose, truncation_ratio
from usdsdg.writers.formats.shapes.visible_enough import VisibleEnough, is_hidden_more
from usdsdg.writers.formats.splits import Splits
from usdsdg.writers.formats.voc import files
from usdsdg.writers.formats.voc.image_sets import ImageSets, shown
from usdsdg.writers.formats.voc.voc_xml import VocObject, text
from usdsdg.writers.latest import keep_latest
from usdsdg.writers.options import CommonOptions, common_backend, common_labels, typed

RGB, BOXES, INSTANCES = "rgb", "bounding_box_2d_tight_fast", "instance_segmentation_fast"
BOXES_3D, CAMERA = "bounding_box_3d_fast", "camera_params"


class VocWriter(AggregateWriter):
    """Writes `JPEGImages/N.jpg`, `Annotations/N.xml`, `SegmentationClass/N.png` and `SegmentationObject/N.png`.

    Lists of pictures are `ImageSets/Main/<split>.txt`, `ImageSets/Main/<class>_<split>.txt` and
    `ImageSets/Segmentation/<split>.txt`.

    Every visible object is in the XML, with the box of its visible pixels, counted from 1 and inclusive. Names of
    classes have "_" for what lists and names of files cannot have. Segments are
    indices with VOC's colors: of the class, from 1 in the order of the class table, which `labelmap.txt` names; and of
    the object, from 1 in the order of the XML. 0 is what has no label.
    """

    version = "0.0.1"
    data_structure = "renderProduct"
    shares_arrays = True
    only_stores_pictures = True

    @typed
    def __init__(
        self,
        output_dir: str | os.PathLike | None = None,
        splits: dict | None = None,
        frames_per_scene: int = 1,
        min_visibility: float = 0.0,
        min_pixels: int = 1,
        truncated_threshold: float = 0.15,
        occluded_threshold: float = 0.05,
        image_output_format: str = "jpg",
        frame_padding: int = 6,
        **common: Unpack[CommonOptions],
    ) -> None:
        """
        splits: relative sizes of the parts of the dataset, such as {"train": 0.8, "val": 0.2}; default all "train".
        frames_per_scene: so many frames in a row are in the same part.
        min_visibility: objects of which less is visible, as a fraction of what they would cover alone, are `difficult`,
            which VOC's evaluation leaves out.
        min_pixels: so are objects with fewer visible pixels.
        truncated_threshold: objects are `truncated` where more than this fraction of the rectangle around their 3D box
            is outside of the picture.
        occluded_threshold: objects are `occluded` where more than this fraction is hidden by others.
        image_output_format: "jpg", which readers of VOC expect, or "png", which is without loss.
        common: as `CommonOptions`.

        Raises:
            WriterError: two options exclude each other, a value does not exist, or there is nowhere to write.
            OutputNotWritable: output_dir or the bucket cannot be written to.
        """
        labels = common_labels("VocWriter", common)
        self._splits = Splits("VocWriter", splits, frames_per_scene)
        self._enough = VisibleEnough("VocWriter", min_visibility, min_pixels)
        self._truncated, self._occluded = truncated_threshold, occluded_threshold
        self._image_format, self._padding = checked_image_format(image_output_format), checked_padding(frame_padding)
        self.backend = common_backend("VocWriter", output_dir, common)
        self.annotators = [
            *(named_annotators.get(name) for name in (RGB, CAMERA)),
            *(named_annotators.get(name, labels) for name in (BOXES, INSTANCES, BOXES_3D)),
        ]
        self._frame_id = 0
        self._sets = {split: ImageSets(self.backend, f"VocWriter/{split}") for split in self._splits.names}
        self._listed: list[str] | None = None

    def skip(self, data: dict[str, Any]) -> None:
        self._frame_id += 1

    def write(self, data: dict[str, Any]) -> None:
        several = max(len(self.render_products), len(data["renderProducts"])) > 1
        split = self._splits.of(self._frame_id)
        for product, seen in data["renderProducts"].items():
            stem = stem_of(product, self._frame_id, self._padding, several=several)
            objects = self._objects(seen)
            self._write_picture(stem, seen, objects)
            self._write_labels()
            self._sets[split].add(self.num_written, stem=stem, shown=shown(objects))
        self._frame_id += 1

    def on_final_frame(self) -> None:
        for sets in self._sets.values():
            sets.write()

    def _objects(self, seen: Mapping[str, Any]) -> list[VocObject]:
        boxes, camera = seen[BOXES], seen[CAMERA]
        solids = dict(zip(seen[BOXES_3D]["bboxIds"].tolist(), seen[BOXES_3D]["data"]))
        pixels = np.bincount(seen[INSTANCES]["data"].ravel(), minlength=int(max(boxes["bboxIds"], default=0)) + 1)
        self._table().add(boxes["idToLabels"].values())
        found = []
        for row, instance in zip(boxes["data"], boxes["bboxIds"].tolist()):
            pose = Pose(solids[instance], camera, cuboid.CORNERS)
            corners = project(np.array(list(pose.in_camera.values())), camera)
            found.append(
                VocObject(
                    instance,
                    class_name(boxes["idToLabels"][int(row["semanticId"])], files.UNFIT),
                    tuple(int(row[side]) + 1 for side in ("x_min", "y_min", "x_max", "y_max")),  # type: ignore[arg-type]
                    truncation_ratio(pose, corners, camera) > self._truncated,
                    is_hidden_more(row, self._occluded),
                    not self._enough.holds(row, int(pixels[instance])),
                )
            )
        return found

    def _write_picture(self, stem: str, seen: Mapping[str, Any], objects: Sequence[VocObject]) -> None:
        classes, own = self._segments(seen[INSTANCES]["data"], objects)
        picture = files.picture(stem, self._image_format)
        width, height = (int(size) for size in seen["resolution"])
        description = text("VOC", picture.rsplit("/", 1)[-1], (width, height), objects)
        assert self.backend is not None
        self.backend.schedule_together(
            [
                partial(write_image, path=picture, data=seen[RGB]["data"][..., :3]),
                partial(_write_indices, path=files.segments(files.CLASSES, stem), image=classes),
                partial(_write_indices, path=files.segments(files.OBJECTS, stem), image=own),
                partial(write_text, path=files.annotation(stem), text=description),
            ]
        )

    def _segments(self, instances: np.ndarray, objects: Sequence[VocObject]) -> tuple[np.ndarray, np.ndarray]:
        """Return the index of the class and of the object of each pixel, uint8 (H, W)."""
        names = self._classes()
        if len(names) >= files.VOID:
            raise WriterError(f"VocWriter: {len(names)} classes; pictures of VOC's segments have at most 254.")
        if len(objects) >= files.VOID:
            warn_once("VocWriter: more than 254 objects in a picture: the rest are void in SegmentationObject.")
        palette = np.zeros((int(instances.max(initial=0)) + 1, 2), np.uint8)
        for index, each in enumerate(objects, 1):
            palette[each.instance] = names.index(each.name) + 1, min(index, files.VOID)
        return palette[instances, 0], palette[instances, 1]

    def _classes(self) -> list[str]:
        """Return the names of the classes in the order of their ids.

        Raises:
            WriterError: two would be the same, as would be lists of pictures, or one is too long for a file's name.
        """
        names = class_names("VocWriter", list(self._table().labels().values()), files.UNFIT)
        lists = Counter(files.image_set(files.MAIN, split, name) for split in self._sets for name in ["", *names])
        if twice := [path for path, count in lists.items() if count > 1]:
            raise WriterError(
                f"VocWriter: {twice[0]} would be the list of two: of a part, or of a class in a part. Rename the part."
            )
        for split, name in itertools.product(self._sets, names):
            length = len(os.path.basename(files.image_set(files.MAIN, split, name)).encode())
            if length > files.LONGEST:
                raise WriterError(
                    f"VocWriter: the name of the class {name[:40]!r}... is too long: the list of its pictures would "
                    f"have a name of {length} bytes, "
                    f"and names of files have at most {files.LONGEST}. Shorten its label."
                )
        return names

    def _table(self) -> ClassTable:
        return class_places.table_of(self._annotator_called(BOXES).label_filter)

    def _write_labels(self) -> None:
        """Write labelmap.txt, again where classes have been added, and tell the lists of pictures of them."""
        names = self._classes()
        for split, sets in self._sets.items():
            sets.note(split=split, classes=names)
        if names == self._listed:
            return
        assert self.backend is not None
        self._listed = names
        colors = files.palette().tolist()
        rows = [
            f"{name}:{','.join(map(str, colors[index]))}::\n" for index, name in enumerate([files.BACKGROUND, *names])
        ]
        text = "# label:color_rgb:parts:actions\n" + "".join(rows)
        keep_latest(self.backend, files.LABELS, text)
        with current().io_queue.of_all_frames():
            self.backend.schedule_after_all(write_text, path=files.LABELS, text=text)


def _write_indices(path: str, image: np.ndarray, backend_instance: Any = None) -> None:
    write_bytes(path, encode_png(image, files.palette()), backend_instance)
