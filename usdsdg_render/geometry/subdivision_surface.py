"""A subdivision surface as the mesh that approximates it: its cage refined, with every vertex on the limit surface."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from usdsdg import errors
from usdsdg_render.geometry.mesh_source import EMPTY, MeshSource, Primvar, Refinement
from usdsdg_render.geometry.subdivision_rules import (
    INFINITE,
    Cage,
    boundary_corners,
    boundary_vertices,
    children,
    corner_normals,
    limit,
    refine,
)

# Surfaces that do not say how fine are refined up to this level, or to as many faces.
AUTOMATIC_LEVEL, AUTOMATIC_FACES = 4, 20_000
MOST_FACES = 1_000_000


class Refined(NamedTuple):
    """A mesh of quads (triangles with Loop's scheme) and the face of the cage that each comes from."""

    source: MeshSource
    parents: np.ndarray  # (F,)


def refine_mesh(path: str, source: MeshSource, faces: np.ndarray, starts: np.ndarray) -> Refined | None:
    """The surface over the usable `faces` of a mesh, which begin at `starts` of its face-vertex list.

    Holes shape what is beside them and are left out. None where the scheme cannot refine the mesh.
    """
    asked = source.refinement
    loop = source.scheme == "loop"
    counts = source.counts[faces].astype(np.int64)
    assert asked is not None
    if not len(faces):
        return None
    if loop and (counts != 3).any():
        errors.warn_once(
            f"{path}: subdivisionScheme is loop, but not all of its faces are triangles; it is drawn without "
            f"refinement. Triangulate it, or set the scheme to catmullClark."
        )
        return None
    levels = _levels(path, asked.level, counts, loop=loop)
    where = _spread(starts, counts)
    cage = _position_cage(path, source, asked, counts, where)
    parents = np.repeat(faces, children(counts, levels, loop=loop))
    outline = np.zeros(len(faces), bool)
    if asked.boundary == "none":
        open_vertex = boundary_vertices(cage)
        outline = np.add.reduceat(open_vertex[cage.indices], np.cumsum(counts) - counts) > 0
    hidden = np.union1d(source.holes, faces[outline])
    drawn = ~np.isin(parents, hidden)
    surface = refine(cage, levels, loop=loop)
    surface = surface._replace(values=limit(surface, loop=loop))
    size = 3 if loop else 4
    normals = corner_normals(surface) * (-1.0 if source.left_handed else 1.0)
    indices = surface.indices.reshape(-1, size)[drawn].ravel().astype(np.int32)
    refined = source._replace(
        points=surface.values[:, :3].astype(np.float32),
        counts=np.full(int(drawn.sum()), size, np.int32),
        indices=indices,
        holes=EMPTY,
        normals=Primvar(normals.reshape(-1, size, 3)[drawn].reshape(-1, 3), EMPTY, "faceVarying"),
        uvs=_refined_uvs(path, source, cage, where, faces, levels, drawn, loop=loop),
        colors=_refined_linearly(source.colors, cage, where, faces, levels, drawn, loop=loop),
        opacities=_refined_linearly(source.opacities, cage, where, faces, levels, drawn, loop=loop),
        refinement=None,
    )
    return Refined(refined, parents[drawn])


def _levels(path: str, level: int | None, counts: np.ndarray, *, loop: bool) -> int:
    def faces(levels: int) -> int:
        return int(children(counts, levels, loop=loop).sum())

    if level is None:
        levels = AUTOMATIC_LEVEL
        while levels > 1 and faces(levels) > AUTOMATIC_FACES:
            levels -= 1
        return levels
    levels = level
    while levels > 1 and faces(levels) > MOST_FACES:
        levels -= 1
    if levels < level:
        errors.warn_once(
            f"{path}: refinementLevel {level} would make more than {MOST_FACES:,} faces; {levels} is used. Lower it to "
            f"silence this."
        )
    return levels


def _spread(starts: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Positions in the face-vertex list of all vertices of the faces."""
    first = np.cumsum(counts) - counts
    return np.arange(int(counts.sum())) - np.repeat(first - starts, counts)


# Positions and what is sharp


def _position_cage(path: str, source: MeshSource, asked: Refinement, counts: np.ndarray, where: np.ndarray) -> Cage:
    """Columns 0 to 2 are positions; texture coordinates at vertices follow."""
    indices = source.indices[where].astype(np.int64)
    values = source.points.astype(np.float64)
    uvs = source.uvs
    if uvs is not None and uvs.interpolation == "vertex":
        at_vertices = uvs.values[uvs.indices] if len(uvs.indices) else uvs.values
        if len(at_vertices) >= len(values):
            values = np.concatenate([values, at_vertices[: len(values)]], axis=1)
    values = np.where(np.isfinite(values), values, 0.0)
    cage = Cage(values, np.zeros(len(values)), counts, indices, np.zeros(len(indices)))
    if source.scheme == "bilinear":
        return _everywhere_sharp(cage)
    corners = _corner_sharpness(path, asked, len(values))
    if asked.boundary == "edgeAndCorner":
        corners[boundary_corners(cage)] = INFINITE
    return cage._replace(corners=corners, creases=_crease_sharpness(path, asked, cage))


def _everywhere_sharp(cage: Cage) -> Cage:
    return cage._replace(corners=np.full(len(cage.values), INFINITE), creases=np.full(len(cage.indices), INFINITE))


def _corner_sharpness(path: str, asked: Refinement, count: int) -> np.ndarray:
    corners = np.zeros(count)
    vertices, sharpness = asked.corner_vertices, asked.corner_sharpness
    usable = min(len(vertices), len(sharpness))
    inside = (vertices[:usable] >= 0) & (vertices[:usable] < count)
    if len(vertices) != len(sharpness) or not inside.all():
        errors.warn_once(
            f"{path}: cornerIndices and cornerSharpnesses differ in length or name points that do not exist; those are "
            f"ignored. Correct them."
        )
    corners[vertices[:usable][inside]] = sharpness[:usable][inside]
    return np.maximum(np.nan_to_num(corners), 0.0)


def _crease_sharpness(path: str, asked: Refinement, cage: Cage) -> np.ndarray:
    """(N,) sharpness of every half-edge."""
    edges, sharpness = _crease_edges(path, asked, len(cage.values))
    if not len(edges):
        return np.zeros(len(cage.indices))
    ends = np.cumsum(cage.counts)
    following = np.arange(1, len(cage.indices) + 1)
    following[ends - 1] = ends - cage.counts
    wanted = _edge_keys(cage.indices, cage.indices[following], len(cage.values))
    keys = _edge_keys(edges[:, 0], edges[:, 1], len(cage.values))
    order = np.argsort(keys, kind="stable")
    found = np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)
    return np.where(keys[order][found] == wanted, sharpness[order][found], 0.0)


def _edge_keys(a: np.ndarray, b: np.ndarray, count: int) -> np.ndarray:
    return np.minimum(a, b).astype(np.int64) * count + np.maximum(a, b)


def _crease_edges(path: str, asked: Refinement, count: int) -> tuple[np.ndarray, np.ndarray]:
    """((E, 2) vertices, (E,) sharpness) of the edges of all chains; none (with a warning) where they are not whole."""
    vertices, lengths = asked.crease_vertices.astype(np.int64), asked.crease_lengths.astype(np.int64)
    none = np.zeros((0, 2), np.int64), np.zeros(0)
    if not len(vertices):
        return none
    of = np.repeat(np.arange(len(lengths)), np.maximum(lengths, 0))
    per_crease, per_edge = len(lengths), int(np.maximum(lengths - 1, 0).sum())
    given = len(asked.crease_sharpness)
    if (
        (lengths < 2).any()
        or len(of) != len(vertices)
        or vertices.min() < 0
        or vertices.max() >= count
        or given not in (per_crease, per_edge)
    ):
        errors.warn_once(
            f"{path}: its creases are not whole, so none is drawn. creaseLengths (at least 2 each) must sum to the "
            f"length of creaseIndices, which name points, and creaseSharpnesses holds one value a crease or an edge."
        )
        return none
    inside = of[:-1] == of[1:]
    edges = np.stack([vertices[:-1], vertices[1:]], axis=-1)[inside]
    sharpness = asked.crease_sharpness.astype(np.float64)
    sharpness = sharpness[of[:-1][inside]] if given == per_crease else sharpness
    return edges, np.maximum(np.nan_to_num(sharpness), 0.0)


# Texture coordinates


def _refined_linearly(
    primvar: Primvar | None,
    cage: Cage,
    where: np.ndarray,
    faces: np.ndarray,
    levels: int,
    drawn: np.ndarray,
    *,
    loop: bool,
) -> Primvar | None:
    """Colors at the corners of the refined faces, blended over the faces of the cage."""
    if primvar is None or primvar.interpolation == "constant":
        return primvar
    elements = _elements(primvar, cage, where, faces)
    if elements is None:
        return primvar
    rows = np.nan_to_num(primvar.values[elements].reshape(len(elements), -1).astype(np.float64))
    apart = Cage(rows, np.zeros(len(rows)), cage.counts, np.arange(len(rows)), np.zeros(len(rows)))
    surface = refine(_everywhere_sharp(apart), levels, loop=loop)
    size = 3 if loop else 4
    corners = surface.values[surface.indices].reshape(-1, size, rows.shape[1])[drawn].reshape(-1, rows.shape[1])
    return Primvar(corners.astype(np.float32), EMPTY, "faceVarying")


def _elements(primvar: Primvar, cage: Cage, where: np.ndarray, faces: np.ndarray) -> np.ndarray | None:
    """(N,) which value each corner of the cage has; None where there are too few."""
    if primvar.interpolation == "uniform":
        elements = np.repeat(faces, cage.counts)
    else:
        elements = where if primvar.interpolation == "faceVarying" else cage.indices
    if len(primvar.indices):
        if elements.max() >= len(primvar.indices):
            return None
        elements = primvar.indices[elements]
    return elements if elements.max() < len(primvar.values) and elements.min() >= 0 else None


def _refined_uvs(
    path: str,
    source: MeshSource,
    cage: Cage,
    where: np.ndarray,
    faces: np.ndarray,
    levels: int,
    drawn: np.ndarray,
    *,
    loop: bool,
) -> Primvar | None:
    """At the corners of the refined faces. Those that do not fit the mesh are handed on, to be named later."""
    uvs = source.uvs
    if uvs is None or uvs.interpolation == "constant":
        return uvs
    elements = _elements(uvs, cage, where, faces)
    if elements is None:
        return uvs
    at_corners = np.nan_to_num(uvs.values[elements].astype(np.float64), posinf=0.0, neginf=0.0)
    if uvs.interpolation == "vertex" and cage.values.shape[1] == 5:
        flat = cage
    else:
        flat = _texture_cage(path, source, cage, at_corners, linear=uvs.interpolation in ("varying", "uniform"))
    surface = refine(flat, levels, loop=loop)
    values = limit(surface, loop=loop)[:, -2:]
    size = 3 if loop else 4
    corners = values[surface.indices].reshape(-1, size, 2)[drawn].reshape(-1, 2)
    return Primvar(corners.astype(np.float32), EMPTY, "faceVarying")


def _texture_cage(path: str, source: MeshSource, cage: Cage, uvs: np.ndarray, *, linear: bool) -> Cage:
    """Texture coordinates (N, 2) on a topology of their own, which ends at seams."""
    asked = source.refinement
    assert asked is not None
    table = np.column_stack([cage.indices.astype(np.float64), uvs])
    welded, of = np.unique(table, axis=0, return_inverse=True)
    of = of.reshape(-1)
    vertex = welded[:, 0].astype(np.int64)
    flat = Cage(welded[:, 1:], cage.corners[vertex], cage.counts, of, cage.creases)
    rule = asked.face_varying
    if linear or rule == "all":
        return _everywhere_sharp(flat)
    if rule == "cornersPlus2":
        errors.warn_once(
            f"{path}: faceVaryingLinearInterpolation cornersPlus2 is refined as cornersPlus1, which differs where a "
            f"seam ends or turns inward. Set it to cornersPlus1 or all."
        )
    pinned = np.zeros(len(welded), bool)
    if rule == "boundaries":
        pinned = boundary_vertices(flat)
    elif rule != "none":
        pinned = boundary_corners(flat)
        if rule != "cornersOnly":  # where three or more pieces meet
            pinned |= np.bincount(vertex, minlength=len(cage.values))[vertex] > 2
    corners = np.where(pinned, INFINITE, 0.0 if rule == "none" else flat.corners)
    return flat._replace(corners=corners)
