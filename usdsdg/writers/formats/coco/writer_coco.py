"""CocoWriter: images, and JSON of boxes, masks, keypoints, segments and categories in COCO's forms."""

import os
import re
from collections.abc import Mapping
from functools import partial
from typing import Any, TypedDict, Unpack

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.errors import WriterError, warn_once
from usdsdg.session.stage_context import current_stage
from usdsdg.writers.aggregate_writer import AggregateWriter
from usdsdg.writers.backends.group import BackendDispatch
from usdsdg.writers.files import checked_image_format, checked_padding, write_image
from usdsdg.writers.formats.coco import coco_annotations, coco_file, coco_keypoints
from usdsdg.writers.formats.coco.class_categories import ClassCategories
from usdsdg.writers.formats.coco.coco_annotations import BOXES, CLASSES, INSTANCES, KEYPOINTS, RGB
from usdsdg.writers.formats.coco.coco_categories import Categories
from usdsdg.writers.formats.coco.coco_file import CocoFiles
from usdsdg.writers.formats.coco.files import ImageFiles, Names, PlainNames, ReplicatorNames, id_of_seed, sequence_of
from usdsdg.writers.formats.shapes.visible_enough import VisibleEnough
from usdsdg.writers.formats.splits import Splits
from usdsdg.writers.global_seed import global_seed
from usdsdg.writers.options import label_params, typed

_SEMANTIC_TYPES = ["class", "coco", "stuff", "thing"]
_ALWAYS = "images, boxes and masks of labeled objects are always written, and nothing else"
_XYWH_ABSOLUTE = 1  # value of `bbox_mode` for x, y, width and height in pixels
_MASKS = ("rle", "polygon")


class BasicOptions(TypedDict, total=False):
    """Options of BasicWriter that CocoWriter takes, as Replicator's takes any, and for which it writes nothing.

    bounding_box_2d_loose, bounding_box_3d, occlusion, distance_to_camera, distance_to_image_plane, normals,
    motion_vectors, camera_params, pointcloud, pointcloud_include_unlabelled, colorize_depth, skeleton_data,
    use_common_output_dir: ignored, with a warning where they ask for something.
    """

    bounding_box_2d_loose: bool | None
    bounding_box_3d: bool | None
    occlusion: bool | None
    distance_to_camera: bool | None
    distance_to_image_plane: bool | None
    normals: bool | None
    motion_vectors: bool | None
    camera_params: bool | None
    pointcloud: bool | None
    pointcloud_include_unlabelled: bool | None
    colorize_depth: bool | None
    skeleton_data: bool | None
    use_common_output_dir: bool | None


class CocoWriter(AggregateWriter):
    """Writes COCO's forms of datasets (cocodataset.org), with the file names of Replicator or, plain, those of COCO.

    Replicator's: `<product>/rgb_<camera>_<id>.NNNN.png`, next to it `panoptic_...` with each pixel in the color of its
    category, and `coco_annotations_<id>.json` of all images. An existing output_dir is not modified: a new folder next
    to it, with _0001 (and so on) appended, is written to.

    Plain: `train/000000.png`, `annotations/instances_train.json`, with `panoptic` also
    `annotations/panoptic_train.json` and `annotations/panoptic_train/000000.png`; so for each split.

    Every visible object is an annotation: a box [x, y, width, height] in pixels, its mask as compressed run lengths or
    as polygons, and the number of mask pixels as its area. The JSON is written at the end of a run, and when the
    program ends, after the images that it lists.
    """

    version = "0.0.1"
    data_structure = "renderProduct"
    shares_arrays = True
    only_stores_pictures = True

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
        plain_names: bool | None = None,
        splits: dict | None = None,
        frames_per_scene: int = 1,
        segmentation: str = "rle",
        keypoints: dict | bool = False,
        panoptic: bool = False,
        coco_info: dict | None = None,
        semantic_filter_predicate: str | None = None,
        min_visibility: float = 0.0,
        min_pixels: int = 1,
        **others: Unpack[BasicOptions],
    ) -> None:
        """
        semantic_types: types of labels to use; default class, coco, stuff and thing.
        coco_categories: by label {"name", "id"} and optionally "supercategory", "color" (r, g, b), "isthing"; default
            `semantic_classes` where these are set, else COCO's own. All of them are in the file. Other labels get the
            category "other" with a warning; a table without one has it added, id 201 or the next free one, where an
            object has such a label.
        s3_bucket, s3_region, s3_endpoint: write to a bucket, below `output_dir` as a prefix; see `S3Backend`.
        dataset_id: part of the file names, so without slashes; default eight letters that depend on the global seed.
        image_output_format: of the color images; those of categories are always png, which is lossless.
        coco_license_info: [{"id", "name", "url"}]; the first one's id is each picture's license.
        rgb, bounding_box_2d_tight, semantic_segmentation, instance_segmentation, instance_id_segmentation: options of
            BasicWriter, which scripts pass on. They change nothing: images, boxes and masks are always written, ids of
            gprims never. One that asks for something else warns.
        colorize_semantic_segmentation, colorize_instance_segmentation, colorize_instance_id_segmentation: ignored.

        Beyond Replicator:

        plain_names: COCO's file names instead of Replicator's; default where `splits` are given. Categories are then by
            default the classes of the dataset, with the ids that they have in masks, and objects of categories with
            "isthing" 0 are in the panoptic form only, as in COCO.
        splits: relative sizes of the parts of the dataset, such as {"train": 0.8, "val": 0.2}; default all "train".
        frames_per_scene: so many frames in a row are in the same part.
        segmentation: masks as "rle", which are exact, or as "polygon": outlines along the edges of pixels, one for each
            part, in which holes are filled.
        keypoints: True: those of the stage, in the order of their names; or by category a list of names or
            {"keypoints": names, "skeleton": [(name, name), ...], "sigmas": a number for each}. Coordinates are those of
            boxes: the first pixel is from 0 to 1. Sigmas, by default 0.05, are in the info as "keypoint_sigmas".
        panoptic: also COCO's panoptic form, with the ids of instance_segmentation as those of segments.
        coco_info: entries of the info section, such as {"description": "Bins", "version": "2"}.
        semantic_filter_predicate: labels to use, as a predicate instead of semantic_types.
        min_visibility: objects of which less is visible, as a fraction of what they would cover alone, are left out.
        min_pixels: so are objects with fewer visible pixels.

        Raises:
            WriterError: an option has an invalid value, two exclude each other, or two categories have the same id.
            OutputNotWritable: output_dir or the bucket cannot be written to.
            Unsupported: a bucket without obstore.
        """
        if dataset_id is not None and not re.fullmatch(r"[^/\\\0]{1,100}", dataset_id):
            raise WriterError(f"dataset_id is {dataset_id!r}; expected 1 to 100 characters of a file name, no slashes.")
        asked = {
            "rgb": (rgb, True),
            "bounding_box_2d_tight": (bounding_box_2d_tight, True),
            "semantic_segmentation": (semantic_segmentation, True),
            "instance_segmentation": (instance_segmentation, True),
            "instance_id_segmentation": (instance_id_segmentation, False),
            **{name: (value, False) for name, value in others.items()},
        }
        for name, (value, fixed) in asked.items():
            if bool(value) is not fixed:
                warn_once(f"CocoWriter: {name}={value!r} has no effect: {_ALWAYS}.")
        if segmentation not in _MASKS:
            raise WriterError(f"CocoWriter: segmentation is {segmentation!r}; expected one of {', '.join(_MASKS)}.")
        self._plain = splits is not None if plain_names is None else bool(plain_names)
        if splits is not None and not self._plain:
            raise WriterError("CocoWriter: splits need plain_names; Replicator's names have no place for them.")
        types = semantic_types if semantic_types or semantic_filter_predicate else _SEMANTIC_TYPES
        label_filter = label_params("CocoWriter", types, semantic_filter_predicate)
        names = [RGB, BOXES, INSTANCES, *([] if self._plain else [CLASSES]), *([KEYPOINTS] if keypoints else [])]
        self.annotators = [named_annotators.get(name, {} if name == RGB else label_filter) for name in names]
        self._enough = VisibleEnough("CocoWriter", min_visibility, min_pixels)
        self._keypoints = coco_keypoints.Keypoints(keypoints if isinstance(keypoints, dict) else {})
        self._label_filter = self._annotator_called(BOXES).label_filter
        by_class = self._plain and coco_categories is None
        self._categories = ClassCategories(self._label_filter) if by_class else Categories(coco_categories)
        self._image_format = checked_image_format(image_output_format)
        self._padding = checked_padding(frame_padding)
        self._licenses = coco_license_info or []
        self._info = _info(self.version) | (coco_info or {})
        self.backend = BackendDispatch(
            output_dir=output_dir,
            bucket=s3_bucket,
            region=s3_region,
            endpoint_url=s3_endpoint,
            overwrite=self._plain,
        )
        self.dataset_id = dataset_id
        self._sequence, self._frame_id = "", 0
        self._images = 0
        self._splits = Splits("CocoWriter", splits, frames_per_scene)
        self._polygons, self._with_keypoints, self._panoptic = segmentation == "polygon", bool(keypoints), panoptic
        self._files = CocoFiles(self.backend, "CocoWriter/coco")

    def skip(self, data: dict[str, Any]) -> None:
        self._begin(data)
        self._images += len(data["renderProducts"])
        self._frame_id += 1

    def write(self, data: dict[str, Any]) -> None:
        self._begin(data)
        several = max(len(self.render_products), len(data["renderProducts"])) > 1
        for product, seen in data["renderProducts"].items():
            self._write_product(product, seen, several)
        self._frame_id += 1

    def _begin(self, data: Mapping[str, Any]) -> None:
        """Get ready for a frame: its keypoints, and its place in the sequence."""
        if self._with_keypoints:
            on_stage = partial(coco_keypoints.on_stage, current_stage(), self._label_filter)
            self._keypoints.find(self._categories, on_stage)
        if not self._plain:
            self.dataset_id = self.dataset_id or id_of_seed(global_seed())
        sequence = "" if self._plain else sequence_of(data.get("trigger_outputs") or {})
        if sequence != self._sequence:
            self._sequence, self._frame_id = sequence, 0

    def on_final_frame(self) -> None:
        self._files.write()

    def _describe(self) -> None:
        """Tell the JSON files their names, categories and what is before the images."""
        categories = self._categories.all()
        reserve = [self._categories.reserve] if self._categories.reserve else []
        described, unlisted = ([self._keypoints.described(each) for each in own] for own in (categories, reserve))
        things, other_things = (
            [each for each in own if each.get("isthing", 1) or not self._plain] for own in (described, unlisted)
        )
        sigmas = self._keypoints.sigmas([*categories, *reserve])
        head = {"info": self._info | ({"keypoint_sigmas": sigmas} if sigmas else {}), "licenses": self._licenses}
        splits = {}
        for split in self._splits.names:
            names = self._file_names(split)
            splits[split] = {
                coco_file.INSTANCES: {"path": names.instances, "categories": things, "if_used": other_things}
            }
            if self._panoptic:
                splits[split][coco_file.PANOPTIC] = {
                    "path": names.panoptic,
                    "categories": described,
                    "if_used": unlisted,
                }
        self._files.note(head=head, splits=splits)

    def _file_names(self, split: str) -> Names:
        if self._plain:
            return PlainNames(split)
        assert self.dataset_id is not None
        return ReplicatorNames(self.dataset_id)

    def _write_product(self, product: str, seen: Mapping[str, Any], several: bool) -> None:
        number, split = f"{self._sequence}{self._frame_id:0{self._padding}d}", self._splits.of(self._frame_id)
        if self._plain:
            name = f"{product}_{number}" if several else number
        else:
            camera = seen["camera"][1:].replace("Replicator/", "").replace("/", "-").replace("_", "-")
            name = f"{product}/rgb_{camera}_{self.dataset_id}.{number}"
        files = self._file_names(split).image(f"{name}.{self._image_format}")
        instances = seen[INSTANCES]["data"]
        things = coco_annotations.things(seen, self._categories, self._enough)
        pictures = {files.picture: seen[RGB]["data"][..., :3]}
        if files.classes is not None:
            pictures[files.classes] = self._colored(seen[CLASSES])
        if self._panoptic:
            pictures[files.panoptic], segments = coco_annotations.segments(instances, things)
        assert self.backend is not None
        self.backend.schedule_together(
            [partial(write_image, path=path, data=image) for path, image in pictures.items()]
        )
        image, tables = self._image(files, seen), {}
        if self._panoptic:
            record = {"image_id": image["id"], "file_name": files.panoptic_name, "segments_info": segments}
            tables[coco_file.PANOPTIC] = [record]
        if self._plain:
            things = [each for each in things if each.category.get("isthing", 1)]
        tables[coco_file.INSTANCES] = self._annotations(seen, things, image)
        self._describe()  # before the first image, so that a run that ends here can be read
        self._files.add(self.num_written, image=image, split=split, **tables)

    def _image(self, files: ImageFiles, seen: Mapping[str, Any]) -> dict[str, Any]:
        """Return the record of an image. Ids are unique among all splits."""
        width, height = (int(size) for size in seen["resolution"])
        self._images += 1
        return {
            "file_name": files.picture_name,
            "id": self._images - 1,
            "height": height,
            "width": width,
            "license": self._licenses[0].get("id", 0) if self._licenses else 0,
            "date_captured": "",
            **({} if self._plain else {"flicker_url": ""}),  # the spelling is Replicator's
        }

    def _annotations(
        self, seen: Mapping[str, Any], things: list[coco_annotations.Thing], image: Mapping[str, Any]
    ) -> list[dict[str, Any]]:
        """Return the annotation records of one image, without their ids, which the file counts."""
        instances = seen[INSTANCES]["data"]
        if self._with_keypoints:
            points = coco_annotations.keypoints(seen, things, self._keypoints)
        else:
            points = [{}] * len(things)
        records = []
        for each, own_points in zip(things, points):
            if self._polygons:
                mask: Any = coco_annotations.polygons(each, instances)
            else:
                mask = coco_annotations.run_lengths(each, instances.shape)
            records.append(
                {
                    "image_id": image["id"],
                    "bbox": list(each.box),
                    "area": float(each.area),
                    **({} if self._plain else {"bbox_mode": _XYWH_ABSOLUTE}),
                    "category_id": each.category["id"],
                    "iscrowd": 0,
                    "segmentation": mask,
                    **own_points,
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
