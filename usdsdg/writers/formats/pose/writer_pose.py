"""PoseWriter: one image and one JSON of object poses per frame, for training pose estimators."""

import os
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.annotators.annotator import Annotator
from usdsdg.errors import WriterError, counted, warn_once
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.group import make_backend
from usdsdg.writers.base import Writer
from usdsdg.writers.files import checked_image_format, checked_padding, write_image, write_json
from usdsdg.writers.formats.pose.intrinsics import intrinsics
from usdsdg.writers.formats.pose.pose_overlay import PosedBox, draw_overlay
from usdsdg.writers.formats.shapes import cuboid, drawing
from usdsdg.writers.formats.shapes.camera_projection import project
from usdsdg.writers.formats.shapes.pose import Pose, quaternion, truncation_ratio, warn_unless_rigid
from usdsdg.writers.options import typed

RGB, BOXES, CAMERA = "rgb", "bounding_box_3d_fast", "camera_params"
FORMATS = ("dope", "centerpose")

ORDER_DEFAULT = (cuboid.CENTER, *cuboid.CORNERS)
ORDER_DOPE = ("LUF", "RUF", "RDF", "LDF", "LUB", "RUB", "RDB", "LDB", cuboid.CENTER)


class PoseWriter(Writer):
    """Writes `NNNNNN.png`, `NNNNNN.json` and, for debugging, `NNNNNN_overlay.png`.

    Matrices are for row vectors. In `location_camera_frame`, `rotation_matrix_camera_frame`, `location` and their
    quaternions, world-to-camera is multiplied on the left of local-to-world, as in Replicator's files; keypoints use
    the correct order. `exact_camera_frame=True` uses it for all of them (docs/conventions.md).
    """

    version = "0.2.0"
    data_structure = "renderProduct"
    shares_arrays = True
    only_stores_pictures = True
    kept = ("_frame_id", "_images", "_skipped")

    @typed
    def __init__(
        self,
        output_dir: str | os.PathLike | None = None,
        use_subfolders: bool = False,
        visibility_threshold: float = 0.0,
        skip_empty_frames: bool = True,
        write_debug_images: bool = False,
        frame_padding: int = 6,
        format: str | None = None,
        use_s3: bool = False,
        s3_bucket: str | None = None,
        s3_endpoint_url: str | None = None,
        s3_region: str | None = None,
        backend: BaseBackend | None = None,
        image_output_format: str = "png",
        *,
        exact_camera_frame: bool = False,
    ) -> None:
        """
        use_subfolders: one folder per render product, with common frame numbers.
        visibility_threshold: objects are left out unless a larger fraction is visible.
        skip_empty_frames: write nothing for an image without objects.
        format: None, "dope" or "centerpose".
        use_s3: write to the bucket `s3_bucket`, below `output_dir` as a prefix; s3_endpoint_url, s3_region: see
            `S3Backend`.
        exact_camera_frame: poses in the camera's frame that match keypoints and image, instead of Replicator's.

        Raises:
            WriterError: an option has an invalid value, or there is nowhere to write.
            OutputNotWritable: output_dir or the bucket cannot be written to.
            Unsupported: a bucket without obstore.
        """
        self._format = _checked_format(format)
        self._image_format = checked_image_format(image_output_format)
        if use_s3 and not s3_bucket:
            raise WriterError("PoseWriter: use_s3 needs a bucket; give s3_bucket.")
        bucket = s3_bucket if use_s3 else None
        self.backend = make_backend(
            "PoseWriter", output_dir, backend, bucket=bucket, region=s3_region, endpoint_url=s3_endpoint_url
        )
        self._use_subfolders = use_subfolders
        self._threshold = visibility_threshold
        self._skip_empty = skip_empty_frames
        self._debug = write_debug_images
        self._padding = checked_padding(frame_padding)
        self._exact = exact_camera_frame
        self._order = ORDER_DOPE if self._format == "dope" else ORDER_DEFAULT
        self._frame_id = 0
        self._images = self._skipped = 0
        self.annotators = [
            named_annotators.get(RGB),
            named_annotators.get(BOXES, init_params={"semanticTypes": ["class"]}),
            named_annotators.get(CAMERA),
        ]

    def get_current_frame_id(self) -> int:
        """Return the number of the next image."""
        return self._frame_id

    def annotators_to_skip(self) -> list[Annotator]:
        return [each for each in self.annotators if self._skip_empty and each.get_name() in (BOXES, CAMERA)]

    def skip(self, data: dict[str, Any]) -> None:
        for seen in data["renderProducts"].values():
            is_left_out = self._skip_empty and not self._read_objects(seen)[0]
            self._images += 1
            self._skipped += is_left_out
            self._frame_id += not (is_left_out or self._use_subfolders)
        self._frame_id += self._use_subfolders

    def write(self, data: dict[str, Any]) -> None:
        for product, seen in data["renderProducts"].items():
            objects, drawn = self._read_objects(seen)
            self._images += 1
            if not objects and self._skip_empty:
                self._skipped += 1
                continue
            folder = f"{product}/" if self._use_subfolders else ""
            self._write_frame(f"{folder}{self._frame_id:0{self._padding}d}", seen, objects, drawn)
            if not self._use_subfolders:
                self._frame_id += 1
        if self._use_subfolders:
            self._frame_id += 1

    def on_final_frame(self) -> None:
        """Warn if no image had an object, so that nothing was written."""
        if self._images and self._skipped == self._images:
            warn_once(
                f"PoseWriter wrote none of {counted(self._images, 'image')}, since no labeled object is visible in "
                "any; skip_empty_frames=False writes them anyway"
            )

    def _write_frame(
        self, stem: str, seen: Mapping[str, Any], objects: list[dict[str, Any]], drawn: list[PosedBox]
    ) -> None:
        camera, rgb = seen[CAMERA], seen[RGB]["data"]
        described = {"camera_data": self._camera_data(camera), "keypoint_order": list(self._order), "objects": objects}
        steps = [partial(write_image, path=f"{stem}.{self._image_format}", data=rgb)]
        if self._debug:
            drawing.load()  # a thread that writes cannot once the program is ending
            overlay = f"{stem}_overlay.{self._image_format}"
            steps.append(partial(_write_overlay, path=overlay, image=rgb, boxes=drawn, params=camera))
        # JSON last, so that a frame with JSON has its images.
        steps.append(partial(write_json, path=f"{stem}.json", data=described, indent=2))
        assert self.backend is not None
        self.backend.schedule_together(steps)

    def _camera_data(self, camera: Mapping[str, Any]) -> dict[str, Any]:
        width, height = (int(size) for size in camera["renderProductResolution"])
        projection = np.asarray(camera["cameraProjection"], np.float64).reshape(4, 4)
        view = np.asarray(camera["cameraViewTransform"], np.float64).reshape(4, 4)
        described: dict[str, Any] = {}
        if self._format is None:
            described["aperture"] = camera["cameraAperture"].tolist()
            described["aperture_offset"] = camera["cameraApertureOffset"].tolist()
            described["focal_length"] = float(camera["cameraFocalLength"])
            described["resolution"] = [width, height]
            described["meters_per_scene_unit"] = float(camera["metersPerSceneUnit"])
        described["intrinsics"] = intrinsics("PoseWriter", camera)
        described["camera_view_matrix"] = np.round(view, 5).tolist()
        described["camera_projection_matrix"] = np.round(projection, 5).tolist()
        if self._format == "centerpose":
            described["width"], described["height"] = width, height
        return described

    def _read_objects(self, seen: Mapping[str, Any]) -> tuple[list[dict[str, Any]], list[PosedBox]]:
        """Return the visible objects as JSON records and as the overlay draws them."""
        boxes, camera = seen[BOXES], seen[CAMERA]
        objects, drawn = [], []
        for row, prim_path in zip(boxes["data"], boxes["primPaths"]):
            visibility = 1.0 - abs(float(row["occlusionRatio"]))
            # `not >`, so that nan (out of view) is left out too.
            if not visibility > self._threshold:
                continue
            label = boxes["idToLabels"][int(row["semanticId"])]["class"]
            pose = Pose(row, camera, self._order)
            warn_unless_rigid("PoseWriter", prim_path, pose)
            head = {
                "class" if self._format == "dope" else "label": label,
                "prim_path": prim_path,
                "visibility": round(visibility, 3),
            }
            objects.append(head | self._described(pose, camera))
            drawn.append(PosedBox(pose.in_camera, pose.axes_in_camera()))
        return objects, drawn

    def _described(self, pose: Pose, camera: Mapping[str, Any]) -> dict[str, Any]:
        to_camera = pose.local_to_camera if self._exact else pose.world_to_camera @ pose.local_to_world
        real, imaginary = quaternion(to_camera)
        size = (pose.size_local * pose.world_scale).tolist()
        world = [point.tolist() for point in pose.in_world.values()]
        in_camera = [point.tolist() for point in pose.in_camera.values()]
        pixels = [[int(x), int(y)] for x, y in np.rint(project(np.array(in_camera), camera))]
        if self._format is None:
            world_real, world_imaginary = quaternion(pose.local_to_world)
            described = {
                "local_to_world_transform": pose.local_to_world.tolist(),
                "location_world_frame": pose.local_to_world[3, :3].tolist(),
                "rotation_matrix_world_frame": pose.local_to_world[:3, :3].tolist(),
                "quat_wxyz_world_frame": [world_real, *world_imaginary],
                "location_camera_frame": to_camera[3, :3].tolist(),
                "rotation_matrix_camera_frame": to_camera[:3, :3].tolist(),
                "quat_wxyz_camera_frame": [real, *imaginary],
                "size": size,
                "cuboid_keypoints_world_frame": world,
                "cuboid_keypoints_camera_frame": in_camera,
                "cuboid_keypoints_projected": pixels,
            }
        else:
            described = {"location": to_camera[3, :3].tolist(), "quaternion_xyzw": [*imaginary, real]}
            if self._format == "centerpose":
                described |= {"scale": size, "keypoints_3d": in_camera}
            described["projected_cuboid"] = pixels
        described["truncation_ratio"] = truncation_ratio(pose, np.array(pixels), camera)
        return described


def _checked_format(format: str | None) -> str | None:
    if format is not None and format.lower() not in FORMATS:
        raise WriterError(f"PoseWriter: format {format!r} does not exist; use None, {' or '.join(map(repr, FORMATS))}.")
    return None if format is None else format.lower()


def _write_overlay(
    path: str, image: np.ndarray, boxes: list[PosedBox], params: Mapping[str, Any], backend_instance: Any
) -> None:
    write_image(path, draw_overlay(image, boxes, params), backend_instance)
