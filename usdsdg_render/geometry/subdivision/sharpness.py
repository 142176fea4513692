"""Sharpness of the corners and creases of a mesh, as authored."""

import numpy as np

from usdsdg import errors
from usdsdg_render.geometry.mesh_source import Refinement
from usdsdg_render.geometry.subdivision.rules import ControlMesh


def corner_sharpness(path: str, refinement: Refinement, count: int) -> np.ndarray:
    """(count,) sharpness of every vertex."""
    corners = np.zeros(count)
    vertices, sharpness = refinement.corner_vertices, refinement.corner_sharpness
    usable = min(len(vertices), len(sharpness))
    inside = (vertices[:usable] >= 0) & (vertices[:usable] < count)
    if len(vertices) != len(sharpness) or not inside.all():
        errors.warn_once(
            f"{path}: cornerIndices and cornerSharpnesses differ in length or name points that do not exist; those are "
            f"ignored. Correct them."
        )
    corners[vertices[:usable][inside]] = sharpness[:usable][inside]
    return np.maximum(np.nan_to_num(corners), 0.0)


def crease_sharpness(path: str, refinement: Refinement, control: ControlMesh) -> np.ndarray:
    """(N,) sharpness of every half-edge of the control mesh."""
    edges, sharpness = _crease_edges(path, refinement, len(control.values))
    if not len(edges):
        return np.zeros(len(control.indices))
    ends = np.cumsum(control.counts)
    after = np.arange(1, len(control.indices) + 1)
    after[ends - 1] = ends - control.counts
    wanted = _edge_keys(control.indices, control.indices[after], len(control.values))
    keys = _edge_keys(edges[:, 0], edges[:, 1], len(control.values))
    order = np.argsort(keys, kind="stable")
    found = np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)
    return np.where(keys[order][found] == wanted, sharpness[order][found], 0.0)


def _edge_keys(a: np.ndarray, b: np.ndarray, count: int) -> np.ndarray:
    return np.minimum(a, b).astype(np.int64) * count + np.maximum(a, b)


def _crease_edges(path: str, refinement: Refinement, count: int) -> tuple[np.ndarray, np.ndarray]:
    """((E, 2) vertices, (E,) sharpness) of the edges of all creases; none (with a warning) where these are invalid."""
    vertices, lengths = refinement.crease_vertices.astype(np.int64), refinement.crease_lengths.astype(np.int64)
    none = np.zeros((0, 2), np.int64), np.zeros(0)
    if not len(vertices):
        return none
    crease_of = np.repeat(np.arange(len(lengths)), np.maximum(lengths, 0))
    per_crease, per_edge = len(lengths), int(np.maximum(lengths - 1, 0).sum())
    given = len(refinement.crease_sharpness)
    if (
        (lengths < 2).any()
        or len(crease_of) != len(vertices)
        or vertices.min() < 0
        or vertices.max() >= count
        or given not in (per_crease, per_edge)
    ):
        errors.warn_once(
            f"{path}: its creases are not whole, so none is drawn. creaseLengths (at least 2 each) must sum to the "
            f"length of creaseIndices, which name points, and creaseSharpnesses holds one value a crease or an edge."
        )
        return none
    within = crease_of[:-1] == crease_of[1:]
    edges = np.stack([vertices[:-1], vertices[1:]], axis=-1)[within]
    sharpness = refinement.crease_sharpness.astype(np.float64)
    sharpness = sharpness[crease_of[:-1][within]] if given == per_crease else sharpness
    return edges, np.maximum(np.nan_to_num(sharpness), 0.0)
