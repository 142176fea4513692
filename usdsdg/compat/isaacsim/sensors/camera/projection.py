"""Projection of points through a pinhole camera, with matrices for column vectors as robotics uses them.

The camera's frame is ROS's: +X right, +Y down, +Z ahead. Pixel u has its center at u + 0.5.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.compat.isaacsim.sensors.camera.lens_attributes import LensAttributes
from usdsdg.compat.wrappers.arrays import as_backend, as_numpy
from usdsdg.errors import ArgumentError
from usdsdg.session.timeline import stage_time
from usdsdg.stage.cameras.camera_view import CameraView, read_camera

if TYPE_CHECKING:
    from usdsdg.compat.wrappers.arrays import Values

Floats = NDArray[np.float32]
_ROS_FROM_USD = np.diag([1.0, -1.0, -1.0, 1.0])


class Projection(LensAttributes):
    """Matrices and projections of a camera prim; arrays are float32, in the form of the backend.

    They are those of the camera's images: at the time of the timeline, with apertures' offsets, without the scale of
    prims above. All but the view matrix and the fields of view raise ArgumentError for cameras with lens distortion
    that is no pinhole's; distortion itself is not applied.
    """

    def get_view_matrix_ros(self, device: str | None = None, backend_utils_cls: object = None) -> Floats:
        """Return the matrix (4, 4) from the world to the camera, for column vectors."""
        return self._out(self._view_matrix(), device)

    def get_intrinsics_matrix(self, device: str | None = None, backend_utils_cls: object = None) -> Floats:
        """Return [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] [pixels].

        Raises:
            ArgumentError: the camera's lens is no pinhole.
        """
        return self._out(self._intrinsics("get_intrinsics_matrix"), device)

    def get_image_coords_from_world_points(self, points_3d: Values) -> Floats:
        """Project points of the world (N, 3) to pixels (N, 2), also those behind the camera.

        Raises:
            ArgumentError: the camera's lens is no pinhole.
        """
        points = as_numpy(points_3d).reshape(-1, 3)
        view = self._view_matrix()
        seen = (points @ view[:3, :3].T + view[:3, 3]) @ self._intrinsics("get_image_coords_from_world_points").T
        return self._out(seen[:, :2] / seen[:, 2:], None)

    def get_camera_points_from_image_coords(
        self, points_2d: Values, depth: Values, device: str | None = None, backend_utils_cls: object = None
    ) -> Floats:
        """Return the points (N, 3) in the camera's frame of pixels (N, 2) at depths (N,) along the axis.

        Raises:
            ArgumentError: the camera's lens is no pinhole.
        """
        return self._out(self._camera_points(points_2d, depth), device)

    def get_world_points_from_image_coords(
        self, points_2d: Values, depth: Values, device: str | None = None, backend_utils_cls: object = None
    ) -> Floats:
        """Return the points (N, 3) in the world of pixels (N, 2) at depths (N,) along the axis.

        Raises:
            ArgumentError: the camera's lens is no pinhole.
        """
        return self._out(self._to_world(self._camera_points(points_2d, depth)), device)

    def get_horizontal_fov(self) -> float:
        """Return the horizontal field of view [radians]."""
        return 2 * math.atan(self.get_horizontal_aperture() / (2 * self.get_focal_length()))

    def get_vertical_fov(self) -> float:
        """Return the horizontal field of view times height / width [radians], as Isaac Sim does: an approximation."""
        width, height = self.get_resolution()
        return self.get_horizontal_fov() * height / width

    def _camera_view(self) -> CameraView:
        """Return the camera as its images show the stage now."""
        stage = self.prim.GetStage()
        return read_camera(stage, self.prim.GetPath(), self.get_resolution(), time=stage_time(stage))

    def _view_matrix(self) -> NDArray[np.float64]:
        # Without the scale of what is above the camera, which images do not follow.
        return _ROS_FROM_USD @ self._camera_view().world_to_camera.T

    def _intrinsics(self, what: str) -> NDArray[np.float64]:
        view = self._camera_view()
        if "pinhole" not in view.projection_type and view.projection_type != "orthographic":
            raise ArgumentError(
                f"{self.prim.GetPath()}: {what} needs a pinhole camera; its projection is {view.projection_type!r}"
            )
        (fx, fy), (cx, cy) = (view.fx, view.fy), (view.cx, view.cy)
        if view.lens is not None:
            (fx, fy), (cx, cy) = view.lens.focal, view.lens.center
        elif view.projection_type == "orthographic":
            fx, fy = self._focal_pixels(view.width, view.height)
        return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])

    def _camera_points(self, points_2d: Values, depth: Values) -> NDArray[np.float64]:
        pixels = np.insert(as_numpy(points_2d).reshape(-1, 2).astype(np.float64), 2, 1.0, axis=1)
        inverse = np.linalg.inv(self._intrinsics("get_camera_points_from_image_coords"))
        with np.errstate(invalid="ignore"):  # where nothing is hit
            return (pixels @ inverse.T) * as_numpy(depth).reshape(-1, 1)

    def _to_world(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        back = np.linalg.inv(self._view_matrix())
        with np.errstate(invalid="ignore"):
            return points @ back[:3, :3].T + back[:3, 3]

    def _out(self, array: np.ndarray, device: str | None) -> Floats:
        """Return float32 in the form of the backend; torch for another device than the CPU."""
        state = simulation()
        backend = "torch" if device is not None and device != "cpu" else state.backend
        return as_backend(array.astype(np.float32), backend, device or state.device)
