"""The camera of a page: it orbits a point, and makes views of any size."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from usdsdg.stage.cameras.camera_view import CameraView

# A turn across the height of the picture [radians], and how near to the poles the camera comes.
_TURN = math.pi
_POLE = math.radians(89.5)
# Focal length of a page's camera, in tenths of stage units, for an aperture of the same: 35 mm film at 50 mm.
FOCAL_LENGTH, APERTURE = 50.0, 36.0
# Clipping planes, as parts of the distance to the target.
_NEAR, _FAR = 1e-3, 1e5
# Smallest and largest distance, as parts of the size of the scene.
_CLOSEST, _FARTHEST = 1e-4, 1e3


@dataclass(frozen=True)
class Orbit:
    """A camera at `distance` from `target`, in the direction of `azimuth` about the up axis and `elevation` above it.

    Lengths are in stage units, angles in radians. `axes` are (3, 3) right, front and up of the stage.
    """

    target: tuple[float, float, float]
    distance: float
    azimuth: float
    elevation: float
    axes: np.ndarray
    size: float  # of the scene: a diagonal of its bounds

    @classmethod
    def looking(cls, eye: np.ndarray, target: np.ndarray, axes: np.ndarray, *, size: float) -> Orbit:
        """Return the orbit through `eye` about `target`, both (3,)."""
        away = (np.asarray(eye, float) - target) @ np.asarray(axes).T
        distance = float(np.linalg.norm(away)) or size or 1.0
        azimuth, elevation = math.atan2(away[0], away[1]), math.asin(np.clip(away[2] / distance, -1.0, 1.0))
        x, y, z = map(float, target)
        return cls((x, y, z), distance, azimuth, elevation, axes, size).within_limits()

    def turned(self, across: float, up: float) -> Orbit:
        """Turn the scene with the pointer, which moved by these parts of the picture's height."""
        azimuth = math.remainder(self.azimuth + _TURN * across, math.tau)
        return replace(self, azimuth=azimuth, elevation=self.elevation + _TURN * up).within_limits()

    def moved(self, across: float, down: float) -> Orbit:
        """Move the scene with the pointer, which moved by these parts of the picture's height."""
        right, up, _ = self._frame()
        height = self.distance * APERTURE / FOCAL_LENGTH * 0.75
        shift = height * (down * up - across * right)
        x, y, z = (np.asarray(self.target) + shift).tolist()
        return replace(self, target=(x, y, z))

    def zoomed(self, factor: float) -> Orbit:
        """Multiply the distance by a factor."""
        return replace(self, distance=self.distance * factor).within_limits()

    def about(self, target: np.ndarray, distance: float | None = None) -> Orbit:
        """Orbit another point (3,), seen from the same direction."""
        x, y, z = map(float, target)
        return replace(self, target=(x, y, z), distance=distance or self.distance).within_limits()

    def within_limits(self) -> Orbit:
        """Return the orbit with elevation and distance inside of their limits."""
        closest, farthest = _CLOSEST * self.size, _FARTHEST * self.size
        distance = min(max(self.distance, closest), farthest) if self.size > 0 else self.distance
        return replace(self, elevation=min(max(self.elevation, -_POLE), _POLE), distance=distance)

    def view(self, width: int, height: int, meters_per_unit: float) -> CameraView:
        """Return the camera for pictures of a size; the field of view spans four by three, whatever the size."""
        right, up, back = self._frame()
        to_world = np.eye(4)
        to_world[:3, :3] = right, up, back
        to_world[3, :3] = np.asarray(self.target) + self.distance * back
        aperture = APERTURE * max(1.0, width / height * 0.75)
        return CameraView(
            prim_path="",
            width=width,
            height=height,
            local_to_world=to_world,
            focal_length=FOCAL_LENGTH,
            horizontal_aperture=aperture,
            vertical_aperture=aperture * height / width,
            clipping_range=(self.distance * _NEAR, self.distance * _FAR),
            meters_per_unit=meters_per_unit,
        )

    def _frame(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return right, up and back of the camera (3,) in the world."""
        away = np.array(
            [
                math.cos(self.elevation) * math.sin(self.azimuth),
                math.cos(self.elevation) * math.cos(self.azimuth),
                math.sin(self.elevation),
            ]
        )
        back = away @ self.axes
        right = np.cross(self.axes[2], back)
        right /= np.linalg.norm(right)
        return right, np.cross(back, right), back
