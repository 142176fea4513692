"""Refine the primvars of a subdivision surface to faceVarying ones of the refined mesh."""

from typing import NamedTuple

import numpy as np

from usdsdg import errors
from usdsdg_render.geometry.mesh_source import EMPTY, MeshSource, Primvar
from usdsdg_render.geometry.subdivision import rules
from usdsdg_render.geometry.subdivision.rules import INFINITE, ControlMesh


class Subdivision(NamedTuple):
    """How one mesh is refined."""

    control: ControlMesh
    face_vertices: np.ndarray  # (N,) where its face-vertices are in the face-vertex list of the source
    faces: np.ndarray  # (F,) faces of the source
    levels: int
    drawn: np.ndarray  # (children,) bool: which refined faces are drawn
    loop: bool  # Loop's scheme, else Catmull-Clark

    @property
    def face_size(self) -> int:
        """Vertices of a refined face."""
        return 3 if self.loop else 4

    def of_drawn(self, values: np.ndarray) -> np.ndarray:
        """Return those face-vertex values of refined faces whose face is drawn."""
        return values.reshape(-1, self.face_size, *values.shape[1:])[self.drawn].reshape(-1, *values.shape[1:])


def refine_linearly(primvar: Primvar | None, subdivision: Subdivision) -> Primvar | None:
    """Interpolate values over the faces of the control mesh; those that do not fit it are returned as they are."""
    if primvar is None or primvar.interpolation == "constant":
        return primvar
    elements = _elements(primvar, subdivision)
    if elements is None:
        return primvar
    rows = np.nan_to_num(primvar.values[elements].reshape(len(elements), -1).astype(np.float64))
    separate = ControlMesh(
        rows, np.zeros(len(rows)), subdivision.control.counts, np.arange(len(rows)), np.zeros(len(rows))
    )
    surface = rules.refine(rules.infinitely_sharp(separate), subdivision.levels, loop=subdivision.loop)
    values = subdivision.of_drawn(surface.values[surface.indices])
    return Primvar(values.astype(np.float32), EMPTY, "faceVarying")


def refine_uvs(path: str, source: MeshSource, subdivision: Subdivision) -> Primvar | None:
    """Refine texture coordinates; those that do not fit the mesh are returned as they are, to be warned of later."""
    uvs, control = source.uvs, subdivision.control
    if uvs is None or uvs.interpolation == "constant":
        return uvs
    elements = _elements(uvs, subdivision)
    if elements is None:
        return uvs
    values = np.nan_to_num(uvs.values[elements].astype(np.float64), posinf=0.0, neginf=0.0)
    if uvs.interpolation == "vertex" and control.values.shape[1] == 5:
        uv_mesh = control
    else:
        uv_mesh = _uv_mesh(path, source, control, values, linear=uvs.interpolation in ("varying", "uniform"))
    surface = rules.refine(uv_mesh, subdivision.levels, loop=subdivision.loop)
    values = rules.limit_values(surface, loop=subdivision.loop)[:, -2:]
    return Primvar(subdivision.of_drawn(values[surface.indices]).astype(np.float32), EMPTY, "faceVarying")


def _elements(primvar: Primvar, subdivision: Subdivision) -> np.ndarray | None:
    """(N,) index of the value of each face-vertex of the control mesh; None where there are too few values."""
    control = subdivision.control
    if primvar.interpolation == "uniform":
        elements = np.repeat(subdivision.faces, control.counts)
    else:
        elements = subdivision.face_vertices if primvar.interpolation == "faceVarying" else control.indices
    if len(primvar.indices):
        if elements.max() >= len(primvar.indices):
            return None
        elements = primvar.indices[elements]
    return elements if elements.max() < len(primvar.values) and elements.min() >= 0 else None


def _uv_mesh(path: str, source: MeshSource, control: ControlMesh, uvs: np.ndarray, *, linear: bool) -> ControlMesh:
    """The control mesh of face-varying texture coordinates (N, 2): its topology is split at seams."""
    refinement = source.refinement
    assert refinement is not None
    table = np.column_stack([control.indices.astype(np.float64), uvs])
    welded, indices = np.unique(table, axis=0, return_inverse=True)
    indices = indices.reshape(-1)
    vertex = welded[:, 0].astype(np.int64)
    uv_mesh = ControlMesh(
        welded[:, 1:], control.corner_sharpness[vertex], control.counts, indices, control.crease_sharpness
    )
    rule = refinement.face_varying
    if linear or rule == "all":
        return rules.infinitely_sharp(uv_mesh)
    if rule == "cornersPlus2":
        errors.warn_once(
            f"{path}: faceVaryingLinearInterpolation cornersPlus2 is refined as cornersPlus1, which differs where a "
            f"seam ends or turns inward. Set it to cornersPlus1 or all."
        )
    sharp = np.zeros(len(welded), bool)
    if rule == "boundaries":
        sharp = rules.boundary_vertices(uv_mesh)
    elif rule != "none":
        sharp = rules.boundary_corners(uv_mesh)
        if rule != "cornersOnly":  # cornersPlus1 adds vertices where three or more UV regions meet
            sharp |= np.bincount(vertex, minlength=len(control.values))[vertex] > 2
    corners = np.where(sharp, INFINITE, 0.0 if rule == "none" else uv_mesh.corner_sharpness)
    return uv_mesh._replace(corner_sharpness=corners)
