"""CocoWriter: images, and one JSON of boxes, masks and categories in COCO's format."""

import hashlib
import os
import re
import string
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.errors import WriterError, warn_once
from usdsdg.session.session import current
from usdsdg.writers import base
from usdsdg.writers.backends.group import BackendDispatch
from usdsdg.writers.base import Writer
from usdsdg.writers.files import checked_image_format, checked_padding, write_image
from usdsdg.writers.formats.coco.coco_categories import Categories
from usdsdg.writers.formats.coco.coco_file import CocoFile
from usdsdg.writers.formats.shapes import run_length
from usdsdg.writers.options import typed

RGB, BOXES = "rgb", "bounding_box_2d_tight_fast"
CLASSES, INSTANCES = "semantic_segmentation", "instance_segmentation_fast"
_SEMANTIC_TYPES = ["class", "coco", "stuff", "thing"]
_ID_LENGTH = 8
_ALWAYS = "images, boxes and masks of labeled objects are always written, and nothing else"
_XYWH_ABSOLUTE = 1  # value of `bbox_mode` for x, y, width and height in pixels


class CocoWriter(Writer):
    """Writes `<product>/rgb_<camera>_<id>.NNNN.png`, next to it `panoptic_...` with each pixel in the color of its
    category, and `coco_annotations_<id>.json` of all images (cocodataset.org, "object detection").

    Every visible object is an annotation: a box [x, y, width, height] in pixels, its mask as compressed RLE, and the
    number of mask pixels as its area. The JSON is complete at any time and only lists images that exist; it is
    rewritten from time to time, at the end of a run, and when the program ends.

    An existing output_dir is not modified: a new folder next to it, with _0001 (and so on) appended, is written to.
    """

    version = "0.0.1"
    data_structure = "renderProduct"
    shares_arrays = True

    @typed
    def __init__(
        self,
        output_dir: str | os.PathLike,
        semantic_types: list[str] | None = None,
        coco_categories: dict | None = None,
        s3_bucket: str | None = None,
        s3_region: str | None = None,
        s3_endpoint: str | None = None,
        dataset_id: str | None = None,
        frame_padding: int = 4,
        image_output_format: str = "png",
        coco_license_info: list[dict] | None = None,
        *,
        rgb: bool = True,
        bounding_box_2d_tight: bool = True,
        semantic_segmentation: bool = True,
        instance_segmentation: bool = True,
        instance_id_segmentation: bool = False,
        colorize_semantic_segmentation: bool = True,
        colorize_instance_segmentation: bool = True,
        colorize_instance_id_segmentation: bool = True,
    ) -> None:
        """
        semantic_types: types of labels to use; default class, coco, stuff and thing.
        coco_categories: by label {"name", "id"} and optionally "supercategory", "color" (r, g, b), "isthing"; default
            `semantic_classes` where these are set, else COCO's own. All of them are in the file. Other labels get the
            category "other" with a warning, or where there is no "other" are left out.
        s3_bucket, s3_region, s3_endpoint: write to a bucket, below `output_dir` as a prefix; see `S3Backend`.
        dataset_id: part of the file names, so without slashes; default eight letters that depend on the global seed.
        image_output_format: of the color images; those of categories are always png, which is lossless.
        coco_license_info: [{"id", "name", "url"}]; the first one's id is each picture's license.
        rgb, bounding_box_2d_tight, semantic_segmentation, instance_segmentation, instance_id_segmentation: options of
            BasicWriter, which scripts pass on. They change nothing: images, boxes and masks are always written, ids of
            gprims never. One that asks for something else warns.
        colorize_semantic_segmentation, colorize_instance_segmentation, colorize_instance_id_segmentation: ignored.

        Raises:
            WriterError: an option has an invalid value, or two categories have the same id.
            OutputNotWritable: output_dir or the bucket cannot be written to.
            Unsupported: a bucket without boto3.
        """
        if dataset_id is not None and not re.fullmatch(r"[^/\\\0]{1,100}", dataset_id):
            raise WriterError(f"dataset_id is {dataset_id!r}; expected 1 to 100 characters of a file name, no slashes.")
        asked = {
            "rgb": (rgb, True),
            "bounding_box_2d_tight": (bounding_box_2d_tight, True),
            "semantic_segmentation": (semantic_segmentation, True),
            "instance_segmentation": (instance_segmentation, True),
            "instance_id_segmentation": (instance_id_segmentation, False),
        }
        for name, (value, fixed) in asked.items():
            if bool(value) is not fixed:
                warn_once(f"CocoWriter: {name}={value!r} has no effect: {_ALWAYS}.")
        self._categories = Categories(coco_categories)
        self._image_format = checked_image_format(image_output_format)
        self._padding = checked_padding(frame_padding)
        self._licenses = coco_license_info or []
        self.backend = BackendDispatch(
            output_dir=output_dir, bucket=s3_bucket, region=s3_region, endpoint_url=s3_endpoint, overwrite=False
        )
        self.dataset_id = dataset_id
        self._sequence, self._frame_id = "", 0
        head = {"info": _info(self.version), "licenses": self._licenses}
        self._file = CocoFile(self.backend, head, self._categories.all())
        # Also if a script ends or is interrupted before its run is complete.
        current().io_queue.call_at_exit(self._file.write)
        types = {"semanticTypes": semantic_types or _SEMANTIC_TYPES}
        self.annotators = [
            named_annotators.get(RGB),
            *(named_annotators.get(name, types) for name in (BOXES, CLASSES, INSTANCES)),
        ]

    def write(self, data: dict[str, Any]) -> None:
        self.dataset_id = self.dataset_id or _id_of_seed(base.global_seed())
        self._file.path = f"coco_annotations_{self.dataset_id}.json"
        sequence = _sequence(data.get("trigger_outputs") or {})
        if sequence != self._sequence:
            self._sequence, self._frame_id = sequence, 0
        for product, seen in data["renderProducts"].items():
            self._write_product(product, seen)
        self._frame_id += 1

    def on_final_frame(self) -> None:
        self._file.write()

    def detach(self) -> None:
        super().detach()
        if self.backend is not None:
            self.on_final_frame()

    def _write_product(self, product: str, seen: Mapping[str, Any]) -> None:
        camera = seen["camera"][1:].replace("Replicator/", "").replace("/", "-").replace("_", "-")
        stem = f"{camera}_{self.dataset_id}.{self._sequence}{self._frame_id:0{self._padding}d}"
        file_name = f"{product}/rgb_{stem}.{self._image_format}"
        assert self.backend is not None
        self.backend.schedule_together(
            [
                partial(write_image, path=file_name, data=seen[RGB]["data"][..., :3]),
                partial(write_image, path=f"{product}/panoptic_{stem}.png", data=self._colored(seen[CLASSES])),
            ]
        )
        width, height = (int(size) for size in seen["resolution"])
        image = {
            "file_name": file_name,
            "id": self._file.next_image_id(),
            "height": height,
            "width": width,
            "license": self._licenses[0].get("id", 0) if self._licenses else 0,
            "date_captured": "",
            "flicker_url": "",  # the spelling is Replicator's
        }
        self._file.add(image, self._annotations(seen, image))

    def _annotations(self, seen: Mapping[str, Any], image: Mapping[str, Any]) -> list[dict[str, Any]]:
        """Return the annotation records of one image, of the objects that have a category."""
        boxes, runs = seen[BOXES], run_length.runs_of_ids(seen[INSTANCES]["data"])
        first, records = self._file.next_annotation_id(), []
        for row, instance in zip(boxes["data"], boxes["bboxIds"]):
            category = self._categories.of(boxes["idToLabels"][int(row["semanticId"])])
            if category is None:
                continue
            lengths = runs[int(instance)]
            x, y = int(row["x_min"]), int(row["y_min"])
            records.append(
                {
                    "id": first + len(records),
                    "image_id": image["id"],
                    # The annotator's x_max and y_max are inclusive.
                    "bbox": [x, y, int(row["x_max"]) + 1 - x, int(row["y_max"]) + 1 - y],
                    "area": float(lengths[1::2].sum()),
                    "bbox_mode": _XYWH_ABSOLUTE,
                    "category_id": category["id"],
                    "iscrowd": 0,
                    "segmentation": {"size": [image["height"], image["width"]], "counts": run_length.encoded(lengths)},
                }
            )
        return records

    def _colored(self, classes: Mapping[str, Any]) -> np.ndarray:
        """Return the panoptic image, uint8 (H, W, 3): each pixel in the color of its category."""
        ids = classes["data"]
        palette = np.zeros((max(map(int, classes["idToLabels"])) + 1, 3), np.uint8)
        for number, labels in classes["idToLabels"].items():
            palette[int(number)] = self._categories.color(labels)
        return palette[ids]


def _info(version: str) -> dict[str, Any]:
    """Return the info section, without a date, so that a repeated run writes the same bytes."""
    return {
        "description": "COCO dataset made with usdsdg",
        "url": "https://cocodataset.org",
        "version": version,
        "date_created": "",
        "contributor": "",
    }


def _id_of_seed(seed: int | None) -> str:
    """Return eight letters that depend on the seed only."""
    digest = hashlib.blake2b(str(seed).encode(), digest_size=_ID_LENGTH).digest()
    return "".join(string.ascii_lowercase[byte % len(string.ascii_lowercase)] for byte in digest)


def _sequence(trigger_outputs: Mapping[str, Any]) -> str:
    """Return the part of Replicator's image names that counts how often on_time triggers have fired."""
    prefix = ""
    for name, count in trigger_outputs.items():
        if "on_time" in name:
            prefix = f"{count}_{prefix}_"
    return prefix
