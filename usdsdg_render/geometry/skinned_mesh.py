"""A mesh as its skeleton shapes it."""

from __future__ import annotations

import numpy as np
from pxr import Usd

from usdsdg.stage.geometry.skinning import Skinning
from usdsdg_render.geometry.mesh_source import EMPTY, MeshSource, Primvar


def posed(source: MeshSource, prim: Usd.Prim, time: Usd.TimeCode, skinning: Skinning) -> MeshSource:
    """`source` with the points and normals of `time`; itself where nothing is skinned."""
    normals, vertices = _normals_at_points(source)
    skinned = skinning.skin(prim, time, normals=normals, vertices=vertices)
    if skinned is None or len(skinned.points) != len(source.points):
        return source
    turned = None
    if skinned.normals is not None and source.normals is not None:
        turned = Primvar(skinned.normals, EMPTY, source.normals.interpolation)
    return source._replace(points=skinned.points, normals=turned)


def _normals_at_points(source: MeshSource) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Normals one by one and the point of each; none where they belong to faces, to be computed from those instead."""
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
