"""KittiWriter: images, objects, classes, instances and depth in KITTI's formats."""

import os
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.annotators.colors import FIRST_LABELED, colors_of_ids
from usdsdg.errors import Unsupported, WriterError, warn_once
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.poses.transforms import up_axis
from usdsdg.writers.backends.group import BackendDispatch
from usdsdg.writers.base import Writer
from usdsdg.writers.files import write_image, write_text
from usdsdg.writers.formats.kitti import kitti_object
from usdsdg.writers.formats.kitti.kitti_classes import KittiClasses, read_mapping
from usdsdg.writers.formats.shapes import cuboid
from usdsdg.writers.formats.shapes.camera_projection import project
from usdsdg.writers.formats.shapes.pose import Pose, truncation_ratio
from usdsdg.writers.options import label_params, typed

RGB, BOXES, BOXES_3D, CAMERA = "rgb", "bounding_box_2d_tight_fast", "bounding_box_3d_fast", "camera_params"
CLASSES, INSTANCES, DEPTH = "semantic_segmentation", "instance_segmentation_fast", "distance_to_image_plane"

_FOLDERS = {
    "rgb": "image_02",
    "object_detection": "label_02",
    "semantic": "semantic",
    "semantic_segmentation": "semantic_rgb",
    "instance_segmentation": "instance",
    "instance_rgb": "instance_rgb",
    "depth": "depth",
    "calib": "calib",
}
_DEPTH_SCALE = 256  # steps of a depth image per meter


class KittiWriter(Writer):
    """Writes `<camera>/<kind>/N.png` and `.txt`, below `<product>/` with several render products, for the kinds

    - rgb: color;
    - object_detection: a line for every visible object with KITTI's fifteen fields, in meters in KITTI's camera frame;
      an empty file if there are none. Replicator leaves truncated, alpha and the whole 3D box at 0, and uses the ratio
      of the boxes' areas as the visible fraction;
    - calib: the projection matrices, for pinholes;
    - semantic, semantic_segmentation: ids (8 bits; metadata.txt names them) and colors of classes;
    - instance_segmentation: 16 bits, 256 times the id of the class plus the number of the object, from 1 in its class;
    - instance_rgb, if requested: objects in different colors;
    - depth: 16 bits, 256 times the distance along the optical axis [m]; 0 from 256 m on and where nothing is hit.
    """

    version = "0.0.1"
    data_structure = "renderProduct"
    shares_arrays = True

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

        Raises:
            WriterError: two options exclude each other, or a value is invalid.
            AssetUnreadable: mapping_path cannot be read.
            OutputNotWritable: output_dir or the bucket cannot be written to.
            Unsupported: a bucket without boto3, or renderproduct_idxs.
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
        self._classes = KittiClasses(read_mapping(mapping_path) if mapping_path else mapping_dict or None)
        self.metadata["semantic_ids"] = self._classes.ids()
        self.backend = BackendDispatch(
            output_dir=output_dir, bucket=s3_bucket, region=s3_region, endpoint_url=s3_endpoint
        )
        self._omit_type = omit_semantic_type
        self._lowest = bbox_height_threshold
        self._partly, self._fully = partly_occluded_threshold, fully_visible_threshold
        self._colorize = colorize_instance_segmentation
        self._kitti_names = use_kitti_dir_names
        self._frame_id = 0
        self.annotators = [
            *(named_annotators.get(name) for name in (RGB, DEPTH, CAMERA)),
            *(named_annotators.get(name, labels) for name in (BOXES, BOXES_3D, CLASSES, INSTANCES)),
        ]

    def write(self, data: dict[str, Any]) -> None:
        several = max(len(self.render_products), len(data["renderProducts"])) > 1
        for product, seen in data["renderProducts"].items():
            root = f"{product}/" if several else ""
            self._write_product(f"{root}{seen['camera'].rsplit('/', 1)[-1]}", seen)
        self._frame_id += 1

    def _write_product(self, root: str, seen: Mapping[str, Any]) -> None:
        ids, colors = self._class_images(seen[CLASSES])
        objects = seen[INSTANCES]["data"]
        images = {
            "rgb": seen[RGB]["data"][..., :3],
            "semantic": ids,
            "semantic_segmentation": colors,
            "instance_segmentation": self._instance_image(seen[INSTANCES]),
            "depth": depth_image(seen[DEPTH]["data"]),
        }
        if self._colorize:
            images["instance_rgb"] = colors_of_ids(np.arange(int(objects.max(initial=0)) + 1))[objects]
        steps: list[Callable[..., None]] = [
            partial(write_image, path=self._path(root, kind, "png"), data=image) for kind, image in images.items()
        ]
        if seen[CAMERA]["cameraModel"] == "pinhole":
            text = kitti_object.calibration(seen[CAMERA])
            steps.append(partial(write_text, path=self._path(root, "calib", "txt"), text=text))
        else:
            warn_once(
                f"KittiWriter: no calib for a lens of model {seen[CAMERA]['cameraModel']!r}; KITTI has pinholes only."
            )
        # Labels last, so that a frame with labels has its images.
        lines = "".join(self._object_lines(seen))
        steps.append(partial(write_text, path=self._path(root, "object_detection", "txt"), text=lines))
        assert self.backend is not None
        self.backend.schedule_together(steps)

    def _path(self, root: str, kind: str, extension: str) -> str:
        return f"{root}/{_FOLDERS[kind] if self._kitti_names else kind}/{self._frame_id}.{extension}"

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
        return 0 if visible >= self._fully else 1 if visible >= self._partly else 2

    def _name(self, labels: Mapping[str, str]) -> str:
        """Return the name of an object, without blanks."""
        if self._omit_type:
            name = labels.get("class", next(iter(labels.values())))
        else:
            name = ";".join(f"{kind}:{label}" for kind, label in labels.items())
        return "_".join(name.split())

    def _class_images(self, classes: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray]:
        """Return ids, uint8 (H, W), and colors, uint8 (H, W, 4), of the pixels' classes."""
        ids = classes["data"]
        palette = np.zeros((max(map(int, classes["idToLabels"])) + 1, 5), np.uint8)
        for number, labels in classes["idToLabels"].items():
            found = self._classes.of(labels)
            palette[int(number)] = (found.id, *found.color)
        return palette[:, 0][ids], palette[:, 1:][ids]

    def _instance_image(self, instances: Mapping[str, Any]) -> np.ndarray:
        """Return uint16 (H, W): 256 * class + number; the number is 0 where there is no object."""
        ids = instances["data"]
        palette = np.zeros(max(instances["idToSemantics"]) + 1, np.uint16)
        counted: dict[int, int] = {}
        for number, labels in sorted(instances["idToSemantics"].items()):
            class_id = self._classes.of(labels).id
            if number >= FIRST_LABELED:
                counted[class_id] = counted.get(class_id, 0) + 1
            palette[number] = class_id * 256 + _eight_bits(counted.get(class_id, 0) if number >= FIRST_LABELED else 0)
        return palette[ids]


def _eight_bits(number: int) -> int:
    if number > 255:
        warn_once(
            "KittiWriter: more than 255 objects of a class in an image: instance_segmentation has 0 for the rest."
        )
    return number if number <= 255 else 0


def depth_image(depth: np.ndarray) -> np.ndarray:
    """Encode depth [m] as uint16 (H, W) in steps of 1/256; 0 where nothing is hit or the depth is out of range."""
    steps = np.rint(np.where(np.isfinite(depth), depth, 0.0).astype(np.float64) * _DEPTH_SCALE)
    return np.where(steps <= 0xFFFF, steps, 0).astype(np.uint16)
