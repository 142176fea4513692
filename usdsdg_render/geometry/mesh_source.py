"""Read the attributes of a UsdGeomMesh that determine its triangles, as zero-copy arrays."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg import errors
from usdsdg.stage.geometry.point_velocities import moved_points
from usdsdg.stage.geometry.tet_meshes import surface_faces
from usdsdg.stage.geometry.uv_primvars import uv_candidates
from usdsdg_render.usd.authored_values import as_array
from usdsdg_render.usd.color_spaces import linear_colors
from usdsdg_render.usd.tokens import token

EMPTY = np.zeros(0, np.int32)
_SCHEMES = ("catmullClark", "loop", "bilinear", "none")
_SHARPNESS = ("creaseIndices", "creaseLengths", "creaseSharpnesses", "cornerIndices", "cornerSharpnesses")


class Primvar(NamedTuple):
    """A primvar as authored."""

    values: np.ndarray
    indices: np.ndarray  # empty: not indexed
    interpolation: str  # constant, uniform, varying, vertex or faceVarying


class Refinement(NamedTuple):
    """How a subdivision surface is refined, with its creases and corners."""

    level: int | None  # None: chosen by the number of faces
    boundary: str  # interpolateBoundary
    face_varying: str  # faceVaryingLinearInterpolation
    crease_vertices: np.ndarray  # creaseIndices: the vertices of all creases, one after the other
    crease_lengths: np.ndarray
    crease_sharpness: np.ndarray  # one a crease, or one an edge
    corner_vertices: np.ndarray
    corner_sharpness: np.ndarray

    def arrays(self) -> tuple[np.ndarray, ...]:
        return self[3:]


class MeshSource(NamedTuple):
    """The attributes of a mesh that determine its triangles, as zero-copy views of USD's arrays."""

    points: np.ndarray
    counts: np.ndarray
    indices: np.ndarray
    holes: np.ndarray
    normals: Primvar | None
    uvs: Primvar | None
    subsets: tuple[np.ndarray, ...]
    left_handed: bool
    scheme: str
    refinement: Refinement | None = None  # None: not refined
    colors: Primvar | None = None  # displayColor, if read
    opacities: Primvar | None = None
    colored: tuple[int, ...] = ()  # material slots that show these

    def without_paint(self) -> "MeshSource":
        """Return what determines the triangles and their normals, without what is painted on them."""
        return self._replace(uvs=None, colors=None, opacities=None, colored=())

    def arrays(self) -> tuple[np.ndarray, ...]:
        normals = () if self.normals is None else self.normals[:2]
        sharpness = self.refinement.arrays() if self.refinement is not None else ()
        painted = self.painted_arrays()
        return (self.points, self.counts, self.indices, self.holes, *self.subsets, *normals, *sharpness, *painted)

    def painted_arrays(self) -> tuple[np.ndarray, ...]:
        return tuple(array for primvar in self._paint() if primvar is not None for array in primvar[:2])

    def settings(self) -> tuple:
        """Return what determines the triangles beside the arrays."""
        return (
            self.left_handed,
            self.scheme,
            None if self.normals is None else self.normals.interpolation,
            len(self.subsets),
            self.refinement[:3] if self.refinement is not None else None,
            *self.painted_settings(),
        )

    def painted_settings(self) -> tuple:
        return (self.colored, *(None if primvar is None else primvar.interpolation for primvar in self._paint()))

    def _paint(self) -> tuple[Primvar | None, ...]:
        return self.uvs, self.colors, self.opacities


def read_mesh(
    prim: Usd.Prim,
    time: Usd.TimeCode,
    *,
    uv_name: str = "",
    subsets: Sequence[Usd.Prim] = (),
    colored: tuple[int, ...] = (),
) -> MeshSource | None:
    """Read a mesh at `time`; None (with a warning) when it has no points or faces.

    Args:
        uv_name: primvar of the texture coordinates; where "" or missing, `uv_candidates` are tried, then any
            texCoord2f.
        subsets: material subsets.
        colored: material slots that show displayColor and displayOpacity, in place of texture coordinates.
    """
    points = read_points(prim, time)
    is_tet_mesh = prim.GetTypeName() == "TetMesh"
    if is_tet_mesh:
        indices = surface_faces(prim, time).ravel()
        counts = np.full(len(indices) // 3, 3, np.int32)
    else:
        counts = read_array(prim, "faceVertexCounts", time, ())
        indices = read_array(prim, "faceVertexIndices", time, ())
    if points is None or counts is None or indices is None or not (len(points) and len(counts) and len(indices)):
        faces = "tetVertexIndices" if is_tet_mesh else "faceVertexCounts and faceVertexIndices"
        errors.warn_once(
            f"{prim.GetPath()}: the mesh is empty (no points or no faces) and is not drawn. Author points, "
            f"{faces}, or remove the prim."
        )
        return None
    holes = read_array(prim, "holeIndices", time, ())
    if holes is not None and ((holes < 0) | (holes >= len(counts))).any():
        errors.warn_once(
            f"{prim.GetPath()}: holeIndices names faces that do not exist (it has {len(counts)}); these are ignored. "
            "Correct it."
        )
    scheme = "none" if is_tet_mesh else token(prim, "subdivisionScheme", time, _SCHEMES)
    return MeshSource(
        points=points,
        counts=counts,
        indices=indices,
        holes=EMPTY if holes is None else holes,
        normals=_normals(prim, time),
        uvs=None if len(colored) > len(subsets) else read_uvs(prim, time, uv_name),
        subsets=tuple(_subset_faces(subset, time) for subset in subsets),
        left_handed=token(prim, "orientation", time, ("rightHanded", "leftHanded")) == "leftHanded",
        scheme=scheme,
        refinement=None if scheme == "none" else _refinement(prim, time),
        colors=read_colors(prim, time) if colored else None,
        opacities=read_primvar(prim, "primvars:displayOpacity", time, ()) if colored else None,
        colored=colored,
    )


def _refinement(prim: Usd.Prim, time: Usd.TimeCode) -> Refinement | None:
    """Read how a mesh is refined: as Omniverse's override says, else only if it has creases or corners."""
    sharpness = [read_array(prim, name, time, ()) for name in _SHARPNESS]
    override = prim.GetAttribute("refinementEnableOverride")
    level = None
    if override and override.Get(time) is True:
        level = int(prim.GetAttribute("refinementLevel").Get(time) or 0) if prim.HasAttribute("refinementLevel") else 0
        if level <= 0:
            return None
    elif not any(array is not None and len(array) for array in sharpness):
        return None
    if prim.GetAttribute("triangleSubdivisionRule").Get(time) == "smooth":
        errors.warn_once(
            f"{prim.GetPath()}: triangleSubdivisionRule smooth is not supported; its triangles are refined like other "
            f"faces. Set it to catmullClark."
        )
    return Refinement(
        level,
        str(prim.GetAttribute("interpolateBoundary").Get(time) or "edgeAndCorner"),
        str(prim.GetAttribute("faceVaryingLinearInterpolation").Get(time) or "cornersPlus1"),
        *(EMPTY if array is None else array for array in sharpness),
    )


def value_at(attribute: Usd.Attribute, time: Usd.TimeCode) -> Any:
    """Return the value at `time`; at the default time, an attribute with time samples only has its first one."""
    value = attribute.Get(time)
    if value is None and time.IsDefault():
        value = attribute.Get(Usd.TimeCode.EarliestTime())
    return value


def read_array(prim: Usd.Prim, name: str, time: Usd.TimeCode, tail: tuple[int, ...]) -> np.ndarray | None:
    """Read an array of rows of shape `tail`; None where there is none, or (with a warning) one of another type."""
    attribute = prim.GetAttribute(name)
    return as_array(attribute, value_at(attribute, time), tail) if attribute else None


def read_points(prim: Usd.Prim, time: Usd.TimeCode) -> np.ndarray | None:
    """Read the (V, 3) points of a gprim, which velocities may move; None where there are none."""
    moved = moved_points(prim, time)
    return read_array(prim, "points", time, (3,)) if moved is None else np.asarray(moved)


def _subset_faces(subset: Usd.Prim, time: Usd.TimeCode) -> np.ndarray:
    faces = read_array(subset, "indices", time, ())
    return EMPTY if faces is None else faces


def read_primvar(prim: Usd.Prim, name: str, time: Usd.TimeCode, tail: tuple[int, ...]) -> Primvar | None:
    """Read a primvar with rows of shape `tail`, by the name of its attribute; None where there is none."""
    values = read_array(prim, name, time, tail)
    if values is None or not len(values):
        return None
    indices = read_array(prim, f"{name}:indices", time, ())
    interpolation = prim.GetAttribute(name).GetMetadata("interpolation")
    return Primvar(values, EMPTY if indices is None else indices, str(interpolation or "constant"))


def read_colors(prim: Usd.Prim, time: Usd.TimeCode) -> Primvar | None:
    """Read the displayColor of a gprim as linear Rec. 709."""
    primvar = read_primvar(prim, "primvars:displayColor", time, (3,))
    return primvar and primvar._replace(
        values=linear_colors(prim.GetAttribute("primvars:displayColor"), primvar.values)
    )


def _normals(prim: Usd.Prim, time: Usd.TimeCode) -> Primvar | None:
    """primvars:normals wins over normals, whose interpolation is `vertex` unless authored (UsdGeomPointBased)."""
    primvar = read_primvar(prim, "primvars:normals", time, (3,))
    if primvar is not None:
        return primvar
    values = read_array(prim, "normals", time, (3,))
    if values is None or not len(values):
        return None
    interpolation = prim.GetAttribute("normals").GetMetadata("interpolation")
    return Primvar(values, EMPTY, str(interpolation or "vertex"))


def read_uvs(prim: Usd.Prim, time: Usd.TimeCode, uv_name: str) -> Primvar | None:
    """Read the texture coordinates of a mesh, see `read_mesh`; None where there are none."""
    names = uv_candidates(uv_name)
    for name in names:
        primvar = _uv_primvar(prim, f"primvars:{name}", time)
        if primvar is not None:
            return primvar
    primvars = UsdGeom.PrimvarsAPI(prim)
    if inherited := primvars.FindPrimvarWithInheritance(names[0]):  # of an ancestor, where it is constant
        attribute = inherited.GetAttr()
        return _uv_primvar(attribute.GetPrim(), str(attribute.GetName()), time)
    for primvar in primvars.GetPrimvarsWithValues():
        if str(primvar.GetTypeName()).startswith("texCoord"):
            return _uv_primvar(prim, str(primvar.GetName()), time)
    return None


def _uv_primvar(prim: Usd.Prim, name: str, time: Usd.TimeCode) -> Primvar | None:
    """Read texture coordinates of two numbers, or the first two of three."""
    attribute = prim.GetAttribute(name)
    if not attribute or "3" not in str(attribute.GetTypeName()):  # some write them as float3 or vector3f
        return read_primvar(prim, name, time, (2,))
    primvar = read_primvar(prim, name, time, (3,))
    return primvar and primvar._replace(values=np.ascontiguousarray(primvar.values[:, :2]))
