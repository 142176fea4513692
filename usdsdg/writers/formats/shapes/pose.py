"""The pose of one object from a row of bounding_box_3d, in the frames of pose files."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from pxr import Gf

from usdsdg.errors import warn_once
from usdsdg.writers.formats.shapes import cuboid
from usdsdg.writers.formats.shapes.camera_projection import clip_to_front, has_near_plane, project

_MOST_SHEAR = 1e-4  # cosine of the angle between axes, which are 32-bit numbers


class Pose:
    """The 3D box of one object in its own, the world's and the camera's frame."""

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

    def axes_in_camera(self) -> np.ndarray:
        """Return segments (3, 2, 3) from the center along the object's axes, each a quarter of its mean size."""
        ends = self.center_local + np.eye(3) * self.size_local.mean() * 0.25
        segments = np.stack([np.broadcast_to(self.center_local, (3, 3)), ends], axis=1)
        return _transformed(segments.reshape(-1, 3), self.local_to_camera).reshape(3, 2, 3)


def _transformed(points: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    return points @ matrix[:3, :3] + matrix[3, :3]


def _factored(matrix: np.ndarray) -> Gf.Transform:
    transform = Gf.Transform()
    transform.SetMatrix(Gf.Matrix4d(matrix.tolist()))
    return transform


def quaternion(matrix: np.ndarray) -> tuple[float, list[float]]:
    """Return real and imaginary part of the rotation in `matrix`, without scale and shear."""
    quaternion = _factored(matrix).GetRotation().GetQuat()
    return quaternion.GetReal(), list(quaternion.GetImaginary())


def warn_unless_rigid(writer: str, prim_path: str, pose: Pose) -> None:
    """Warn of an object whose axes no rotation turns to where they are."""
    axes = pose.local_to_world[:3, :3]
    lengths = np.linalg.norm(axes, axis=1, keepdims=True)
    if not np.isfinite(axes).all() or (lengths <= 0).any():
        return
    axes = axes / lengths
    sheared = np.abs(axes @ axes.T - np.eye(3)).max() > _MOST_SHEAR
    if sheared or np.linalg.det(axes) < 0:
        warn_once(
            f"{writer}: {prim_path} is {'sheared' if sheared else 'mirrored'} by its transform, so its quaternion does "
            "not turn its box to its keypoints. Scale it by positive numbers, along its own axes."
        )


def truncation_ratio(pose: Pose, pixels: np.ndarray, camera: Mapping[str, Any]) -> float:
    """Return the fraction of the box's bounding rectangle that is outside the image."""
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
