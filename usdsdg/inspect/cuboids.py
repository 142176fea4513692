"""Boxes in space to lines in the picture, and axes from cuboids that only exist as pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdsdg.inspect.records import EDGES
from usdsdg.stage.cameras.lenses import Lens

# What is nearer to the camera's plane than this [stage units] is cut off.
NEAR = 1e-3
# In which an edge is drawn that the lens bends.
_PIECES = 24

# Corners (indices into KEYPOINTS) of the faces towards local +x, +y and +z, in circular order.
_FACES = ((5, 6, 8, 7), (3, 4, 8, 7), (2, 4, 8, 6))


@dataclass(frozen=True)
class Pinhole:
    """A camera that looks along -z, y up; square pixels. `view` is world to camera for row vectors."""

    focal: float
    centre: tuple[float, float]
    view: np.ndarray

    def to_camera(self, points_in_world: np.ndarray) -> np.ndarray:
        return points_in_world @ self.view[:3, :3] + self.view[3, :3]

    def project(self, points_in_camera: np.ndarray) -> np.ndarray:
        """(…, 2) pixels of points in front of the camera."""
        depth = np.maximum(-points_in_camera[..., 2:], NEAR)
        return points_in_camera[..., :2] * (self.focal, -self.focal) / depth + self.centre


@dataclass(frozen=True)
class Curved:
    """A camera with a lens that is no pinhole. `view` is world to camera for row vectors."""

    lens: Lens
    view: np.ndarray

    def to_camera(self, points_in_world: np.ndarray) -> np.ndarray:
        return points_in_world @ self.view[:3, :3] + self.view[3, :3]


@dataclass(frozen=True)
class Drawn:
    """A cuboid in the picture; see SeenObject for the parts."""

    cuboid: np.ndarray | None
    edges: np.ndarray | None
    axes: np.ndarray | None


def drawn(keypoints_in_camera: np.ndarray, camera: Pinhole | Curved) -> Drawn:
    """What can be drawn of (9, 3) keypoints in the camera's frame."""
    points = np.asarray(keypoints_in_camera, dtype=float)
    if isinstance(camera, Curved):
        return _bent(points, camera.lens)
    behind = points[:, 2] > -NEAR
    if behind[1:].all():
        return Drawn(None, None, None)
    axes = None if behind[0] else camera.project(_clipped_axes(points))
    if behind.any():
        return Drawn(None, _clipped_edges(points, camera), axes)
    return Drawn(camera.project(points), None, axes)


def _bent(points: np.ndarray, lens: Lens) -> Drawn:
    """Edges in short pieces, of which those are kept that the lens sees; and axes where it sees all of them."""
    share = np.linspace(0.0, 1.0, _PIECES + 1)[:, None]
    edges = [points[a] + share * (points[b] - points[a]) for a, b in EDGES]
    pixels = [lens.to_pixels(edge) for edge in edges]
    pieces = np.concatenate([np.concatenate([each[:-1], each[1:]], axis=1) for each in pixels])
    # A piece across the seam of a panorama would go all the way back.
    with np.errstate(invalid="ignore"):
        kept = pieces[np.abs(pieces[:, :2] - pieces[:, 2:]).max(axis=1) < lens.width / 2]
    axes = lens.to_pixels(np.array([points[0], *(points[list(face)].mean(axis=0) for face in _FACES)]))
    return Drawn(None, kept if len(kept) else None, axes if np.isfinite(axes).all() else None)


def axes_of(cuboid: np.ndarray) -> np.ndarray:
    """(4, 2) pixels: the center and the faces' middles, which perspective keeps where the diagonals cross."""
    return np.array([cuboid[0], *(_crossing(*cuboid[list(face)]) for face in _FACES)])


def bounds(points: np.ndarray, size: tuple[int, int] | None) -> tuple[float, float, float, float]:
    """Smallest rectangle around pixels, cut at the picture's edges where its (width, height) is known."""
    low, high = points.min(axis=0), points.max(axis=0)
    if size is not None:
        low, high = np.clip(low, 0, size), np.clip(high, 0, size)
    return (float(low[0]), float(low[1]), float(high[0]), float(high[1]))


def _clipped_axes(points: np.ndarray) -> np.ndarray:
    ends = []
    for face in _FACES:
        segment = _in_front(points[0], points[list(face)].mean(axis=0))
        ends.append(points[0] if segment is None else segment[1])
    return np.array([points[0], *ends])


def _clipped_edges(points: np.ndarray, camera: Pinhole) -> np.ndarray:
    segments = [_in_front(points[a], points[b]) for a, b in EDGES]
    kept = np.array([segment for segment in segments if segment is not None])
    return camera.project(kept).reshape(-1, 4)


def _in_front(start: np.ndarray, end: np.ndarray) -> np.ndarray | None:
    """The part of a segment in front of the camera."""
    first, second = -start[2] - NEAR, -end[2] - NEAR
    if first <= 0 and second <= 0:
        return None
    if first > 0 and second > 0:
        return np.array([start, end])
    crossing = start + (end - start) * first / (first - second)
    return np.array([start, crossing] if first > 0 else [crossing, end])


def _crossing(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Where the diagonals a-c and b-d of a quad meet; the corners' mean where it is seen edge-on."""
    first, second, mean = c - a, d - b, (a + b + c + d) / 4.0
    determinant = first[0] * second[1] - first[1] * second[0]
    if abs(determinant) <= 0.05 * np.linalg.norm(first) * np.linalg.norm(second):
        return mean
    offset = b - a
    share = (offset[0] * second[1] - offset[1] * second[0]) / determinant
    return a + first * share if 0.0 <= share <= 1.0 else mean
