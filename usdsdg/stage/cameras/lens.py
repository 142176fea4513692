"""The model of a lens other than a pinhole: directions to pixels and back, in NumPy.

`usdsdg_render/kernels/cameras/lens.py` has the same for kernels.
"""

from dataclasses import dataclass, replace

import numpy as np

from usdsdg.stage.cameras import lens_panoramas
from usdsdg.stage.cameras.lens_curves import POWER, RATIONAL, Curve
from usdsdg.stage.cameras.lens_tables import LensTable

_NEWTON_STEPS = 50


@dataclass(frozen=True)
class Lens:
    """A lens model for images of (width, height); it looks along -Z with +Y up, pixels count from the top left corner.

    A direction is mapped to a point of a plane. `curve` gives the distance of the point from the center: as a function
    of the angle to the optical axis, for RATIONAL of the angle's tangent; for POWER it is the inverse, the angle as a
    function of the distance. `tangential` and `thin_prism` distortion, in OpenCV's order and form, offset the point,
    and `focal` [pixels] and `center` [pixels] map it to pixels. A lens with a `table` instead of a curve maps a
    direction to texel coordinates, which `focal` and `center` map to pixels. A lens with neither is an equirectangular
    panorama. For stereo, the ray of a column starts `eye_offset` [stage units] right of the camera's position, relative
    to the direction of the column.
    """

    model: str
    width: int
    height: int
    focal: tuple[float, float] = (1.0, 1.0)
    center: tuple[float, float] = (0.0, 0.0)
    curve: Curve | None = None
    tangential: tuple[float, float] = (0.0, 0.0)
    thin_prism: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    eye_offset: float = 0.0
    table: LensTable | None = None

    @property
    def is_flat(self) -> bool:
        """Whether only points before the lens plane are visible; clipping distances are measured from that plane."""
        return self.curve is not None and self.curve.kind == RATIONAL

    @property
    def is_asymmetric(self) -> bool:
        """Whether tangential or thin prism distortion makes the image asymmetric about the center."""
        return any(self.tangential) or any(self.thin_prism)

    @property
    def is_panorama(self) -> bool:
        """Whether the image shows all directions."""
        return self.curve is None and self.table is None

    def widened(self, margin: tuple[int, int]) -> "Lens":
        """Return the lens for images with so many columns and rows more on each side; not for panoramas."""
        (x, y), (columns, rows) = self.center, margin
        size = {"width": self.width + 2 * columns, "height": self.height + 2 * rows}
        return replace(self, **size, center=(x + columns, y + rows))

    def to_pixels(self, points: np.ndarray, *, extrapolate: bool = False) -> np.ndarray:
        """Project points (N, 3) in the camera's frame to pixels (N, 2), as column and row.

        Points outside of the field of view are NaN. With `extrapolate` they get a position outside of the visible area,
        on their side of the image, except for points in or behind the plane of a flat lens.
        """
        points = np.asarray(points, np.float64).reshape(-1, 3)
        if self.table is not None:
            return self.table.to_texels(points, extrapolate=extrapolate) * self.focal + self.center
        if self.curve is None:
            return lens_panoramas.image_fractions(points, self.eye_offset, extrapolate=extrapolate) * (
                self.width,
                self.height,
            )
        across, ahead = np.hypot(points[:, 0], points[:, 1]), -points[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            side = np.where(across[:, None] > 0, points[:, :2] * (1.0, -1.0) / across[:, None], 0.0)
            if self.is_flat:
                t = np.where(ahead > 0, across / ahead, np.nan)
            else:
                t = np.arctan2(across, ahead)
        radius, distorted, seen = self._radius(t)
        plane = radius[:, None] * side + self._distortion(distorted[:, None] * side)
        pixels = plane * self.focal + self.center
        return pixels if extrapolate else np.where(seen[:, None], pixels, np.nan)

    def to_directions(self, pixels: np.ndarray) -> np.ndarray:
        """Return the unit directions (N, 3), in the camera's frame, of pixels (N, 2); NaN where no light enters."""
        pixels = np.asarray(pixels, np.float64).reshape(-1, 2)
        plane = (pixels - self.center) / self.focal
        if self.table is not None:
            return self.table.to_directions(plane)
        if self.curve is None:
            return lens_panoramas.directions(pixels / (self.width, self.height))
        if self.is_asymmetric:
            plane = self._undistorted(plane)
        radius = np.hypot(plane[:, 0], plane[:, 1])
        t = radius
        if not self.is_flat or not self.is_asymmetric:
            t = self.curve.evaluate(radius)[0] if self.curve.kind == POWER else self.curve.solve(radius)
        t = np.where(self._is_visible(radius, t), t, np.nan)
        angle = np.arctan(t) if self.is_flat else t
        with np.errstate(divide="ignore", invalid="ignore"):
            side = np.where(radius[:, None] > 0, plane / radius[:, None], 0.0)
        sine = np.sin(angle)
        return np.stack([sine * side[:, 0], -sine * side[:, 1], -np.cos(angle)], axis=1)

    def to_origins(self, pixels: np.ndarray) -> np.ndarray:
        """Return the ray origins (N, 3), in the camera's frame, of pixels (N, 2)."""
        pixels = np.asarray(pixels, np.float64).reshape(-1, 2)
        return lens_panoramas.origins(pixels / (self.width, self.height), self.eye_offset)

    def _is_visible(self, radius: np.ndarray, t: np.ndarray) -> np.ndarray:
        assert self.curve is not None
        if self.curve.kind == POWER:
            return radius <= self.curve.limit
        if self.is_flat and self.is_asymmetric:
            return t <= self.curve.limit
        return radius <= self.curve.limit_value

    def _radius(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the radius in the plane for angles (or tangents) t, the radius for the distortion, and visibility.

        Beyond its limit the curve is extrapolated by a straight line.
        """
        assert self.curve is not None
        curve = self.curve
        end = curve.limit_value if curve.kind == POWER else curve.limit
        far = (curve.limit if curve.kind == POWER else curve.limit_value) * np.maximum(t / max(end, 1e-300), 1.0)
        within = np.fmin(t, end)
        radius = curve.solve(within) if curve.kind == POWER else curve.evaluate(within)[0]
        radius, seen = np.where(t > end, far, radius), t <= end
        return radius, within if self.is_flat else np.where(seen, radius, curve.limit_value), seen

    def _distortion(self, plane: np.ndarray) -> np.ndarray:
        """Return the offset by tangential and thin prism distortion at points (N, 2) of the plane."""
        if not self.is_asymmetric:
            return np.zeros_like(plane)
        (x, y), (p1, p2), (s1, s2, s3, s4) = plane.T, self.tangential, self.thin_prism
        r2 = x * x + y * y
        return np.stack(
            [
                2 * p1 * x * y + p2 * (r2 + 2 * x * x) + s1 * r2 + s2 * r2 * r2,
                p1 * (r2 + 2 * y * y) + 2 * p2 * x * y + s3 * r2 + s4 * r2 * r2,
            ],
            axis=1,
        )

    def _undistorted(self, plane: np.ndarray) -> np.ndarray:
        """Undo the distortion of points (N, 2) by Newton's method; NaN where it does not converge.

        For a flat lens the result is in tangents of the angle.
        """
        assert self.curve is not None
        point = plane.copy()
        if self.is_flat:
            radius = np.hypot(plane[:, 0], plane[:, 1])
            point *= (self.curve.solve(radius) / np.maximum(radius, 1e-300))[:, None]
        with np.errstate(all="ignore"):
            # Points without a solution diverge, and may overflow.
            for _ in range(_NEWTON_STEPS):
                error, ((a, b), (c, d)) = self._residual(point, plane)
                step = np.stack([d * error[:, 0] - b * error[:, 1], a * error[:, 1] - c * error[:, 0]], axis=1)
                step /= (a * d - b * c)[:, None]
                point = point - step
                if np.nanmax(np.abs(step), initial=0.0) < 1e-14:
                    break
            error, _ = self._residual(point, plane)
            return np.where(np.abs(error).max(axis=1, initial=0.0, keepdims=True) < 1e-9, point, np.nan)

    def _residual(self, point: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the residual (N, 2) of points (N, 2), and its Jacobian (2, 2, N)."""
        assert self.curve is not None
        (x, y), (p1, p2), (s1, s2, s3, s4) = point.T, self.tangential, self.thin_prism
        r2 = x * x + y * y
        radial_scale, scale_slope = np.ones_like(r2), np.zeros_like(r2)
        if self.is_flat:
            t = np.sqrt(r2)
            value, slope = self.curve.evaluate(t)
            radial_scale = np.where(t > 1e-12, value / np.maximum(t, 1e-12), slope)
            scale_slope = (slope - radial_scale) / np.maximum(r2, 1e-24)
        mixed = 2 * (p1 * x + p2 * y) + scale_slope * x * y
        s, v = 2 * (s1 + 2 * s2 * r2), 2 * (s3 + 2 * s4 * r2)
        jacobian = np.array(
            [
                [radial_scale + scale_slope * x * x + 2 * p1 * y + 6 * p2 * x + x * s, mixed + y * s],
                [mixed + x * v, radial_scale + scale_slope * y * y + 6 * p1 * y + 2 * p2 * x + y * v],
            ]
        )
        return radial_scale[:, None] * point + self._distortion(point) - target, jacobian
