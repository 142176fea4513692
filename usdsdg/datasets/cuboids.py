"""Projection of 3D boxes to line segments in the image, and axes of cuboids that are only known in pixels."""

from dataclasses import dataclass

import numpy as np

from usdsdg.stage.cameras.lens import Lens

# Order of a cuboid's points in this package, and its edges as pairs of indices; the first four edges are those of the
# face with the smallest local x.
CORNERS = ("LDB", "LDF", "LUB", "LUF", "RDB", "RDF", "RUB", "RUF")
KEYPOINTS = ("Center", *CORNERS)
EDGES = ((1, 2), (2, 4), (4, 3), (3, 1), (5, 6), (6, 8), (8, 7), (7, 5), (1, 5), (2, 6), (3, 7), (4, 8))

# Distance of the near clipping plane [stage units].
NEAR = 1e-3
# Line segments per edge for lenses with curved edges.
_CURVE_SEGMENTS = 24

# Corners (indices into KEYPOINTS) of the faces toward local +x, +y and +z, in circular order.
_FACES = ((5, 6, 8, 7), (3, 4, 8, 7), (2, 4, 8, 6))


@dataclass(frozen=True)
class PinholeCamera:
    """A camera that looks along -z, y up; square pixels. `view` is world to camera for row vectors."""

    focal: float
    center: tuple[float, float]
    view: np.ndarray

    def to_camera(self, points_in_world: np.ndarray) -> np.ndarray:
        return points_in_world @ self.view[:3, :3] + self.view[3, :3]

    def project(self, points_in_camera: np.ndarray) -> np.ndarray:
        """(…, 2) pixels of points in front of the camera."""
        depth = np.maximum(-points_in_camera[..., 2:], NEAR)
        return points_in_camera[..., :2] * (self.focal, -self.focal) / depth + self.center


@dataclass(frozen=True)
class CurvedCamera:
    """A camera with a curved projection. `view` is world to camera for row vectors."""

    lens: Lens
    view: np.ndarray

    def to_camera(self, points_in_world: np.ndarray) -> np.ndarray:
        return points_in_world @ self.view[:3, :3] + self.view[3, :3]


@dataclass(frozen=True)
class ProjectedCuboid:
    """A cuboid in the image; see SeenObject for the fields."""

    cuboid: np.ndarray | None
    edges: np.ndarray | None
    axes: np.ndarray | None


def unit_keypoints() -> np.ndarray:
    """Return (9, 3) center and corners, in the order of KEYPOINTS, of a cube with side 1 around the origin."""
    corners = [["LR".index(name[0]), "DU".index(name[1]), "BF".index(name[2])] for name in CORNERS]
    return np.concatenate([np.zeros((1, 3)), np.array(corners) - 0.5])


def box_keypoints(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return (9, 3) center and corners, in the order of KEYPOINTS, of a box between two corners."""
    return (low + high) / 2.0 + unit_keypoints() * (high - low)


def project_cuboid(keypoints_in_camera: np.ndarray, camera: PinholeCamera | CurvedCamera) -> ProjectedCuboid:
    """Project (9, 3) keypoints in the camera's frame, clipped to the part in front of the camera."""
    points = np.asarray(keypoints_in_camera, dtype=float)
    if isinstance(camera, CurvedCamera):
        return _project_curved(points, camera.lens)
    behind = points[:, 2] > -NEAR
    if behind[1:].all():
        return ProjectedCuboid(None, None, None)
    axes = None if behind[0] else camera.project(_clipped_axes(points))
    if behind.any():
        return ProjectedCuboid(None, _clipped_edges(points, camera), axes)
    return ProjectedCuboid(camera.project(points), None, axes)


def _project_curved(points: np.ndarray, lens: Lens) -> ProjectedCuboid:
    """Split edges into short segments and keep those in the lens's view; keep axes if they are all in view."""
    fraction = np.linspace(0.0, 1.0, _CURVE_SEGMENTS + 1)[:, None]
    edges = [points[a] + fraction * (points[b] - points[a]) for a, b in EDGES]
    pixels = [lens.to_pixels(edge) for edge in edges]
    pieces = np.concatenate([np.concatenate([each[:-1], each[1:]], axis=1) for each in pixels])
    # A segment across the seam of a panorama would be drawn through the whole image.
    with np.errstate(invalid="ignore"):
        kept = pieces[np.abs(pieces[:, :2] - pieces[:, 2:]).max(axis=1) < lens.width / 2]
    axes = lens.to_pixels(np.array([points[0], *(points[list(face)].mean(axis=0) for face in _FACES)]))
    return ProjectedCuboid(None, kept if len(kept) else None, axes if np.isfinite(axes).all() else None)


def axes_of(cuboid: np.ndarray) -> np.ndarray:
    """Return (4, 2) pixels: the center, and the face centers, which in perspective are where the diagonals cross."""
    return np.array([cuboid[0], *(_crossing(*cuboid[list(face)]) for face in _FACES)])


def bounds(points: np.ndarray, size: tuple[int, int] | None) -> tuple[float, float, float, float]:
    """Return the bounding rectangle of pixels, clipped to the image if its (width, height) is known."""
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


def _clipped_edges(points: np.ndarray, camera: PinholeCamera) -> np.ndarray:
    segments = [_in_front(points[a], points[b]) for a, b in EDGES]
    kept = np.array([segment for segment in segments if segment is not None])
    return camera.project(kept).reshape(-1, 4)


def _in_front(start: np.ndarray, end: np.ndarray) -> np.ndarray | None:
    """Return the part of a segment in front of the camera, or None."""
    first, second = -start[2] - NEAR, -end[2] - NEAR
    if first <= 0 and second <= 0:
        return None
    if first > 0 and second > 0:
        return np.array([start, end])
    crossing = start + (end - start) * first / (first - second)
    return np.array([start, crossing] if first > 0 else [crossing, end])


def _crossing(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Return the intersection of the diagonals a-c and b-d of a quad; the mean of its corners if seen edge-on."""
    first, second, mean = c - a, d - b, (a + b + c + d) / 4.0
    determinant = first[0] * second[1] - first[1] * second[0]
    if abs(determinant) <= 0.05 * np.linalg.norm(first) * np.linalg.norm(second):
        return mean
    offset = b - a
    fraction = (offset[0] * second[1] - offset[1] * second[0]) / determinant
    return a + first * fraction if 0.0 <= fraction <= 1.0 else mean
