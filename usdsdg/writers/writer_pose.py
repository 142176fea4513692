"""PoseWriter: one picture and one JSON of object poses per frame, for training pose estimators."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from pxr import Gf

from usdsdg.annotators import catalogue
from usdsdg.errors import Unsupported, WriterError
from usdsdg.writers import cuboid
from usdsdg.writers.backends import BackendDispatch, BackendGroup, BaseBackend
from usdsdg.writers.base import Writer
from usdsdg.writers.files import write_image, write_json
from usdsdg.writers.pose_overlay import PosedBox, draw_overlay
from usdsdg.writers.projection import clip_to_front, has_near_plane, project

RGB, BOXES, CAMERA = "rgb", "bounding_box_3d_fast", "camera_params"
FORMATS = ("dope", "centerpose")
IMAGE_FORMATS = ("png", "jpg", "jpeg")

ORDER_DEFAULT = (cuboid.CENTER, *cuboid.CORNERS)
ORDER_DOPE = ("LUF", "RUF", "RDF", "LDF", "LUB", "RUB", "RDB", "LDB", cuboid.CENTER)


class PoseWriter(Writer):
    """Writes `NNNNNN.png`, `NNNNNN.json` and, for debugging, `NNNNNN_overlay.png`.

    Matrices are for row vectors. In `location_camera_frame`, `rotation_matrix_camera_frame`, `location` and their
    quaternions, world-to-camera stands left of local-to-world, as in Replicator's files, which is right only for cameras
    without rotation; keypoints are multiplied in the right order. `exact_camera_frame=True` makes all of them right.
    """

    version = "0.2.0"
    data_structure = "renderProduct"

    def __init__(
        self,
        output_dir: str | None = None,
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
        use_subfolders: one folder per render product, which then share frame numbers.
        visibility_threshold: objects of which no larger share is visible are left out.
        skip_empty_frames: write nothing for a picture without objects.
        format: None, "dope" or "centerpose".

        Raises:
            WriterError: an option has a value that does not exist, or there is nowhere to write.
            OutputNotWritable: output_dir cannot be written to.
        """
        self._format = _checked_format(format)
        self._image_format = _checked_image_format(image_output_format)
        self.backend = make_backend(
            "PoseWriter", output_dir, backend, bucket=s3_bucket or "?" if use_s3 else None, region=s3_region
        )
        self._use_subfolders = use_subfolders
        self._threshold = visibility_threshold
        self._skip_empty = skip_empty_frames
        self._debug = write_debug_images
        self._padding = frame_padding
        self._exact = exact_camera_frame
        self._order = ORDER_DOPE if self._format == "dope" else ORDER_DEFAULT
        self._frame_id = 0
        self.annotators = [
            catalogue.get(RGB),
            catalogue.get(BOXES, init_params={"semanticTypes": ["class"]}),
            catalogue.get(CAMERA),
        ]

    def get_current_frame_id(self) -> int:
        """The number that the next picture gets."""
        return self._frame_id

    def write(self, data: dict[str, Any]) -> None:
        for product, seen in data["renderProducts"].items():
            objects, drawn = self._read_objects(seen)
            if not objects and self._skip_empty:
                continue
            folder = f"{product}/" if self._use_subfolders else ""
            self._write_frame(f"{folder}{self._frame_id:0{self._padding}d}", seen, objects, drawn)
            if not self._use_subfolders:
                self._frame_id += 1
        if self._use_subfolders:
            self._frame_id += 1

    def detach(self) -> None:
        super().detach()
        self._frame_id = 0

    def _write_frame(
        self, stem: str, seen: Mapping[str, Any], objects: list[dict[str, Any]], drawn: list[PosedBox]
    ) -> None:
        camera, rgb = seen[CAMERA], seen[RGB]["data"]
        described = {
            "camera_data": self._camera_data(camera),
            "keypoint_order": list(self._order),
            "objects": objects,
        }
        steps = [partial(write_image, path=f"{stem}.{self._image_format}", data=rgb)]
        if self._debug:
            overlay = f"{stem}_overlay.{self._image_format}"
            steps.append(partial(_write_overlay, path=overlay, image=rgb, boxes=drawn, params=camera))
        # The JSON comes last: a frame that has one has its pictures.
        steps.append(partial(write_json, path=f"{stem}.json", data=described, indent=2))
        assert self.backend is not None
        self.backend.schedule_together(steps)

    def _camera_data(self, camera: Mapping[str, Any]) -> dict[str, Any]:
        width, height = (int(size) for size in camera["renderProductResolution"])
        projection = np.asarray(camera["cameraProjection"], np.float64).reshape(4, 4)
        view = np.asarray(camera["cameraViewTransform"], np.float64).reshape(4, 4)
        focal = float(camera["cameraFocalLength"]) / (float(camera["cameraAperture"][0]) / width)
        described: dict[str, Any] = {}
        if self._format is None:
            described["aperture"] = camera["cameraAperture"].tolist()
            described["aperture_offset"] = camera["cameraApertureOffset"].tolist()
            described["focal_length"] = float(camera["cameraFocalLength"])
            described["resolution"] = [width, height]
            described["meters_per_scene_unit"] = float(camera["metersPerSceneUnit"])
        described["intrinsics"] = {
            "fx": focal,
            "fy": focal,
            # Where the optical axis meets the picture; the middle unless the aperture is shifted.
            "cx": float((1 - projection[2, 0]) * width / 2),
            "cy": float((1 + projection[2, 1]) * height / 2),
        }
        described["camera_view_matrix"] = np.round(view, 5).tolist()
        described["camera_projection_matrix"] = np.round(projection, 5).tolist()
        if self._format == "centerpose":
            described["width"], described["height"] = width, height
        return described

    def _read_objects(self, seen: Mapping[str, Any]) -> tuple[list[dict[str, Any]], list[PosedBox]]:
        """The visible objects, as the JSON tells them and as the overlay draws them."""
        boxes, camera = seen[BOXES], seen[CAMERA]
        objects, drawn = [], []
        for row, prim_path in zip(boxes["data"], boxes["primPaths"]):
            visibility = 1.0 - abs(float(row["occlusionRatio"]))
            # Written so that the nan of something out of view does not pass.
            if not visibility > self._threshold:
                continue
            label = boxes["idToLabels"][int(row["semanticId"])]["class"]
            pose = _Pose(row, camera, self._order)
            head = {
                "class" if self._format == "dope" else "label": label,
                "prim_path": prim_path,
                "visibility": round(visibility, 3),
            }
            objects.append(head | self._described(pose, camera))
            drawn.append(PosedBox(pose.in_camera, pose.axes_in_camera()))
        return objects, drawn

    def _described(self, pose: _Pose, camera: Mapping[str, Any]) -> dict[str, Any]:
        to_camera = pose.local_to_camera if self._exact else pose.world_to_camera @ pose.local_to_world
        real, imaginary = _quaternion(to_camera)
        size = (pose.size_local * pose.world_scale).tolist()
        world = [point.tolist() for point in pose.in_world.values()]
        in_camera = [point.tolist() for point in pose.in_camera.values()]
        pixels = [[int(x), int(y)] for x, y in np.rint(project(np.array(in_camera), camera))]
        if self._format is None:
            world_real, world_imaginary = _quaternion(pose.local_to_world)
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
        described["truncation_ratio"] = _truncation(pose, np.array(pixels), camera)
        return described


class _Pose:
    """One object: its box in the frames that the file names."""

    def __init__(self, row: np.void, camera: Mapping[str, Any], order: Sequence[str]) -> None:
        self.local_to_world = row["transform"].astype(np.float64)
        self.world_to_camera = np.asarray(camera["cameraViewTransform"], np.float64).reshape(4, 4)
        self.local_to_camera = self.local_to_world @ self.world_to_camera
        low = np.array([row[f"{axis}_min"] for axis in "xyz"], np.float64)
        high = np.array([row[f"{axis}_max"] for axis in "xyz"], np.float64)
        named = cuboid.keypoints(low, high)
        local = np.array([named[name] for name in order])
        world = _transformed(local, self.local_to_world)
        self.center_local, self.size_local = (low + high) / 2, high - low
        self.world_scale = np.abs(np.array(_factored(self.local_to_world).GetScale()))
        self.in_world = dict(zip(order, world))
        self.in_camera = dict(zip(order, _transformed(world, self.world_to_camera)))

    def axes_in_camera(self, share: float = 0.25) -> np.ndarray:
        """(3, 2, 3) from the centre along the object's axes, for `share` of its mean size."""
        ends = self.center_local + np.eye(3) * self.size_local.mean() * share
        segments = np.stack([np.broadcast_to(self.center_local, (3, 3)), ends], axis=1)
        return _transformed(segments.reshape(-1, 3), self.local_to_camera).reshape(3, 2, 3)


def make_backend(
    writer: str, output_dir: Any, backend: BaseBackend | None, *, bucket: str | None = None, region: str | None = None
) -> BaseBackend:
    """Where a writer writes: the backend given, the folder, or both.

    Raises:
        WriterError: neither is given, or the backend is none.
    """
    if backend is not None and not isinstance(backend, BaseBackend):
        raise WriterError(
            f"{writer}: backend must be a BaseBackend, such as backends.get('DiskBackend'); got {backend!r}."
        )
    folder = BackendDispatch(output_dir=output_dir, bucket=bucket, region=region) if output_dir or bucket else None
    if folder is None and backend is None:
        raise WriterError(f"{writer} has nowhere to write: give output_dir, or backend.")
    if folder is None or backend is None:
        return backend or folder  # type: ignore[return-value]
    known = backend._backends if isinstance(backend, BackendGroup) else [backend]
    return BackendGroup([*known, *folder._backends])


def _checked_format(format: str | None) -> str | None:
    if format is not None and format.lower() not in FORMATS:
        raise WriterError(f"PoseWriter: format {format!r} does not exist; use None, {' or '.join(map(repr, FORMATS))}.")
    return None if format is None else format.lower()


def _checked_image_format(name: str) -> str:
    known = (name or "").lower()
    if known == "exr":
        raise Unsupported(
            "image_output_format 'exr' needs the extra 'exr', which this version does not have; use 'png'."
        )
    if known not in IMAGE_FORMATS:
        raise WriterError(f"image_output_format {name!r} does not exist; use {', '.join(map(repr, IMAGE_FORMATS))}.")
    return known


def _write_overlay(
    path: str, image: np.ndarray, boxes: list[PosedBox], params: Mapping[str, Any], backend_instance: Any
) -> None:
    write_image(path, draw_overlay(image, boxes, params), backend_instance)


def _transformed(points: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    return points @ matrix[:3, :3] + matrix[3, :3]


def _factored(matrix: np.ndarray) -> Gf.Transform:
    transform = Gf.Transform()
    transform.SetMatrix(Gf.Matrix4d(matrix.tolist()))
    return transform


def _quaternion(matrix: np.ndarray) -> tuple[float, list[float]]:
    """Real and imaginary part of the rotation in `matrix`, scale and shear taken out."""
    quaternion = _factored(matrix).GetRotation().GetQuat()
    return quaternion.GetReal(), list(quaternion.GetImaginary())


def _truncation(pose: _Pose, pixels: np.ndarray, camera: Mapping[str, Any]) -> float:
    """Share of the box's bounding rectangle that lies outside the picture."""
    if has_near_plane(camera):
        edges = cuboid.edge_segments(pose.in_camera)
        in_front = clip_to_front(edges, camera)
        if not len(in_front):
            return 1.0
        if not np.array_equal(in_front, edges):
            pixels = project(in_front, camera)
    size = np.asarray(camera["renderProductResolution"], np.float64)
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    whole = float(np.prod(high - low))
    inside = float(np.prod(np.clip(high, 0, size) - np.clip(low, 0, size)))
    return 1 - inside / whole if whole > 0 else 1.0
