"""Refine a subdivision surface: its control mesh refined, with every vertex on the limit surface."""

from typing import NamedTuple

import numpy as np

from usdsdg import errors
from usdsdg_render.geometry.mesh_source import EMPTY, MeshSource, Primvar, Refinement
from usdsdg_render.geometry.subdivision import rules
from usdsdg_render.geometry.subdivision.face_varying import Subdivision, refine_linearly, refine_uvs
from usdsdg_render.geometry.subdivision.rules import INFINITE, ControlMesh
from usdsdg_render.geometry.subdivision.sharpness import corner_sharpness, crease_sharpness

# Surfaces that author no refinement level get the highest one up to this with at most so many faces.
AUTOMATIC_LEVEL, AUTOMATIC_FACES = 4, 20_000
MAX_FACES = 1_000_000


class Refined(NamedTuple):
    """A mesh of quads (of triangles with Loop's scheme), and the face of the control mesh that each comes from."""

    source: MeshSource
    parents: np.ndarray  # (F,)


def refine_mesh(path: str, source: MeshSource, faces: np.ndarray, starts: np.ndarray) -> Refined | None:
    """Refine the usable `faces` of a mesh; None (with a warning) where its scheme cannot.

    Holes influence the faces beside them and are left out of the result.

    Args:
        starts: (F,) where each face begins in the face-vertex list.
    """
    refinement = source.refinement
    loop = source.scheme == "loop"
    counts = source.counts[faces].astype(np.int64)
    assert refinement is not None
    if not len(faces):
        return None
    if loop and (counts != 3).any():
        errors.warn_once(
            f"{path}: subdivisionScheme is loop, but not all of its faces are triangles; it is drawn without "
            f"refinement. Triangulate it, or set the scheme to catmullClark."
        )
        return None
    levels = _levels(path, refinement.level, counts, loop=loop)
    face_vertices = _face_vertices(starts, counts)
    control = _control_mesh(path, source, refinement, counts, face_vertices)
    parents = np.repeat(faces, rules.child_counts(counts, levels, loop=loop))
    on_boundary = np.zeros(len(faces), bool)
    if refinement.boundary == "none":
        vertices = rules.boundary_vertices(control)
        on_boundary = np.add.reduceat(vertices[control.indices], np.cumsum(counts) - counts) > 0
    drawn = ~np.isin(parents, np.union1d(source.holes, faces[on_boundary]))
    subdivision = Subdivision(control, face_vertices, faces, levels, drawn, loop)
    surface = rules.refine(control, levels, loop=loop)
    surface = surface._replace(values=rules.limit_values(surface, loop=loop))
    normals = rules.face_varying_normals(surface) * (-1.0 if source.left_handed else 1.0)
    refined = source._replace(
        points=surface.values[:, :3].astype(np.float32),
        counts=np.full(int(drawn.sum()), subdivision.face_size, np.int32),
        indices=subdivision.of_drawn(surface.indices).astype(np.int32),
        holes=EMPTY,
        normals=Primvar(subdivision.of_drawn(normals), EMPTY, "faceVarying"),
        uvs=refine_uvs(path, source, subdivision),
        colors=refine_linearly(source.colors, subdivision),
        opacities=refine_linearly(source.opacities, subdivision),
        refinement=None,
    )
    return Refined(refined, parents[drawn])


def _levels(path: str, level: int | None, counts: np.ndarray, *, loop: bool) -> int:
    def faces(levels: int) -> int:
        return int(rules.child_counts(counts, levels, loop=loop).sum())

    most = AUTOMATIC_FACES if level is None else MAX_FACES
    levels = AUTOMATIC_LEVEL if level is None else level
    while levels > 1 and faces(levels) > most:
        levels -= 1
    if level is not None and levels < level:
        errors.warn_once(
            f"{path}: refinementLevel {level} would make more than {MAX_FACES:,} faces; {levels} is used. Lower it to "
            f"silence this."
        )
    return levels


def _face_vertices(starts: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """(N,) positions in the face-vertex list of all vertices of the faces."""
    first = np.cumsum(counts) - counts
    return np.arange(int(counts.sum())) - np.repeat(first - starts, counts)


def _control_mesh(
    path: str, source: MeshSource, refinement: Refinement, counts: np.ndarray, face_vertices: np.ndarray
) -> ControlMesh:
    """The control mesh; columns 0 to 2 of its values are positions, texture coordinates of vertices follow."""
    indices = source.indices[face_vertices].astype(np.int64)
    values = source.points.astype(np.float64)
    uvs = source.uvs
    if uvs is not None and uvs.interpolation == "vertex":
        rows = uvs.indices if len(uvs.indices) else np.arange(len(uvs.values))
        rows = rows[: len(values)]
        if len(rows) == len(values) and rows.min() >= 0 and rows.max() < len(uvs.values):
            values = np.concatenate([values, uvs.values[rows]], axis=1)
    values = np.where(np.isfinite(values), values, 0.0)
    control = ControlMesh(values, np.zeros(len(values)), counts, indices, np.zeros(len(indices)))
    if source.scheme == "bilinear":
        return rules.infinitely_sharp(control)
    corners = corner_sharpness(path, refinement, len(values))
    if refinement.boundary == "edgeAndCorner":
        corners[rules.boundary_corners(control)] = INFINITE
    return control._replace(corner_sharpness=corners, crease_sharpness=crease_sharpness(path, refinement, control))
