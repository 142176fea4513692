"""The triangles of mesh prims, made once for all prims that have the same points and faces."""

import hashlib
from dataclasses import dataclass

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.errors import counted, warn_once
from usdsdg.stage.geometry.face_triangles import face_triangles
from usdsdg.stage.time_code import current_value

# Of points and triangles that are kept; what was made first is forgotten then, and made again where it is needed.
MOST_BYTES = 64 << 20


@dataclass(frozen=True, eq=False)
class MeshTriangles:
    """Read-only arrays of the points that faces use and of the triangles, which prims of equal content share.

    The counts below say how many faces and points of the prim are left out, for warnings.

    All points that are finite are there where no face can be used, none where all are holes.
    """

    points: np.ndarray  # (N, 3) float32
    triangles: np.ndarray  # (F, 3) int32
    points_key: bytes  # of the content of the points
    given: int  # points of the prim
    indices: int
    vertices: int  # what the sizes of the faces sum to
    holes: int  # faces that are holes
    beyond: int  # faces with vertices beyond the end of the indices
    outside: int  # faces that name points which do not exist
    not_finite: int  # points


class TrianglesCache:
    """Triangles by the content of meshes: a hundred references to one asset are cut into triangles once."""

    def __init__(self) -> None:
        self._known: dict[bytes, MeshTriangles] = {}
        self._bytes = 0

    def read(self, prim: Usd.Prim) -> MeshTriangles:
        """Return the triangles of a mesh; polygons are triangulated.

        Faces that are holes are left out, as in images; those that name points which do not exist, and triangles at
        points that are not finite, with a warning.
        """
        mesh = UsdGeom.Mesh(prim)
        points = np.asarray(current_value(mesh.GetPointsAttr()) or [], np.float32).reshape(-1, 3)
        faces = (mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr(), mesh.GetHoleIndicesAttr())
        counts, indices, holes = (np.asarray(current_value(attribute) or []) for attribute in faces)
        left_handed = current_value(mesh.GetOrientationAttr()) == UsdGeom.Tokens.leftHanded
        key = _digest(points, counts, indices, holes, np.array(left_handed))
        found = self._known.get(key)
        if found is None:
            counts, indices, holes = (part.astype(np.int64) for part in (counts, indices, holes))
            found = _made(points, counts, indices, holes, left_handed)
            self._keep(key, found)
        _warn(str(prim.GetPath()), found)
        return found

    def _keep(self, key: bytes, made: MeshTriangles) -> None:
        self._known[key] = made
        self._bytes += _size(made)
        while self._bytes > MOST_BYTES:
            self._bytes -= _size(self._known.pop(next(iter(self._known))))


def digest(*arrays: np.ndarray) -> bytes:
    """Return a key of the content of arrays of known types."""
    found = hashlib.blake2b(digest_size=16)
    for array in arrays:
        found.update(str(array.shape).encode())
        found.update(array.tobytes())
    return found.digest()


def _digest(*arrays: np.ndarray) -> bytes:
    """As `digest`, of arrays of any type; twice as fast where a processor has instructions for it."""
    found = hashlib.sha256()
    for array in arrays:
        found.update(f"{array.dtype.str} {array.shape}".encode())
        found.update(np.ascontiguousarray(array).data)
    return found.digest()


def _made(
    points: np.ndarray, counts: np.ndarray, indices: np.ndarray, holes: np.ndarray, left_handed: bool
) -> MeshTriangles:
    found = face_triangles(points, counts, indices, holes)
    triangles = found.triangles[:, ::-1] if left_handed else found.triangles
    if len(triangles):
        used = np.zeros(len(points), bool)
        used[triangles] = True
        kept, triangles = points[used], (np.cumsum(used) - 1)[triangles].astype(np.int32)
    else:
        # A copy: USD may have the points of the prim in a file that is mapped to memory.
        kept = points[np.isfinite(points).all(axis=1) & (found.holes == 0)].copy()
        triangles = np.zeros((0, 3), np.int32)
    for array in (kept, triangles):
        array.flags.writeable = False
    return MeshTriangles(
        points=kept,
        triangles=triangles,
        points_key=digest(kept),
        given=len(points),
        indices=len(indices),
        vertices=int(np.maximum(counts, 0).sum()),
        holes=found.holes,
        beyond=found.beyond,
        outside=found.outside,
        not_finite=int((~np.isfinite(points).all(axis=1)).sum()),
    )


def _size(made: MeshTriangles) -> int:
    return made.points.nbytes + made.triangles.nbytes


def _warn(path: str, mesh: MeshTriangles) -> None:
    """Warn of the faces and points that a prim names in vain."""
    if mesh.beyond or mesh.vertices < mesh.indices:
        beyond = counted(mesh.beyond, "of its faces does", "of its faces do")
        rest = f"so {beyond} not collide" if mesh.beyond else "of which the rest is not used"
        warn_once(
            f"{path}: faceVertexCounts sum to {mesh.vertices}, but faceVertexIndices has "
            f"{counted(mesh.indices, 'entry', 'entries')}, {rest}. Make the counts sum to its length."
        )
    if mesh.outside:
        outside = counted(mesh.outside, "of its faces does", "of its faces do")
        warn_once(f"{path}: {outside} not collide, with points outside 0..{mesh.given - 1}. Correct faceVertexIndices.")
    if (mesh.beyond or mesh.outside) and not len(mesh.triangles) and not mesh.holes:
        warn_once(f"{path}: none of its faces can be used, so the convex hull of its points collides.")
    if mesh.not_finite:
        warn_once(
            f"{path}: {counted(mesh.not_finite, 'of its points is', 'of its points are')} not finite, and nothing "
            "collides with it there."
        )
