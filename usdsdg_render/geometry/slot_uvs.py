"""Texture coordinates of meshes whose materials read different primvars: those of each material on its own faces."""

from collections.abc import Sequence

import numpy as np
from pxr import Usd

from usdsdg import errors
from usdsdg_render.geometry.mesh_faces import material_slots
from usdsdg_render.geometry.mesh_source import MeshSource, Primvar, read_uvs
from usdsdg_render.geometry.primvar_faults import warn_of_excess


def with_uvs_of_slots(source: MeshSource, prim: Usd.Prim, time: Usd.TimeCode, uv_names: Sequence[str]) -> MeshSource:
    """Return a mesh with texture coordinates that are, on the faces of each material slot, those of its primvar.

    Args:
        source: with the texture coordinates of the first slot.
        uv_names: primvar of each slot.
    """
    path = str(prim.GetPath())
    read = {uv_names[0]: source.uvs}
    for name in uv_names[1:]:
        if name not in read:
            read[name] = read_uvs(prim, time, name)
            warn_of_excess(path, source._replace(uvs=read[name], normals=None))
    # The values of all primvars in a row, and 0 at the end for corners without one.
    values = [np.asarray(primvar.values, np.float32) for primvar in read.values() if primvar is not None]
    values.append(np.zeros((1, 2), np.float32))
    last, size, rows = sum(map(len, values)) - 1, 0, []
    for primvar in read.values():
        found = None if primvar is None else _rows(primvar, source)
        if primvar is not None and found is None:
            errors.warn_once(
                f"{path}: the {primvar.interpolation} texture coordinates that some of its materials read have "
                f"{errors.counted(len(primvar.values), 'value')}, too few for the mesh; textures show one texel "
                f"there. Author one value per element or correct the interpolation."
            )
        rows.append(np.full(len(source.indices), last) if found is None else found + size)
        size += 0 if primvar is None else len(primvar.values)
    numbers = np.array([list(read).index(name) for name in uv_names])
    chosen = numbers[material_slots(path, source)[_face_of_corners(source)]]
    indices = np.stack(rows)[chosen, np.arange(len(source.indices))]
    return source._replace(uvs=Primvar(np.concatenate(values), indices.astype(np.int32), "faceVarying"))


def _face_of_corners(source: MeshSource) -> np.ndarray:
    """(N,) face of each face-vertex; 0 of those beyond all faces."""
    owners = np.repeat(np.arange(len(source.counts)), np.maximum(source.counts, 0))[: len(source.indices)]
    return np.pad(owners, (0, len(source.indices) - len(owners)))


def _rows(primvar: Primvar, source: MeshSource) -> np.ndarray | None:
    """(N,) value of each face-vertex, any of those that are no points; None where there are too few values."""
    rows = {
        "constant": np.zeros(len(source.indices), np.int64),
        "uniform": _face_of_corners(source),
        "faceVarying": np.arange(len(source.indices)),
    }.get(primvar.interpolation, source.indices)
    are_points = (source.indices >= 0) & (source.indices < len(source.points))
    rows = np.where(are_points, rows, 0)
    if len(primvar.indices):
        if rows.max() >= len(primvar.indices):
            return None
        rows = np.where(are_points, primvar.indices[rows], 0)
    return rows if rows.min() >= 0 and rows.max() < len(primvar.values) else None
