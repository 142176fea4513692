"""Triangulate polygons in NumPy: fans for convex faces, ear clipping for concave ones."""

from typing import NamedTuple

import numpy as np

# A vertex is reflex if it turns back by more than this, as sine of the angle: less is rounding.
REFLEX_SINE = 1e-4


class Triangles(NamedTuple):
    """Triangles as positions in the face-vertex list, by which faceVarying values are looked up."""

    face_vertices: np.ndarray  # (T, 3) int64 into faceVertexIndices
    faces: np.ndarray  # (T,) int64 into faceVertexCounts


def triangulate(points: np.ndarray, counts: np.ndarray, indices: np.ndarray, starts: np.ndarray) -> Triangles:
    """Triangulate faces of three or more vertices each.

    Args:
        points: (V, 3).
        counts: (F,) vertices of each face, >= 3.
        indices: face-vertex list.
        starts: (F,) where each face begins in `indices`.
    """
    if len(counts) and counts.min() == counts.max() == 3:
        return Triangles(starts[:, None] + np.arange(3), np.arange(len(counts)))
    fan = _fan(counts, starts)
    larger = np.flatnonzero(counts > 3)
    if not len(larger):
        return fan
    face_vertices = fan.face_vertices
    first_of_face = np.cumsum(counts - 2) - (counts - 2)
    with np.errstate(invalid="ignore", over="ignore"):  # points that are not finite make no concave face
        concave = _concave_faces(points, counts, indices, starts, larger)
    for face, reflex in concave:
        begin, count = starts[face], counts[face]
        rows = slice(first_of_face[face], first_of_face[face] + count - 2)
        if count == 4:  # the diagonal from the reflex vertex lies inside
            face_vertices[rows] = begin + (np.array([[0, 1, 2], [0, 2, 3]]) + reflex) % 4
        else:
            polygon = points[indices[begin : begin + count]].astype(np.float64)
            face_vertices[rows] = begin + clip_ears(polygon)
    return fan


def _fan(counts: np.ndarray, starts: np.ndarray) -> Triangles:
    triangles = counts - 2
    faces = np.repeat(np.arange(len(counts)), triangles)
    step = np.arange(len(faces)) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    begin = starts[faces]
    return Triangles(np.stack([begin, begin + step + 1, begin + step + 2], axis=-1), faces)


def _concave_faces(
    points: np.ndarray, counts: np.ndarray, indices: np.ndarray, starts: np.ndarray, faces: np.ndarray
) -> list[tuple[int, int]]:
    """(face, number of its most reflex vertex) of the concave ones among `faces`."""
    count = counts[faces]
    owner = np.repeat(np.arange(len(faces)), count)
    base = np.cumsum(count) - count
    step = np.arange(len(owner)) - base[owner]
    begin, length = starts[faces][owner], count[owner]
    here = points[indices[begin + step]].astype(np.float64)
    ahead = points[indices[begin + (step + 1) % length]] - here
    back = here - points[indices[begin + (step - 1) % length]]
    # Newell's normal is the area vector of the polygon, whatever its shape.
    area = np.add.reduceat(np.cross(here - here[base][owner], here + ahead - here[base][owner]), base)
    normal = area / np.maximum(np.linalg.norm(area, axis=1, keepdims=True), 1e-300)
    turn = np.einsum("ij,ij->i", np.cross(back, ahead), normal[owner])
    sine = turn / np.maximum(np.linalg.norm(back, axis=1) * np.linalg.norm(ahead, axis=1), 1e-300)
    concave = np.flatnonzero(np.minimum.reduceat(sine, base) < -REFLEX_SINE)
    return [(int(faces[k]), int(np.argmin(sine[base[k] : base[k] + count[k]]))) for k in concave]


def clip_ears(polygon: np.ndarray) -> np.ndarray:
    """(n - 2, 3) int triangles of a simple polygon of (n, 3) points, by ear clipping in its plane.

    A polygon that intersects itself has no triangulation: where no ear is left, the most convex vertex is clipped.
    """
    flat = _to_plane(polygon)
    remaining = list(range(len(flat)))
    triangles = []
    while len(remaining) > 3:
        ear = _find_ear(flat, remaining)
        triangles.append([remaining[ear - 1], remaining[ear], remaining[(ear + 1) % len(remaining)]])
        del remaining[ear]
    triangles.append(remaining)
    return np.array(triangles)


def _to_plane(polygon: np.ndarray) -> np.ndarray:
    """(n, 2) coordinates of a polygon in its plane, counter-clockwise."""
    relative = polygon - polygon[0]
    normal = np.cross(relative, np.roll(relative, -1, axis=0)).sum(axis=0)
    drop = int(np.argmax(np.abs(normal)))
    flat = np.roll(relative, -(drop + 1), axis=1)[:, :2]
    return flat if normal[drop] >= 0 else flat * np.array([1.0, -1.0])


def _find_ear(flat: np.ndarray, remaining: list[int]) -> int:
    """Position in `remaining` of the ear with the largest area."""
    ring = flat[remaining]
    back, ahead = np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0)
    turn = _cross(ring - back, ahead - ring)
    # Large ears first: rays slip through thin triangles.
    for ear in np.argsort(-turn):
        if turn[ear] <= 0.0:
            break
        a, b, c = back[ear], ring[ear], ahead[ear]
        inside = (_cross(b - a, ring - a) >= 0) & (_cross(c - b, ring - b) >= 0) & (_cross(a - c, ring - c) >= 0)
        coincident = (ring == a).all(1) | (ring == b).all(1) | (ring == c).all(1)
        if not (inside & ~coincident).any():
            return int(ear)
    return int(np.argmax(turn))


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
