"""Images of a `Camera`, and the points that it sees."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from usdsdg.annotators.annotator import Annotator
from usdsdg.compat.isaacsim.sensors.camera.frame_annotators import FrameAnnotators
from usdsdg.compat.isaacsim.sensors.camera.projection import Projection
from usdsdg.errors import warn_once
from usdsdg.session.session import current
from usdsdg.stage.cameras.pixels import pixel_centers

if TYPE_CHECKING:
    import warp as wp

    Image = np.ndarray | wp.array


class CameraImages(FrameAnnotators, Projection):
    """Reads images from the annotators of the camera's frames."""

    def get_rgba(self, device: str | None = None) -> Image | None:
        """Return color, uint8 (H, W, 4); None before the first update, or without the annotator."""
        return self._image("rgb", 3, device)

    def get_rgb(self, device: str | None = None) -> Image | None:
        """Return color, uint8 (H, W, 3); None before the first update, or without the annotator."""
        image = self._image("rgb", 3, device)
        return None if image is None else image[:, :, :3]

    def get_depth(self, device: str | None = None) -> Image | None:
        """Return the distance along the optical axis [m], float32 (H, W); +inf where nothing is hit.

        None before the first update, or without the annotator distance_to_image_plane.
        """
        return self._image("distance_to_image_plane", 2, device)

    def get_pointcloud(self, device: str | None = None, world_frame: bool = True) -> np.ndarray:
        """Return points (N, 3) [m in the camera's frame and without the annotator; else stage units].

        They are those of the annotator pointcloud where it is attached, in the world or in the camera's frame (ROS's
        axes); else those of all pixels by their depth, also with a pinhole's distortion. Empty before the first update.

        Raises:
            ArgumentError: the annotator is not attached, and the camera's lens is no pinhole.
        """
        annotator = self._custom_annotators.get("pointcloud")
        if annotator is not None:
            points = annotator.get_data(device="cpu")["data"] if annotator_has_data(annotator) else np.array([])
            if world_frame or not points.size:
                return points
            view = self._view_matrix()
            return (points @ view[:3, :3].T + view[:3, 3]).astype(np.float32)
        depth = self.get_depth(device="cpu")
        if depth is None:
            return np.array([])
        self._intrinsics("get_pointcloud")  # which a lens whose depths along the axis tell no points has not
        view = self._camera_view()
        rows, columns = np.indices(depth.shape)
        origins, along = view.rays(pixel_centers(columns.ravel(), rows.ravel()))
        with np.errstate(invalid="ignore"):  # where nothing is hit
            # Stage units along the axis; y and z of ROS are those of USD turned around.
            depths = np.asarray(depth, np.float64).reshape(-1, 1) / view.meters_per_unit
            points = (origins + along / -along[:, 2:] * depths) * (1.0, -1.0, -1.0)
        return (self._to_world(points) if world_frame else points * view.meters_per_unit).astype(np.float32)

    def _image(self, key: str, dimensions: int, device: str | None) -> Any:
        annotator = self._custom_annotators.get(key)
        if annotator is None:
            warn_once(f"Camera {self.prim_path}: annotator {key} is not attached, so there is no image of it")
            return None
        image = annotator.get_data(device=device)
        return image if image.ndim == dimensions else None


def annotator_has_data(annotator: Annotator) -> bool:
    """Return whether the annotator has a frame, after taking the latest update into account."""
    current().live.refresh(annotator)
    return annotator.has_data
