"""BopWriter: scenes of the BOP benchmark for 6D poses, with the models of their objects."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any, Unpack

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.annotators.prims.labeled_survey import LabeledSurvey
from usdsdg.errors import Unsupported, WriterError, warn_once
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import stage_time
from usdsdg.stage.poses.transforms import meters_per_unit
from usdsdg.stage.world_values import WorldValues
from usdsdg.writers.aggregate_writer import AggregateWriter
from usdsdg.writers.files import write_bytes, write_image
from usdsdg.writers.formats import class_places
from usdsdg.writers.formats.bop import bop_files as files
from usdsdg.writers.formats.bop.bop_models import Models, Placed, ply
from usdsdg.writers.formats.bop.bop_records import View, info
from usdsdg.writers.formats.bop.bop_tables import ModelTables, Scene
from usdsdg.writers.formats.bop.shape_edits import may_reshape
from usdsdg.writers.formats.shapes import masks
from usdsdg.writers.formats.shapes.camera_projection import is_pinhole
from usdsdg.writers.formats.splits import Splits
from usdsdg.writers.options import CommonOptions, common_backend, common_labels, typed

RGB, DEPTH, CAMERA = "rgb", "distance_to_image_plane", "camera_params"
BOXES_3D, WHOLE, INSTANCES = "bounding_box_3d_fast", "bounding_box_2d_amodal", "instance_segmentation_fast"
AMODAL = "amodal_instance_segmentation"
MANY = 1 << 62  # frames of a scene without end


class BopWriter(AggregateWriter):
    """Writes `<split>/<scene>/rgb`, `depth`, `mask`, `mask_visib`, `scene_camera.json`, `scene_gt.json`,
    `scene_gt_info.json`; `models/obj_NNNNNN.ply` with `models_info.json`, and `names.json` of their classes; and
    `camera.json`, of the first picture (bop.felk.cvut.cz).

    Each render product is a scene, or one for each `frames_per_scene`, and each frame a picture of it. Lengths are in
    millimeters, poses map the model to the camera with x right, y down and z ahead, and pixel coordinates are 0 at the
    center of the first. An object's id is the place of its class in the class table, from 1; other shapes or scales of
    a class have 1000 more each.
    """

    version = "0.0.1"
    data_structure = "renderProduct"
    shares_arrays = True
    only_stores_pictures = True

    @typed
    def __init__(
        self,
        output_dir: str | os.PathLike | None = None,
        split: str = "train_pbr",
        splits: dict | None = None,
        frames_per_scene: int | None = None,
        depth_scale: float = 0.1,
        image_output_format: str = "png",
        **common: Unpack[CommonOptions],
    ) -> None:
        """
        split: name of the folder of the scenes.
        splits: instead of it relative sizes of several, such as {"train_pbr": 0.8, "val_pbr": 0.2}, to which scenes, or
            without `frames_per_scene` frames, are dealt.
        frames_per_scene: so many frames in a row are a scene, such as those of one arrangement; default all.
        depth_scale: millimeters of one step of the 16-bit depth pictures; what is too far for them is 0.
        image_output_format: "png" or "jpg", of the color pictures.
        common: as `CommonOptions`.

        Raises:
            WriterError: two options exclude each other, a value does not exist, or there is nowhere to write.
            OutputNotWritable: output_dir or the bucket cannot be written to.
        """
        if not depth_scale > 0.0:
            raise WriterError(f"BopWriter: depth_scale is {depth_scale}; expected millimeters above 0.")
        if image_output_format not in ("png", "jpg"):
            raise WriterError(f"BopWriter: image_output_format is {image_output_format!r}; expected png or jpg.")
        for name in splits or (split,):
            if not isinstance(name, str) or not name or "/" in name:
                raise WriterError(f"BopWriter: split is {name!r}; expected the name of a folder.")
        labels = common_labels("BopWriter", common)
        self._depth_scale, self._image_format = depth_scale, image_output_format
        self.backend = common_backend("BopWriter", output_dir, common)
        self.annotators = [
            *(named_annotators.get(name) for name in (RGB, DEPTH, CAMERA)),
            *(named_annotators.get(name, labels) for name in (BOXES_3D, WHOLE, INSTANCES)),
            named_annotators.get(AMODAL, {**labels, "encoding": "rle"}),
        ]
        self._models = Models()
        self._survey: LabeledSurvey | None = None
        self._written: set[int] = set()  # ids of the models that are
        self._splits = Splits("BopWriter", splits or {split: 1.0}, frames_per_scene or 1)
        self._frames_per_scene = frames_per_scene
        self._scenes: dict[tuple[str, str], Scene] = {}  # the last ones, by split and render product
        self._tables = ModelTables(self.backend, "BopWriter/models")
        self._frame_id = self._scene_count = 0

    def skip(self, data: dict[str, Any]) -> None:
        self.survey()
        for product in data["renderProducts"]:
            self._scene_of(product)
        self._frame_id += 1

    def write(self, data: dict[str, Any]) -> None:
        self.survey()
        models: set[int] = set()
        for product, seen in data["renderProducts"].items():
            models |= self._write_picture(self._scene_of(product), seen)
        self._write_models(models)
        self._tables.note(infos=self._models.infos, names=self._models.names)
        camera = View(next(iter(data["renderProducts"].values()))[CAMERA], self._depth_scale).sensor()
        self._tables.add(self.num_written, models=sorted(models), camera=camera)
        self._frame_id += 1

    def on_final_frame(self) -> None:
        for tables in (*self._scenes.values(), self._tables):
            tables.write()

    def _scene_of(self, product: str) -> Scene:
        """Return the scene of a render product that this frame belongs to; its tables are written when it ends."""
        split, place = self._splits.of(self._frame_id), self._frame_id // (self._frames_per_scene or MANY)
        scene = self._scenes.get((split, product))
        if scene is None or scene.place != place:
            if scene is not None:
                scene.write()
            assert self.backend is not None
            scene = self._scenes[split, product] = Scene(self.backend, split, self._scene_count, place)
            self._scene_count += 1
        return scene

    def survey(self) -> None:
        """Give ids to the models of all labeled prims, also of a frame that other processes write."""
        prims = self._prims()
        table = class_places.table_of(self._annotator_called(BOXES_3D).label_filter)
        millimeters, time = meters_per_unit(prims.stage) * files.MILLIMETERS, stage_time(prims.stage)
        self._models.survey(prims, lambda labels: class_places.places(table, labels) + 1, millimeters, time)

    def has_to_see(self, values: WorldValues) -> bool:
        prims = self._prims()
        return may_reshape(prims.stage, values, prims.places())

    def _prims(self) -> LabeledSurvey:
        """Return what reads the labeled prims of the stage."""
        stage = current_stage()
        if self._survey is None or self._survey.stage is not stage:
            self._survey = LabeledSurvey(stage, self._annotator_called(BOXES_3D).label_filter)
            self._models.forget_prims()
        return self._survey

    def _write_models(self, models: set[int]) -> None:
        """Write the models that are seen for the first time."""
        assert self.backend is not None
        with current().io_queue.of_all_frames():
            for obj_id in sorted(models - self._written):
                data = ply(self._models.model(obj_id))
                self.backend.schedule(write_bytes, path=files.model_of(obj_id), data=data)
        self._written |= models

    def _write_picture(self, scene: Scene, seen: Mapping[str, Any]) -> set[int]:
        """Write a picture with its masks, and return the ids of the models in it."""
        if not is_pinhole(seen[CAMERA]):
            model = seen[CAMERA]["cameraModel"]
            raise Unsupported(f"BopWriter: a camera of the model {model!r}; BOP has pinholes only.")
        folder, frame = scene.folder, self._frame_id
        view, depth = View(seen[CAMERA], self._depth_scale), self._depth(seen[DEPTH]["data"])
        color = files.picture_of(folder, files.RGB, frame, self._image_format)
        steps = [
            partial(write_image, path=color, data=seen[RGB]["data"][..., :3]),
            partial(write_image, path=files.picture_of(folder, files.DEPTH, frame), data=depth),
        ]
        poses, infos = [], []
        for placed, whole, modal, amodal in self._objects(seen, view.millimeters):
            for kind, mask in ((files.MASK, amodal), (files.MASK_VISIB, modal)):
                path = files.mask_of(folder, kind, frame, len(poses))
                steps.append(partial(write_image, path=path, data=masks.picture(mask)))
            poses.append(view.pose(placed))
            infos.append(info(modal, amodal, whole, depth))
        tables = {files.CAMERAS: view.record(), files.POSES: poses, files.INFOS: infos}
        scene.note(folder=folder)
        scene.add(self.num_written, number=frame, **tables)
        assert self.backend is not None
        self.backend.schedule_together(steps)
        return {each["obj_id"] for each in poses}

    def _objects(
        self, seen: Mapping[str, Any], millimeters: float
    ) -> Iterator[tuple[Placed, Any, np.ndarray, np.ndarray]]:
        """Yield model and pose, the row of its amodal box, and both masks of each object in view."""
        boxes, whole = seen[BOXES_3D], seen[WHOLE]
        ids = seen[INSTANCES]["data"]
        table = class_places.table_of(self._annotator_called(BOXES_3D).label_filter)
        kinds = [boxes["idToLabels"][int(row["semanticId"])] for row in boxes["data"]]
        numbers = class_places.places(table, kinds) + 1
        wide = {int(each): row for each, row in zip(whole["bboxIds"], whole["data"])}
        runs = dict(zip(seen[AMODAL]["instanceIds"].tolist(), seen[AMODAL]["masks"], strict=True))
        for row, path, instance, number, labels in zip(
            boxes["data"], boxes["primPaths"], boxes["bboxIds"].tolist(), numbers.tolist(), kinds
        ):
            if instance not in runs or instance not in wide:
                continue
            name = ",".join(labels.values())
            placed = self._models.place(path, number, name, row["transform"], millimeters)
            if placed is not None:
                amodal = masks.from_runs(runs[instance]["counts"], runs[instance]["size"])
                yield placed, wide[instance], ids == instance, amodal

    def _depth(self, meters: np.ndarray) -> np.ndarray:
        """Return a depth picture, uint16 (H, W); 0 where nothing is hit."""
        steps = np.round(np.where(np.isfinite(meters), meters, 0.0) * files.MILLIMETERS / self._depth_scale)
        if steps.max(initial=0.0) > files.FARTHEST:
            far = files.FARTHEST * self._depth_scale / files.MILLIMETERS
            warn_once(f"BopWriter: what is beyond {far:.3g} m has the depth 0; a larger depth_scale reaches further.")
        return np.where((steps >= 0.0) & (steps <= files.FARTHEST), steps, 0.0).astype(np.uint16)
