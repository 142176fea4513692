"""UsdGeomMesh to `scene.Prototype`: triangles with corner normals and UVs, bad data dropped by name."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from usdsdg import errors
from usdsdg_render.geometry.color_atlas import atlas_uvs
from usdsdg_render.geometry.mesh_source import MeshSource, Primvar
from usdsdg_render.geometry.subdivision_surface import refine_mesh
from usdsdg_render.geometry.triangulate import Corners, triangulate
from usdsdg_render.scene.scene import Prototype

# A triangle thinner than this against its longest edge squared is a line in float32.
DEGENERATE_RATIO = 1e-7
DEFAULT_COLOR = 0.5  # of a gprim with displayOpacity only


def build_prototype(path: str, source: MeshSource) -> Prototype | None:
    """Triangles of `source`; None (with a warning) when nothing is left after dropping what is broken."""
    slots, slot_count = _slots(path, source)
    faces = _usable_faces(path, source)
    parents = None  # of refined faces
    if source.refinement is not None and (refined := refine_mesh(path, source, faces.kept, faces.starts)):
        source, parents = refined
        counts = source.counts.astype(np.int64)
        faces = _Faces(np.arange(len(counts)), np.cumsum(counts) - counts, faces.points_broken)
    faces = _without_holes(faces, source.holes)
    counts = source.counts[faces.kept].astype(np.int64)
    triangles = triangulate(source.points, counts, source.indices, faces.starts)
    corners = triangles.corners[:, ::-1] if source.left_handed else triangles.corners
    face = faces.kept[triangles.faces]
    points = np.ascontiguousarray(source.points, np.float32)
    vertices = source.indices[corners]
    face_normals, flat = _triangle_normals(points, vertices)
    _warn_of_flat_faces(path, face if parents is None else parents[face], flat)
    solid = ~flat
    if not solid.any():
        errors.warn_once(f"{path}: no face of the mesh has an area, so it is not drawn. Check its points and indices.")
        return None
    if flat.any():
        corners, face, vertices, face_normals = corners[solid], face[solid], vertices[solid], face_normals[solid]
    corner = Corners(corners, face)
    origin = face if parents is None else parents[face]
    if faces.points_broken:
        points, vertices = _compact(points, vertices)
    colors = _corner_colors(source, corner)
    return Prototype(
        name=path,
        points=points,
        triangles=np.ascontiguousarray(vertices, np.int32),
        corner_normals=_corner_normals(path, source, corner, points, vertices, face_normals),
        corner_uvs=_corner_uvs(path, source, corner) if colors is None else atlas_uvs(len(face)),
        triangle_slots=slots[origin] if slot_count else np.zeros(len(origin), np.int32),
        triangle_faces=origin.astype(np.int32),
        corner_colors=colors,
    )


class _Faces(NamedTuple):
    kept: np.ndarray  # (K,) faces that can be drawn
    starts: np.ndarray  # (K,) where they begin in the face-vertex list
    points_broken: bool


def _usable_faces(path: str, source: MeshSource) -> _Faces:
    """Faces with enough, existing, finite vertices."""
    counts = source.counts.astype(np.int64)
    starts = np.cumsum(np.maximum(counts, 0)) - np.maximum(counts, 0)
    usable = counts >= 3
    _warn_dropped(path, ~usable, "have fewer than three vertices", "Correct faceVertexCounts.")
    complete = starts + counts <= len(source.indices)
    _warn_dropped(
        path, usable & ~complete, "lie beyond the end of faceVertexIndices", "Make the counts sum to its length."
    )
    usable &= complete
    total = int(starts[-1] + max(counts[-1], 0))
    if total < len(source.indices):
        errors.warn_once(
            f"{path}: faceVertexCounts sum to {total} but faceVertexIndices has {len(source.indices)} entries; the "
            f"rest is not drawn. Make the counts sum to its length."
        )
    finite = np.isfinite(source.points).all(axis=1)
    out_of_range = (source.indices < 0) | (source.indices >= len(source.points))
    if out_of_range.any():
        bad = _faces_with(out_of_range, starts, counts, usable)
        _warn_dropped(path, bad, f"name points outside 0..{len(source.points) - 1}", "Correct faceVertexIndices.")
        usable &= ~bad
    if not finite.all():
        broken = ~finite[np.clip(source.indices, 0, len(finite) - 1)]
        bad = _faces_with(broken, starts, counts, usable)
        _warn_dropped(path, bad, "have a NaN or infinite point", "Correct the points.")
        usable &= ~bad
    return _Faces(np.flatnonzero(usable), starts[usable], not finite.all())


def _without_holes(faces: _Faces, holes: np.ndarray) -> _Faces:
    if not len(holes):
        return faces
    drawn = ~np.isin(faces.kept, holes)
    return faces._replace(kept=faces.kept[drawn], starts=faces.starts[drawn])


def _faces_with(bad_vertex: np.ndarray, starts: np.ndarray, counts: np.ndarray, usable: np.ndarray) -> np.ndarray:
    """Which usable faces hold a bad vertex."""
    total = np.concatenate([[0], np.cumsum(bad_vertex)])
    result = np.zeros(len(counts), bool)
    begin = starts[usable]
    result[usable] = total[begin + counts[usable]] > total[begin]
    return result


def _warn_dropped(path: str, dropped: np.ndarray, what: str, remedy: str) -> None:
    if dropped.any():
        first = int(np.flatnonzero(dropped)[0])
        errors.warn_once(f"{path}: {int(dropped.sum())} faces {what} (first: face {first}) and are dropped. {remedy}")


def _triangle_normals(points: np.ndarray, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Area vectors (T, 3) float64, twice the area long, and which triangles are lines or points."""
    a, b, c = (points[vertices[:, k]].astype(np.float64) for k in range(3))
    ab, ac, bc = b - a, c - a, c - b
    normals = np.empty_like(ab)
    normals[:, 0] = ab[:, 1] * ac[:, 2] - ab[:, 2] * ac[:, 1]
    normals[:, 1] = ab[:, 2] * ac[:, 0] - ab[:, 0] * ac[:, 2]
    normals[:, 2] = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    longest = np.maximum(np.maximum(_dot(ab, ab), _dot(ac, ac)), _dot(bc, bc))
    return normals, ~(_dot(normals, normals) > (DEGENERATE_RATIO * longest) ** 2)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i->...", a, b)


def _warn_of_flat_faces(path: str, face: np.ndarray, flat: np.ndarray) -> None:
    """Only faces that vanish whole count: collinear vertices of a polygon are ordinary."""
    if not flat.any():
        return
    lost = np.setdiff1d(face[flat], face[~flat])
    if len(lost):
        errors.warn_once(
            f"{path}: {len(lost)} faces have no area (first: face {int(lost[0])}) and are dropped. "
            f"Merge their points or remove the faces to silence this."
        )


def _compact(points: np.ndarray, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Only the points that triangles use, so that broken ones are gone."""
    used, renumbered = np.unique(vertices, return_inverse=True)
    return points[used], renumbered.reshape(vertices.shape)


def _slots(path: str, source: MeshSource) -> tuple[np.ndarray, int]:
    """Material slot of each face: subsets in order, then one for the faces that no subset names."""
    count = len(source.subsets)
    slots = np.full(len(source.counts), count, np.int32)
    for slot, faces in enumerate(source.subsets):
        inside = (faces >= 0) & (faces < len(slots))
        if not inside.all():
            errors.warn_once(
                f"{path}: material subset {slot} names faces outside 0..{len(slots) - 1}; they are ignored. "
                f"Correct its indices."
            )
            faces = faces[inside]
        shared = int((slots[faces] != count).sum())
        if shared:
            errors.warn_once(
                f"{path}: material subset {slot} names {shared} faces of the subsets before it; it wins. Give each "
                f"face one material."
            )
        slots[faces] = slot
    return slots, count


def _at_corners(primvar: Primvar, corner: Corners, source: MeshSource) -> np.ndarray | None:
    """(T, 3, n) values at the corners of triangles; None when there are too few values."""
    where = {
        "constant": np.zeros((len(corner.faces), 3), np.int64),
        "uniform": np.broadcast_to(corner.faces[:, None], (len(corner.faces), 3)),
        "faceVarying": corner.corners,
    }.get(primvar.interpolation)
    if where is None:  # vertex and varying
        where = source.indices[corner.corners]
    if len(primvar.indices):
        if where.size and where.max() >= len(primvar.indices):
            return None
        where = primvar.indices[where]
    if where.size and (where.max() >= len(primvar.values) or where.min() < 0):
        return None
    return primvar.values[where]


def _corner_uvs(path: str, source: MeshSource, corner: Corners) -> np.ndarray:
    if source.uvs is None:
        return np.zeros((len(corner.faces), 3, 2), np.float32)
    uvs = _at_corners(source.uvs, corner, source)
    if uvs is None:
        errors.warn_once(
            f"{path}: the {source.uvs.interpolation} texture coordinates have {len(source.uvs.values)} values, too few "
            f"for the mesh; textures lie flat on it. Author one value per element or correct the interpolation."
        )
        return np.zeros((len(corner.faces), 3, 2), np.float32)
    uvs = np.ascontiguousarray(uvs, np.float32)
    if not np.isfinite(uvs).all():
        errors.warn_once(f"{path}: some texture coordinates are NaN or infinite; 0 is used there. Correct the primvar.")
        uvs = np.nan_to_num(uvs, nan=0.0, posinf=0.0, neginf=0.0)
    return uvs


def _corner_colors(source: MeshSource, corner: Corners) -> np.ndarray | None:
    """(T, 3, 4) displayColor and displayOpacity; None where there are none, or too few for the mesh."""
    if source.colors is None and source.opacities is None:
        return None
    result = np.ones((len(corner.faces), 3, 4), np.float32)
    result[..., :3] = DEFAULT_COLOR
    for primvar, part in ((source.colors, slice(0, 3)), (source.opacities, slice(3, 4))):
        if primvar is not None:
            values = _at_corners(primvar, corner, source)
            if values is None:
                return None
            result[..., part] = np.nan_to_num(values.reshape(*corner.corners.shape, -1))
    return result


def _corner_normals(path, source: MeshSource, corner: Corners, points, vertices, face_normals) -> np.ndarray:
    """Unit normals: authored ones where usable, else smooth for subdivision surfaces and flat for polygons.

    Subdivision surfaces that are not refined are drawn as they are, so authored normals count for them too.
    """
    normals = None
    if source.normals is not None:
        normals = _at_corners(source.normals, corner, source)
        if normals is None:
            errors.warn_once(
                f"{path}: the {source.normals.interpolation} normals have {len(source.normals.values)} values, too few "
                f"for the mesh; computed normals are used. Author one per element or correct the interpolation."
            )
    if normals is None and source.scheme in ("catmullClark", "loop"):
        normals = _smooth_normals(points, vertices, face_normals)[vertices]
    flat = _unit(face_normals)[0]
    if normals is None:
        return np.repeat(flat[:, None, :], 3, axis=1).astype(np.float32)
    normals, good = _unit(normals)
    if not good.all():
        if source.normals is not None and not np.isfinite(source.normals.values).all():
            errors.warn_once(
                f"{path}: some normals are NaN or infinite; those of the faces are used there. Correct them."
            )
        normals = np.where(good[..., None], normals, flat[:, None, :])
    return np.ascontiguousarray(normals, np.float32)


def _smooth_normals(points: np.ndarray, vertices: np.ndarray, face_normals: np.ndarray) -> np.ndarray:
    """(V, 3) sums of area vectors around each point."""
    where = vertices.ravel()
    return np.stack(
        [np.bincount(where, np.repeat(face_normals[:, k], 3), minlength=len(points)) for k in range(3)], axis=-1
    )


def _unit(vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vectors of length one, and which of them had a finite, usable length."""
    with np.errstate(invalid="ignore", over="ignore"):
        length = np.sqrt(_dot(vectors, vectors))
        good = np.isfinite(length) & (length > 1e-30)
        return vectors / np.where(good, length, 1.0)[..., None], good
