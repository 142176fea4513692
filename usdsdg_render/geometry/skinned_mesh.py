"""Apply skinning to the points and normals of a mesh."""

import numpy as np
from pxr import Usd

from usdsdg.stage.geometry.skinning import Skinning
from usdsdg_render.geometry.mesh_source import EMPTY, MeshSource, Primvar


def skinned(source: MeshSource, prim: Usd.Prim, time: Usd.TimeCode, skinning: Skinning) -> MeshSource:
    """Return `source` with its skinned points and normals at `time`; itself where no skeleton deforms it."""
    normals, vertices = _normals_at_points(source)
    result = skinning.skin(prim, time, normals=normals, vertices=vertices)
    if result is None or len(result.points) != len(source.points):
        return source
    primvar = None
    if result.normals is not None and source.normals is not None:
        primvar = Primvar(result.normals, EMPTY, source.normals.interpolation)
    return source._replace(points=result.points, normals=primvar)


def _normals_at_points(source: MeshSource) -> tuple[np.ndarray | None, np.ndarray | None]:
    """(N, 3) normals and (N,) their points; None for normals of faces, which are computed from the skinned points."""
    primvar = source.normals
    if primvar is None or primvar.interpolation in ("constant", "uniform"):
        return None, None
    values, indices = primvar.values, primvar.indices
    if len(indices):
        if indices.min() < 0 or indices.max() >= len(values):
            return None, None
        values = values[indices]
    vertices = source.indices if primvar.interpolation == "faceVarying" else np.arange(len(source.points))
    if len(values) != len(vertices) or vertices.min() < 0 or vertices.max() >= len(source.points):
        return None, None
    return values, vertices
