"""KittiWriter: images, objects, classes, instances and depth in KITTI's formats."""

import os
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.annotators.colors import colors_of_ids
from usdsdg.errors import Unsupported, WriterError, warn_once
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.poses.transforms import up_axis
from usdsdg.writers.aggregate_writer import AggregateWriter
from usdsdg.writers.backends.group import BackendDispatch
from usdsdg.writers.files import write_image, write_text
from usdsdg.writers.formats.kitti import files, kitti_images, kitti_object
from usdsdg.writers.formats.kitti.image_sets import ImageSet
from usdsdg.writers.formats.kitti.kitti_classes import KittiClasses, read_mapping
from usdsdg.writers.formats.shapes import cuboid
from usdsdg.writers.formats.shapes.camera_projection import project
from usdsdg.writers.formats.shapes.pose import Pose, truncation_ratio
from usdsdg.writers.formats.shapes.visible_enough import ROUNDING
from usdsdg.writers.formats.splits import Splits
from usdsdg.writers.options import label_params, typed

RGB, BOXES, BOXES_3D, CAMERA = "rgb", "bounding_box_2d_tight_fast", "bounding_box_3d_fast", "camera_params"
CLASSES, INSTANCES, DEPTH = "semantic_segmentation", "instance_segmentation_fast", "distance_to_image_plane"

UNKNOWN = 3  # of levels of occlusion
_IGNORED = "dontcare"  # in small letters


class KittiWriter(AggregateWriter):
    """Writes `<camera>/<kind>/N.png` and `.txt`, below `<product>/` with several render products.

    With `plain_names` or `splits` it writes KITTI's own layout instead: `training/image_2/NNNNNN.png`,
    `training/label_2/NNNNNN.txt`, `training/calib/NNNNNN.txt` and their siblings, with the pictures of all render
    products in one row, and `ImageSets/<split>.txt`. Kinds are

    - rgb: color;
    - object_detection: a line for every visible object with KITTI's fifteen fields, in meters in KITTI's camera frame;
      an empty file if there are none. Replicator leaves truncated, alpha and the whole 3D box at 0, and uses the ratio
      of the boxes' areas as the visible fraction;
    - calib: the projection matrices, for pinholes;
    - semantic, semantic_segmentation: ids (8 bits; metadata.txt names them) and colors of classes;
    - instance_segmentation: 16 bits, 256 times the id of the class plus the number of the object, from 1 in its class;
    - instance_rgb, if requested: objects in different colors;
    - depth: 16 bits, 256 times the distance along the optical axis [m]; 0 from 256 m on, behind the camera and where
      nothing is hit.
    """

    version = "0.0.1"
    data_structure = "renderProduct"
    shares_arrays = True
    only_stores_pictures = True

    @typed
    def __init__(
        self,
        output_dir: str | os.PathLike,
        s3_bucket: str | None = None,
        s3_region: str | None = None,
        s3_endpoint: str | None = None,
        semantic_types: list[str] | None = None,
        omit_semantic_type: bool = False,
        bbox_height_threshold: int = 25,
        partly_occluded_threshold: float = 0.5,
        fully_visible_threshold: float = 0.95,
        renderproduct_idxs: list | None = None,
        mapping_path: str | os.PathLike | None = None,
        mapping_dict: dict | None = None,
        colorize_instance_segmentation: bool = False,
        semantic_filter_predicate: str | None = None,
        use_kitti_dir_names: bool = False,
        *,
        plain_names: bool | None = None,
        splits: dict | None = None,
        frames_per_scene: int = 1,
    ) -> None:
        """
        s3_bucket, s3_region, s3_endpoint: write to a bucket, below `output_dir` as a prefix; see `S3Backend`.
        semantic_types, semantic_filter_predicate: labels to use, as types or as a predicate; default "class:*".
        omit_semantic_type: name objects "car" instead of "class:car". Blanks in labels become "_".
        bbox_height_threshold: smallest box height of objects in object_detection [pixels].
        partly_occluded_threshold, fully_visible_threshold: smallest visible fractions of partly occluded (1) and fully
            visible (0) objects; below both an object is largely occluded (2).
        mapping_path, mapping_dict: classes by label, as ids or colors (r, g, b, a); other labels are "unlabelled".
            Default: those of Cityscapes.
        use_kitti_dir_names: image_02, label_02, semantic_rgb and instance instead of the names above.
        plain_names: KITTI's own layout, in which objects are named as with omit_semantic_type; default where `splits`
            are given.
        splits: relative sizes of the parts of the dataset, such as {"train": 0.8, "val": 0.2}; default all "train".
        frames_per_scene: so many frames in a row are in the same part.

        Raises:
            WriterError: two options exclude each other, or a value is invalid.
            AssetUnreadable: mapping_path cannot be read.
            OutputNotWritable: output_dir or the bucket cannot be written to.
            Unsupported: a bucket without obstore, or renderproduct_idxs.
        """
        if renderproduct_idxs is not None:
            raise Unsupported(
                "KittiWriter: renderproduct_idxs; attach the writer to the render products that it is for."
            )
        labels = label_params("KittiWriter", semantic_types, semantic_filter_predicate)
        if mapping_path and mapping_dict:
            raise WriterError("KittiWriter: mapping_path and mapping_dict exclude each other; give one.")
        if bbox_height_threshold < 0:
            raise WriterError(
                f"KittiWriter: bbox_height_threshold is {bbox_height_threshold}; expected 0 or more pixels."
            )
        self._layout = files.layout_of(
            {"use_kitti_dir_names": use_kitti_dir_names, "plain_names": plain_names, "splits": splits}
        )
        is_plain = self._layout is files.PLAIN
        if splits is not None and not is_plain:
            raise WriterError("KittiWriter: splits need plain_names; Replicator's names have no place for them.")
        if use_kitti_dir_names and is_plain:
            raise WriterError(
                "KittiWriter: use_kitti_dir_names are of Replicator's layout; leave out plain_names and splits."
            )
        self._classes = KittiClasses(read_mapping(mapping_path) if mapping_path else mapping_dict or None)
        self.metadata["semantic_ids"] = self._classes.ids()
        self._splits = Splits("KittiWriter", splits, frames_per_scene)
        self.backend = BackendDispatch(
            output_dir=output_dir, bucket=s3_bucket, region=s3_region, endpoint_url=s3_endpoint
        )
        parts = self._splits.names if is_plain else ()
        self._sets = {split: ImageSet(self.backend, f"KittiWriter/{split}") for split in parts}
        self._omit_type = omit_semantic_type or is_plain
        self._lowest = bbox_height_threshold
        self._partly, self._fully = partly_occluded_threshold, fully_visible_threshold
        self._colorize = colorize_instance_segmentation
        self._frame_id = self._pictures = 0
        self._named: dict[str, str] = {}  # what the names of objects were before they had no blanks
        self.annotators = [
            *(named_annotators.get(name) for name in (RGB, DEPTH, CAMERA)),
            *(named_annotators.get(name, labels) for name in (BOXES, BOXES_3D, CLASSES, INSTANCES)),
        ]

    def skip(self, data: dict[str, Any]) -> None:
        self._pictures += len(data["renderProducts"])
        self._frame_id += 1

    def write(self, data: dict[str, Any]) -> None:
        several = max(len(self.render_products), len(data["renderProducts"])) > 1
        split = self._splits.of(self._frame_id)
        for name, pictures in self._sets.items():
            pictures.note(split=name)
        for product, seen in data["renderProducts"].items():
            if self._sets:
                self._write_picture(files.TRAINING, self._pictures, seen)
                self._sets[split].add(self.num_written, number=self._pictures)
            else:
                camera = seen["camera"].rsplit("/", 1)[-1]
                self._write_picture(f"{product}/{camera}" if several else camera, self._frame_id, seen)
            self._pictures += 1
        self._frame_id += 1

    def on_final_frame(self) -> None:
        for pictures in self._sets.values():
            pictures.write()

    def _write_picture(self, root: str, number: int, seen: Mapping[str, Any]) -> None:
        ids, colors = kitti_images.class_images(seen[CLASSES], self._classes)
        objects = seen[INSTANCES]["data"]
        images = {
            files.RGB: seen[RGB]["data"][..., :3],
            files.CLASSES: ids,
            files.CLASS_COLORS: colors,
            files.INSTANCES: kitti_images.instance_image(seen[INSTANCES], self._classes),
            files.DEPTH: kitti_images.depth_image(seen[DEPTH]["data"]),
        }
        if self._colorize:
            images[files.INSTANCE_COLORS] = colors_of_ids(np.arange(int(objects.max(initial=0)) + 1))[objects]
        steps: list[Callable[..., None]] = [
            partial(write_image, path=self._layout.path(root, kind, number), data=image)
            for kind, image in images.items()
        ]
        if seen[CAMERA]["cameraModel"] == "pinhole":
            path = self._layout.path(root, files.CALIBRATION, number)
            steps.append(partial(write_text, path=path, text=kitti_object.calibration(seen[CAMERA])))
        else:
            warn_once(
                f"KittiWriter: no calib for a lens of model {seen[CAMERA]['cameraModel']!r}; KITTI has pinholes only."
            )
        # Labels last, so that a frame with labels has its images.
        lines = "".join(self._object_lines(seen))
        steps.append(partial(write_text, path=self._layout.path(root, files.LABELS, number), text=lines))
        assert self.backend is not None
        self.backend.schedule_together(steps)

    def _object_lines(self, seen: Mapping[str, Any]) -> list[str]:
        """Return a line for every visible object of sufficient height."""
        boxes, camera = seen[BOXES], seen[CAMERA]
        units = {"meters": float(camera["metersPerSceneUnit"]), "up": "XYZ".index(up_axis(current_stage()))}
        boxes_3d = dict(zip(seen[BOXES_3D]["bboxIds"].tolist(), seen[BOXES_3D]["data"]))
        lines = []
        for row, number in zip(boxes["data"], boxes["bboxIds"].tolist()):
            if row["y_max"] - row["y_min"] + 1 < self._lowest:
                continue
            pose = Pose(boxes_3d[number], camera, cuboid.CORNERS)
            pixels = project(np.array(list(pose.in_camera.values())), camera)
            left, top, right, bottom = (int(row[side]) for side in ("x_min", "y_min", "x_max", "y_max"))
            lines.append(
                kitti_object.line(
                    self._name(boxes["idToLabels"][int(row["semanticId"])]),
                    truncation_ratio(pose, pixels, camera),
                    self._occlusion_level(1.0 - float(row["occlusionRatio"])),
                    (left, top, right, bottom),
                    kitti_object.KittiBox.of(pose, **units),
                )
            )
        return lines

    def _occlusion_level(self, visible: float) -> int:
        if not np.isfinite(visible):
            return UNKNOWN
        visible += ROUNDING
        return 0 if visible >= self._fully else 1 if visible >= self._partly else 2

    def _name(self, labels: Mapping[str, str]) -> str:
        """Return the name of an object, without blanks.

        Raises:
            WriterError: objects of another class have it, too.
        """
        if self._omit_type:
            name = labels.get("class", next(iter(labels.values())))
        else:
            name = ";".join(f"{kind}:{label}" for kind, label in labels.items())
        whole, name = name, "_".join(name.split())
        if self._named.setdefault(name, whole) != whole:
            raise WriterError(
                f"KittiWriter: the classes {self._named[name]!r} and {whole!r} would both be called {name}, since "
                "names have no blanks. Rename one of the labels."
            )
        if name.lower() == _IGNORED:
            warn_once(
                f"KittiWriter: KITTI's evaluation leaves out objects of the class {name!r}, which means regions "
                "without labels there. Rename the label if they are to count."
            )
        return name
