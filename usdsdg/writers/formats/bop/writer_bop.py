"""BopWriter: scenes of the BOP benchmark for 6D poses, with the models of their objects."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.errors import Unsupported, WriterError, warn_once
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.group import make_backend
from usdsdg.writers.base import Writer
from usdsdg.writers.files import write_bytes, write_image, write_json
from usdsdg.writers.formats.bop.bop_models import MILLIMETERS, Models, Placed, ply
from usdsdg.writers.formats.shapes.camera_projection import camera_matrix
from usdsdg.writers.formats.shapes.opencv_frame import opencv_position, opencv_rotation
from usdsdg.writers.options import label_params, typed

RGB, DEPTH, CAMERA = "rgb", "distance_to_image_plane", "camera_params"
BOXES_3D, WHOLE, INSTANCES = "bounding_box_3d_fast", "bounding_box_2d_amodal", "instance_segmentation_fast"
AMODAL = "amodal_instance_segmentation"
# The JSON files of a scene are written again after this many pictures, and at the end.
_PICTURES = 25


class BopWriter(Writer):
    """Writes `<split>/<scene>/rgb`, `depth`, `mask`, `mask_visib`, `scene_camera.json`, `scene_gt.json`,
    `scene_gt_info.json`, and `models/obj_NNNNNN.ply` with `models_info.json` (bop.felk.cvut.cz).

    Each render product is a scene, each frame a picture of it. Lengths are in millimeters, poses map the model to the
    camera with x right, y down and z ahead, and pixel coordinates are 0 at the center of the first. An object's id is
    the place of its class in the class table, from 1; other shapes or scales of a class have 1000 more each.
    """

    version = "0.0.1"
    data_structure = "renderProduct"
    shares_arrays = True

    @typed
    def __init__(
        self,
        output_dir: str | os.PathLike | None = None,
        split: str = "train_pbr",
        depth_scale: float = 0.1,
        image_output_format: str = "png",
        semantic_types: list[str] | str | None = None,
        semantic_filter_predicate: str | None = None,
        s3_bucket: str | None = None,
        s3_region: str | None = None,
        s3_endpoint: str | None = None,
        backend: BaseBackend | None = None,
    ) -> None:
        """
        split: name of the folder of the scenes.
        depth_scale: millimeters of one step of the 16-bit depth pictures; what is too far for them is 0.
        image_output_format: "png" or "jpg", of the color pictures.
        semantic_types, semantic_filter_predicate: labels to use, as types or as a predicate; default "class:*".
        s3_bucket, s3_region, s3_endpoint: write to a bucket, below `output_dir` as a prefix; see `S3Backend`.

        Raises:
            WriterError: two options exclude each other, a value does not exist, or there is nowhere to write.
            OutputNotWritable: output_dir or the bucket cannot be written to.
        """
        if not depth_scale > 0.0:
            raise WriterError(f"BopWriter: depth_scale is {depth_scale}; expected millimeters above 0.")
        if image_output_format not in ("png", "jpg"):
            raise WriterError(f"BopWriter: image_output_format is {image_output_format!r}; expected png or jpg.")
        if not split or "/" in split:
            raise WriterError(f"BopWriter: split is {split!r}; expected the name of a folder.")
        labels = label_params("BopWriter", semantic_types, semantic_filter_predicate)
        self._split, self._depth_scale, self._image_format = split, depth_scale, image_output_format
        self.backend = make_backend(
            "BopWriter", output_dir, backend, bucket=s3_bucket, region=s3_region, endpoint_url=s3_endpoint
        )
        self.annotators = [
            *(named_annotators.get(name) for name in (RGB, DEPTH, CAMERA)),
            *(named_annotators.get(name, labels) for name in (BOXES_3D, WHOLE, INSTANCES)),
            named_annotators.get(AMODAL, {**labels, "encoding": "rle"}),
        ]
        self._models = Models()
        self._scenes: dict[str, _Scene] = {}
        self._frame_id = 0
        # Also if a script ends or is interrupted before its run is complete.
        current().io_queue.call_at_exit(self._write_tables)

    def write(self, data: dict[str, Any]) -> None:
        for product, seen in data["renderProducts"].items():
            scene = self._scenes.setdefault(product, _Scene(len(self._scenes)))
            self._write_picture(scene, seen)
        self._frame_id += 1
        if self._frame_id == 1 or self._frame_id % _PICTURES == 0:
            self._write_tables()

    def on_final_frame(self) -> None:
        self._write_tables()

    def detach(self) -> None:
        super().detach()
        if self.backend is not None:
            self._write_tables()

    def _write_picture(self, scene: _Scene, seen: Mapping[str, Any]) -> None:
        camera = seen[CAMERA]
        if camera["cameraModel"] != "pinhole":
            raise Unsupported(f"BopWriter: a camera of the model {camera['cameraModel']!r}; BOP has pinholes only.")
        root, number = f"{self._split}/{scene.number:06d}", f"{self._frame_id:06d}"
        world_to_camera = np.asarray(camera["cameraViewTransform"], np.float64).reshape(4, 4)
        millimeters = float(camera["metersPerSceneUnit"]) * MILLIMETERS
        steps = [
            partial(write_image, path=f"{root}/rgb/{number}.{self._image_format}", data=seen[RGB]["data"][..., :3]),
            partial(write_image, path=f"{root}/depth/{number}.png", data=self._depth(seen[DEPTH]["data"])),
        ]
        poses, infos = [], []
        for placed, info, modal, amodal in self._objects(seen, millimeters):
            name = f"{number}_{len(poses):06d}.png"
            steps.append(partial(write_image, path=f"{root}/mask/{name}", data=amodal))
            steps.append(partial(write_image, path=f"{root}/mask_visib/{name}", data=modal))
            poses.append(_pose(placed, world_to_camera, millimeters))
            infos.append(info)
        scene.camera[self._frame_id] = _camera(camera, world_to_camera, millimeters, self._depth_scale)
        scene.poses[self._frame_id], scene.infos[self._frame_id] = poses, infos
        for obj_id, model in self._models.new:
            steps.append(partial(write_bytes, path=f"models/obj_{obj_id:06d}.ply", data=ply(model)))
        self._models.new.clear()
        assert self.backend is not None
        self.backend.schedule_together(steps)

    def _objects(self, seen: Mapping[str, Any], millimeters: float) -> Any:
        """Yield model and pose, the record of scene_gt_info, and both masks of each object in view."""
        boxes, whole = seen[BOXES_3D], seen[WHOLE]
        ids = seen[INSTANCES]["data"]
        depth = seen[DEPTH]["data"]
        table = current().class_tables.of(self.get_annotator(BOXES_3D).label_filter)
        kinds = [boxes["idToLabels"][int(row["semanticId"])] for row in boxes["data"]]
        numbers = table.ids(kinds)
        numbers = np.searchsorted(list(table.labels()), numbers) + 1
        wide = {int(each): row for each, row in zip(whole["bboxIds"], whole["data"])}
        masks = dict(zip(seen[AMODAL]["instanceIds"].tolist(), seen[AMODAL]["masks"], strict=True))
        stage = current_stage()
        for row, path, instance, number, labels in zip(
            boxes["data"], boxes["primPaths"], boxes["bboxIds"].tolist(), numbers.tolist(), kinds
        ):
            if instance not in masks or instance not in wide:
                continue
            name = ",".join(labels.values())
            placed = self._models.place(stage, path, number, name, row["transform"], millimeters)
            if placed is not None:
                amodal, modal = _decoded(masks[instance]), ids == instance
                yield placed, _info(modal, amodal, wide[instance], depth), _picture(modal), _picture(amodal)

    def _depth(self, meters: np.ndarray) -> np.ndarray:
        """Return a depth picture, uint16 (H, W); 0 where nothing is hit."""
        steps = np.round(np.where(np.isfinite(meters), meters, 0.0) * MILLIMETERS / self._depth_scale)
        if steps.max(initial=0.0) > 65535:
            far = 65535 * self._depth_scale / MILLIMETERS
            warn_once(f"BopWriter: what is beyond {far:.3g} m has the depth 0; a larger depth_scale reaches further.")
        return np.where(steps <= 65535, steps, 0.0).astype(np.uint16)

    def _write_tables(self) -> None:
        """Write the JSON files of all scenes after the pictures that they name, and those of the models."""
        if not any(scene.is_new for scene in self._scenes.values()):
            return
        assert self.backend is not None
        for scene in self._scenes.values():
            if scene.is_new:
                root = f"{self._split}/{scene.number:06d}"
                for name, values in scene.tables().items():
                    self.backend.schedule_after_all(write_json, path=f"{root}/{name}.json", data=values, indent=1)
        models = _by_text(self._models.info)
        self.backend.schedule_after_all(write_json, path="models/models_info.json", data=models, indent=1)


class _Scene:
    """The records of one render product so far."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.camera: dict[int, dict[str, Any]] = {}
        self.poses: dict[int, list[dict[str, Any]]] = {}
        self.infos: dict[int, list[dict[str, Any]]] = {}
        self._written = 0

    @property
    def is_new(self) -> bool:
        """Whether there are pictures that the files do not name."""
        return len(self.camera) > self._written

    def tables(self) -> dict[str, dict[str, Any]]:
        """Return the content of the JSON files, and count it as written."""
        self._written = len(self.camera)
        return {
            "scene_camera": _by_text(self.camera),
            "scene_gt": _by_text(self.poses),
            "scene_gt_info": _by_text(self.infos),
        }


def _by_text(values: Mapping[int, Any]) -> dict[str, Any]:
    return {str(key): values[key] for key in sorted(values)}


def _camera(
    params: Mapping[str, Any], world_to_camera: np.ndarray, millimeters: float, depth_scale: float
) -> dict[str, Any]:
    rotation = opencv_rotation(np.eye(3), world_to_camera)
    return {
        "cam_K": camera_matrix(params).ravel().tolist(),
        "depth_scale": depth_scale,
        "cam_R_w2c": rotation.ravel().tolist(),
        "cam_t_w2c": (opencv_position(np.zeros(3), world_to_camera) * millimeters).tolist(),
    }


def _pose(placed: Placed, world_to_camera: np.ndarray, millimeters: float) -> dict[str, Any]:
    rotation = opencv_rotation(placed.rotation, world_to_camera)
    position = opencv_position(placed.position, world_to_camera)
    return {
        "cam_R_m2c": rotation.ravel().tolist(),
        "cam_t_m2c": (position * millimeters).tolist(),
        "obj_id": placed.obj_id,
    }


def _info(modal: np.ndarray, amodal: np.ndarray, whole: Any, depth: np.ndarray) -> dict[str, Any]:
    """Return the record of scene_gt_info: boxes as x, y, width, height, and numbers of pixels.

    px_count_all counts pixels around the picture too, as the box of the whole object contains them.
    """
    inside = int(amodal.sum())
    everywhere = round(inside / max(1.0 - float(whole["truncationRatio"]), 1e-6))
    visible = int(modal.sum())
    return {
        "bbox_obj": _box(*(int(whole[name]) for name in ("x_min", "y_min", "x_max", "y_max"))),
        "bbox_visib": _extent(modal),
        "px_count_all": everywhere,
        "px_count_valid": int((amodal & np.isfinite(depth)).sum()),
        "px_count_visib": visible,
        "visib_fract": visible / everywhere if everywhere else 0.0,
    }


def _extent(mask: np.ndarray) -> list[int]:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return [-1, -1, -1, -1]
    return _box(int(columns[0]), int(rows[0]), int(columns[-1]), int(rows[-1]))


def _box(x_min: int, y_min: int, x_max: int, y_max: int) -> list[int]:
    return [x_min, y_min, x_max - x_min + 1, y_max - y_min + 1]


def _decoded(runs: Mapping[str, Any]) -> np.ndarray:
    """Return the mask (H, W) of run lengths down the columns."""
    height, width = runs["size"]
    counts = np.asarray(runs["counts"])
    return np.repeat(np.arange(len(counts)) % 2 == 1, counts).reshape(width, height).T


def _picture(mask: np.ndarray) -> np.ndarray:
    return mask.astype(np.uint8) * 255
