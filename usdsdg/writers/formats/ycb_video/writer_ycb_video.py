"""YCBVideoWriter: frames in the form of the YCB-Video dataset, in one video."""

import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.annotators import named_annotators
from usdsdg.annotators.annotator import Annotator
from usdsdg.annotators.prims.labeled_survey import LabeledSurvey
from usdsdg.errors import WriterError, warn_once
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage
from usdsdg.stores.whole_file import write_whole
from usdsdg.writers.aggregate_writer import AggregateWriter
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.group import make_backend
from usdsdg.writers.base import Writer
from usdsdg.writers.files import checked_image_format, write_bytes, write_image, write_parts, write_text
from usdsdg.writers.formats.pose.left_out import LeavesFramesOut, LeftOut
from usdsdg.writers.formats.pose.pose_camera import register_pose_camera
from usdsdg.writers.formats.shapes.camera_projection import camera_matrix
from usdsdg.writers.formats.ycb_video.mat_file import mat_file
from usdsdg.writers.formats.ycb_video.ycb_list import LIST, ROOT, VIDEO, TrainList, frame_name
from usdsdg.writers.formats.ycb_video.ycb_meta import BOXES, CAMERA, DEPTH, INSTANCES, exact_meta, node_meta
from usdsdg.writers.formats.ycb_video.ycb_models import Models, points_file, vertices_in
from usdsdg.writers.formats.ycb_video.ycb_pictures import box_lines, depth_steps, inverse_depth, label_picture
from usdsdg.writers.latest import keep_latest
from usdsdg.writers.options import typed
from usdsdg.writers.registry import get

RGB, TIGHT, CLASSES, POSES = "rgb", "bounding_box_2d_tight", "semantic_segmentation", "pose"
_HALF_PIXEL = np.array([[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])
_CENTER = 0.51  # pixels by which a given center may differ: those who count from the corner are half a pixel off


class YCBVideoWriter(LeavesFramesOut, AggregateWriter):
    """Writes `data/YCB_Video/data/0000/NNNNNN-color.png`, `-depth.png`, `-label.png`, `-box.txt` and `-meta.mat`, as
    far as they are enabled, and `data/YCB_Video/train.txt`, which lists them.

    With `pose`, frames in which no object is visible are left out. The numbers are those of Isaac Sim:
    docs/compatibility.md has what is unexpected of them, and `exact=True` gives those of the dataset. Several render
    products have folders of their own, with folders for kinds of pictures.
    """

    version = "0.0.1"
    data_structure = "renderProduct"
    shares_arrays = True
    kept = ("_frame_id", "_counts")

    @typed
    def __init__(
        self,
        output_dir: str | os.PathLike,
        num_frames: int,
        semantic_types: list[str] | None = None,
        rgb: bool = False,
        bounding_box_2d_tight: bool = False,
        semantic_segmentation: bool = False,
        distance_to_image_plane: bool = False,
        image_output_format: str = "png",
        pose: bool = False,
        class_name_to_index_map: Mapping | None = None,
        factor_depth: int = 10000,
        intrinsic_matrix: np.ndarray | list | None = None,
        *,
        backend: BaseBackend | None = None,
        exact: bool = False,
    ) -> None:
        """
        num_frames: how many frames `train.txt` lists; at the end it lists those that there are.
        semantic_types: types of labels; default ["class"].
        class_name_to_index_map: 1 to 255 for each class, for the label pictures and the poses.
        factor_depth: steps of a depth picture in a meter, 1 to 65535.
        intrinsic_matrix: (3, 3) [pixels]; default that of the camera.
        exact: depth in steps of 1 / `factor_depth` m, poses of rigid models in meters with x right, y down, z ahead,
            the camera's own matrices, `vertmap`, and the models' points in `data/models/<class>/points.xyz`.

        Raises:
            WriterError: an option has an invalid value, or there is nowhere to write.
            OutputNotWritable: output_dir cannot be written to.
        """
        self._indices = _checked_indices(class_name_to_index_map or {})
        if not 0 < factor_depth <= 0xFFFF:
            raise WriterError(f"YCBVideoWriter: factor_depth is {factor_depth}; expected 1 to 65535.")
        self._matrix = _checked_matrix(intrinsic_matrix)
        self._factor, self._exact = factor_depth, exact
        self._image_format = checked_image_format(image_output_format)
        if not exact and (semantic_segmentation or distance_to_image_plane):
            _warn_of_loss(self._image_format)
        self.backend = make_backend("YCBVideoWriter", output_dir, backend)
        self._has_poses = pose
        labels = {"semanticTypes": semantic_types or ["class"]}
        wanted = {
            RGB: (rgb, {}),
            TIGHT: (bounding_box_2d_tight, labels),
            CLASSES: (semantic_segmentation, {**labels, "colorize": False}),
            DEPTH: (distance_to_image_plane or (pose and exact), {}),
            POSES: (pose and not exact, labels),
            CAMERA: (pose, {}),
            BOXES: (pose and exact, labels),
            INSTANCES: (pose and exact, labels),
        }
        self._for_poses = (POSES, CAMERA, BOXES, INSTANCES)
        self._pictures = {RGB: rgb, DEPTH: distance_to_image_plane, CLASSES: semantic_segmentation}
        self._has_boxes = bounding_box_2d_tight
        self.annotators = [named_annotators.get(name, params) for name, (on, params) in wanted.items() if on]
        self._models = Models()
        self._survey: LabeledSurvey | None = None
        self._left_out = LeftOut()
        self._frame_id = 0
        self._list = TrainList(self.backend, "YCBVideoWriter/train")
        if not current().run.is_part:
            self.backend.schedule_after_all(write_parts, path=LIST, texts=partial(_names_up_to, num_frames))

    @staticmethod
    def register_pose_annotator(config_data: Mapping[str, Any]) -> None:
        """Set what the annotator `pose` computes with, for the writers that are initialized from now on.

        config_data: WIDTH and HEIGHT of the pictures [pixels], and CAMERA_ROTATION, the Euler angles [degrees] of the
            rendering camera in the camera frame of the poses. Without this call it is (180, 0, 0): x right, y down,
            z ahead.
        """
        register_pose_camera(POSES, config_data, width="imageWidth", height="imageHeight")

    @staticmethod
    def setup_writer(config_data: Mapping[str, Any], writer_config: Mapping[str, Any]) -> Writer:
        """Return an initialized writer of everything.

        config_data: CLASS_NAME_TO_INDEX, and F_X, F_Y, C_X, C_Y [pixels]. writer_config: output_folder, train_size.
        """
        focal, center = (config_data["F_X"], config_data["F_Y"]), (config_data["C_X"], config_data["C_Y"])
        enabled = ("rgb", "bounding_box_2d_tight", "semantic_segmentation", "distance_to_image_plane", "pose")
        options = {
            "output_dir": writer_config["output_folder"],
            "num_frames": writer_config["train_size"],
            **dict.fromkeys(enabled, True),
            "class_name_to_index_map": config_data["CLASS_NAME_TO_INDEX"],
            "intrinsic_matrix": np.array([[focal[0], 0, center[0]], [0, focal[1], center[1]], [0, 0, 1]]),
        }
        return get("YCBVideoWriter", init_params=options)

    @staticmethod
    def save_mesh_vertices(
        mesh_prim: UsdGeom.Mesh | Usd.Prim, coord_prim: Usd.Prim, model_name: str, output_folder: str | os.PathLike
    ) -> None:
        """Write the vertices of a mesh to `<output_folder>/data/models/<model_name>/points.xyz`, at once.

        coord_prim: in the frame of this prim, in meters.
        """
        path = Path(output_folder, "data", "models", model_name, "points.xyz")
        write_whole(path, points_file(vertices_in(mesh_prim, coord_prim)))

    def annotators_to_skip(self) -> list[Annotator]:
        return [each for each in self.annotators if self._has_poses and each.get_name() in self._for_poses]

    def skip(self, data: dict[str, Any]) -> None:
        self.survey()
        metas = [self._meta(seen, with_map=False) for seen in data["renderProducts"].values() if self._has_poses]
        self._frame_id += self._left_out.note(self._shows_any(metas))

    def receive_made(self, data: dict[str, Any]) -> None:
        super().receive_made(data)
        self.survey()

    def write(self, data: dict[str, Any]) -> None:
        self.survey()
        seen_by = data["renderProducts"]
        metas = {product: self._meta(seen) for product, seen in seen_by.items()} if self._has_poses else {}
        if not self._left_out.note(self._shows_any(list(metas.values()))):
            return
        several = max(len(self.render_products), len(seen_by)) > 1
        steps: list[Callable[..., None]] = []
        for product, seen in seen_by.items():
            steps += self._files(seen, product if several else "", metas.get(product))
        assert self.backend is not None
        with current().io_queue.of_all_frames():
            for name, points in self._models.new.items():
                path = f"data/models/{name}/points.xyz"
                self.backend.schedule(write_bytes, path=path, data=points_file(points))
        self._models.new.clear()
        self.backend.schedule_together(steps)
        self._list.note(list=LIST)
        self._list.add(self.num_written, number=self._frame_id)
        self._frame_id += 1

    def on_final_frame(self) -> None:
        """List the frames that there are, and warn if no frame had an object."""
        self._list.write()
        if self.num_written and not self._frame_id and self.backend is not None:
            keep_latest(self.backend, LIST, "")
            if not current().run.is_part:
                self.backend.schedule_after_all(write_text, path=LIST, text="")
        self._left_out.warn("YCBVideoWriter")

    def survey(self) -> None:
        """Note the shapes of the classes, also of a frame that other processes write."""
        if not (self._has_poses and self._exact):
            return
        stage = current_stage()
        if self._survey is None or self._survey.stage is not stage:
            self._survey = LabeledSurvey(stage, self._annotator_called(BOXES).label_filter)
            self._models.forget_prims()
        self._models.survey(self._survey, self._indices)

    def _shows_any(self, metas: Sequence[Mapping[str, np.ndarray]]) -> bool:
        """Return whether a frame is written: an object is visible, where there are poses."""
        return not self._has_poses or any(meta["cls_indexes"].size for meta in metas)

    def _files(self, seen: Mapping[str, Any], product: str, meta: Mapping[str, Any] | None) -> list[Callable]:
        """Return the steps that write the files of one image; `product` is "" for the only one."""

        def path(kind: str, ending: str) -> str:
            folder = f"{product}/{kind}/" if product and kind else f"{product}/" if product else ""
            return f"{ROOT}/data/{VIDEO}/{folder}{self._frame_id:06d}-{ending}"

        names = {RGB: "color", DEPTH: "depth", CLASSES: "label"}
        steps: list[Callable] = []
        for kind, name in names.items():
            if self._pictures[kind]:
                # Labels and depth of a format that loses detail are wrong, and Isaac Sim writes them so.
                ending = "png" if self._exact and kind != RGB else self._image_format
                picture = self._picture(kind, seen)
                steps.append(partial(write_image, path=path(kind, f"{name}.{ending}"), data=picture))
        if self._has_boxes:
            steps.append(partial(write_text, path=path(TIGHT, "box.txt"), text=box_lines(seen[TIGHT], self._indices)))
        if meta is not None:
            steps.append(partial(write_bytes, path=path("", "meta.mat"), data=mat_file(meta)))
        return steps

    def _picture(self, kind: str, seen: Mapping[str, Any]) -> np.ndarray:
        if kind == CLASSES:
            return label_picture(seen[CLASSES], self._indices)
        if kind == DEPTH:
            meters = seen[DEPTH]["data"]
            return depth_steps(meters, self._factor) if self._exact else inverse_depth(meters)
        return np.asarray(seen[RGB]["data"])

    def _meta(self, seen: Mapping[str, Any], *, with_map: bool = True) -> dict[str, np.ndarray]:
        factor = {"factor_depth": np.array([self._factor], np.uint16)}
        own = camera_matrix(seen[CAMERA])
        if not self._exact:
            # Without a matrix, that of the camera; pixels of this form count from the corner of the image.
            matrix = own + _HALF_PIXEL if self._matrix is None else self._matrix
            return node_meta(seen[POSES], self._indices) | factor | {"intrinsic_matrix": matrix}
        if self._matrix is not None and np.abs(self._matrix - own).max() > _CENTER:
            warn_once(
                f"YCBVideoWriter: intrinsic_matrix {self._matrix.tolist()} is not that of the camera, "
                f"{own.round(3).tolist()}, which is written with exact=True."
            )
        return exact_meta(seen, self._indices, self._models, with_map=with_map) | factor


def _names_up_to(count: int) -> list[str]:
    return [frame_name(number) for number in range(count)]


def _warn_of_loss(image_format: str) -> None:
    """Warn of labels and depths in a format that changes them, as Isaac Sim writes them."""
    if image_format in ("jpg", "jpeg"):
        warn_once(
            f"YCBVideoWriter: image_output_format {image_format!r} changes the classes of `-label` pictures and the "
            "grays of `-depth` pictures, so that they are wrong. Use 'png', or exact=True, which has color alone in "
            f"{image_format}."
        )


def _checked_indices(given: Mapping[Any, Any]) -> dict[str, int]:
    """Return the index of each class, in lower case, as labels are.

    Raises:
        WriterError: one does not fit into a label picture.
    """
    for name, index in given.items():
        if not isinstance(index, (int, np.integer)) or not 0 < index <= 0xFF:
            raise WriterError(f"YCBVideoWriter: class_name_to_index_map has {name!r}: {index!r}; expected 1 to 255.")
    return {str(name).lower(): int(index) for name, index in given.items()}


def _checked_matrix(given: Any) -> np.ndarray | None:
    if given is None:
        return None
    matrix = np.asarray(given, np.float64)
    if matrix.shape != (3, 3):
        raise WriterError(f"YCBVideoWriter: intrinsic_matrix has the shape {matrix.shape}; expected (3, 3).")
    if not np.isfinite(matrix).all():
        raise WriterError(f"YCBVideoWriter: intrinsic_matrix is {matrix.tolist()}; expected finite numbers.")
    return matrix
