"""Primvars of a mesh as faceVarying values of its triangles: one for each vertex of each triangle."""

import numpy as np

from usdsdg import errors
from usdsdg.stage.geometry.triangulate import Triangles
from usdsdg_render.geometry.mesh_source import MeshSource, Primvar

DEFAULT_COLOR = 0.5  # of a gprim with displayOpacity only


def face_varying_uvs(path: str, source: MeshSource, triangles: Triangles) -> np.ndarray:
    """(T, 3, 2) float32 texture coordinates; 0 (with a warning) where they are missing or not finite."""
    missing = np.zeros((len(triangles.faces), 3, 2), np.float32)
    if source.uvs is None:
        return missing
    uvs = _face_varying(source.uvs, triangles, source)
    if uvs is None:
        errors.warn_once(
            f"{path}: the {source.uvs.interpolation} texture coordinates have "
            f"{errors.counted(len(source.uvs.values), 'value')}, too few for the mesh; textures show one texel. Author "
            f"one value per element or correct the interpolation."
        )
        return missing
    uvs = np.ascontiguousarray(uvs, np.float32)
    if not np.isfinite(uvs).all():
        errors.warn_once(f"{path}: some texture coordinates are NaN or infinite; 0 is used there. Correct the primvar.")
        uvs = np.nan_to_num(uvs, nan=0.0, posinf=0.0, neginf=0.0)
    return uvs


def face_varying_colors(source: MeshSource, triangles: Triangles) -> np.ndarray | None:
    """(T, 3, 4) float32 displayColor and displayOpacity; None where there are none, or too few for the mesh."""
    if source.colors is None and source.opacities is None:
        return None
    result = np.ones((len(triangles.faces), 3, 4), np.float32)
    result[..., :3] = DEFAULT_COLOR
    for primvar, columns in ((source.colors, slice(0, 3)), (source.opacities, slice(3, 4))):
        if primvar is not None:
            values = _face_varying(primvar, triangles, source)
            if values is None:
                return None
            result[..., columns] = np.nan_to_num(values.reshape(*triangles.face_vertices.shape, -1))
    return result


def face_varying_normals(
    path: str, source: MeshSource, triangles: Triangles, vertices: np.ndarray, area_vectors: np.ndarray, count: int
) -> np.ndarray:
    """(T, 3, 3) float32 unit normals: authored ones, else smooth for subdivision surfaces and flat for polygons.

    Authored normals count for subdivision surfaces too, since those that get here are drawn without refinement or have
    the normals of the refined surface.

    Args:
        vertices: (T, 3) points of each triangle.
        area_vectors: (T, 3) float64 unnormalized normals of the triangles.
        count: number of points.
    """
    normals = None
    if source.normals is not None:
        normals = _face_varying(source.normals, triangles, source)
        if normals is None:
            errors.warn_once(
                f"{path}: the {source.normals.interpolation} normals have "
                f"{errors.counted(len(source.normals.values), 'value')}, too few for the mesh; computed normals are "
                f"used. Author one per element or correct the interpolation."
            )
    if normals is None and source.scheme in ("catmullClark", "loop"):
        normals = _smooth_normals(count, vertices, area_vectors)[vertices]
    flat = _normalize(area_vectors)[0]
    if normals is None:
        return np.repeat(flat[:, None, :], 3, axis=1).astype(np.float32)
    normals, usable = _normalize(normals)
    if not usable.all():
        if source.normals is not None and not np.isfinite(source.normals.values).all():
            errors.warn_once(
                f"{path}: some normals are NaN or infinite; those of the faces are used there. Correct them."
            )
        normals = np.where(usable[..., None], normals, flat[:, None, :])
    return np.ascontiguousarray(normals, np.float32)


def _face_varying(primvar: Primvar, triangles: Triangles, source: MeshSource) -> np.ndarray | None:
    """(T, 3, n) values at the vertices of triangles; None where there are too few values."""
    rows = {
        "constant": np.zeros((len(triangles.faces), 3), np.int64),
        "uniform": np.broadcast_to(triangles.faces[:, None], (len(triangles.faces), 3)),
        "faceVarying": triangles.face_vertices,
    }.get(primvar.interpolation)
    if rows is None:  # vertex and varying
        rows = source.indices[triangles.face_vertices]
    if len(primvar.indices):
        if rows.size and rows.max() >= len(primvar.indices):
            return None
        rows = primvar.indices[rows]
    if rows.size and (rows.max() >= len(primvar.values) or rows.min() < 0):
        return None
    return primvar.values[rows]


def _smooth_normals(count: int, vertices: np.ndarray, area_vectors: np.ndarray) -> np.ndarray:
    """(count, 3) sums of the area vectors around each point."""
    index = vertices.ravel()
    return np.stack([np.bincount(index, np.repeat(area_vectors[:, k], 3), minlength=count) for k in range(3)], axis=-1)


def _normalize(vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors, and which of them had a finite, usable length."""
    with np.errstate(invalid="ignore", over="ignore"):
        length = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))
        usable = np.isfinite(length) & (length > 1e-30)
        return vectors / np.where(usable, length, 1.0)[..., None], usable
