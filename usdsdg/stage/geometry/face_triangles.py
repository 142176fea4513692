"""The faces of a mesh as triangles, without those that cannot be used."""

from typing import NamedTuple

import numpy as np

from usdsdg.stage.geometry.triangulate import triangulate


class FaceTriangles(NamedTuple):
    """Triangles of the faces of a mesh, and how many faces were left out."""

    triangles: np.ndarray  # (T, 3) int64 into the points, turning as their faces do
    faces: np.ndarray  # (T,) int64 face of each
    holes: int  # faces that are holes
    beyond: int  # faces with vertices beyond the end of the indices
    outside: int  # faces that name points which do not exist


def face_triangles(points: np.ndarray, counts: np.ndarray, indices: np.ndarray, holes: np.ndarray) -> FaceTriangles:
    """Return the triangles of the faces that are no holes and have three or more existing vertices.

    Triangles at points that are not finite are left out.

    Args:
        points: (V, 3).
        counts: (F,) vertices of each face.
        indices: (N,) of the vertices of all faces, one after the other.
        holes: numbers of faces; those that do not exist are ignored.
    """
    counts = np.maximum(counts.astype(np.int64), 0)
    starts = np.cumsum(counts) - counts
    usable = counts >= 3
    beyond = usable & (starts + counts > len(indices))
    usable &= ~beyond
    wrong = np.concatenate([[0], np.cumsum((indices < 0) | (indices >= len(points)))])
    outside = usable.copy()
    outside[usable] = wrong[(starts + counts)[usable]] > wrong[starts[usable]]
    usable &= ~outside
    is_hole = np.zeros(len(counts), bool)
    is_hole[holes[(holes >= 0) & (holes < len(counts))]] = True
    faces = np.flatnonzero(usable & ~is_hole)
    found = triangulate(points, counts[faces], indices, starts[faces])
    triangles = indices[found.face_vertices].astype(np.int64)
    finite = np.asarray(np.isfinite(points).all(axis=1))
    kept = finite[triangles].all(axis=1)
    return FaceTriangles(
        triangles[kept],
        faces[found.faces][kept],
        int((usable & is_hole).sum()),
        int(beyond.sum()),
        int(outside.sum()),
    )
