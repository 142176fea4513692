"""USD as scanners and photo tools export it: meshes with UsdPreviewSurface materials, in a .usdz or a plain file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom, UsdLux, UsdPhysics, UsdShade, UsdSkel

from usdsdg.errors import AssetUnreadable, counted
from usdsdg.meshes.model import MeshFile, Part
from usdsdg.meshes.readers.usd_looks import Looks
from usdsdg.stage import assets
from usdsdg.stage.geometry.drawn_box import DRAWN_PURPOSES
from usdsdg.stage.geometry.triangulate import triangulate
from usdsdg.stage.geometry.uv_primvars import uv_candidates
from usdsdg.stage.poses.transforms import meters_per_unit, up_axis
from usdsdg.stage.semantics.labels import get_labels

_FIRST = Usd.TimeCode.EarliestTime()


def read(file: Path) -> MeshFile:
    """Read the meshes of a USD file as they are at its first time code; transforms are applied, instances copied.

    Raises:
        AssetUnreadable: USD cannot open the file.
    """
    stage = Usd.Stage.Open(assets.open_layer(str(file)))
    looks, cache, parts = Looks(), UsdGeom.XformCache(_FIRST), []
    for prim in _meshes(stage):
        to_world = np.array(cache.GetLocalToWorldTransform(prim))
        parts += [part.moved(to_world) for part in _parts(UsdGeom.Mesh(prim), looks)]
    notes = (*(f"left out: {each}" for each in (*left_out(stage), *_beside(stage))), *looks.notes)
    up, unit = up_axis(stage), meters_per_unit(stage)
    return MeshFile(tuple(parts), tuple(looks.materials), up, unit, notes, tuple(looks.files))


def left_out(stage: Usd.Stage) -> list[str]:
    """Return what a stage has that `read` leaves out, in words; nothing for a captured object."""
    found: dict[str, None] = {}
    for prim in _prims(stage):
        found.update(dict.fromkeys(_left_out_of(prim)))
    return list(found)


def _left_out_of(prim: Usd.Prim) -> Iterator[str]:
    if prim.IsA(UsdSkel.Root) or prim.IsA(UsdSkel.Skeleton):
        yield "skeletons"
    if prim.HasAPI(UsdLux.LightAPI):
        yield "lights"
    if prim.IsA(UsdGeom.Camera):
        yield "cameras"
    if prim.IsA(UsdGeom.Gprim) and not prim.IsA(UsdGeom.Mesh):
        yield f"shapes of the type {prim.GetTypeName()}"
    if prim.IsA(UsdGeom.PointInstancer):
        yield "point instancers"
    if prim.IsA(UsdPhysics.Joint) or prim.HasAPI(UsdPhysics.RigidBodyAPI) or prim.HasAPI(UsdPhysics.CollisionAPI):
        yield "physics"
    if prim.HasVariantSets():
        yield "variants that are not selected"
    if get_labels(prim):
        yield "labels"
    if any(attribute.ValueMightBeTimeVarying() for attribute in prim.GetAuthoredAttributes()):
        yield "animation"
    if prim.IsA(UsdShade.Material) and not _is_preview(UsdShade.Material(prim)):
        yield "materials that are not UsdPreviewSurface"
    if prim.IsA(UsdGeom.Mesh) and _is_refined(UsdGeom.Mesh(prim)):
        yield "subdivision"
    if prim.IsA(UsdGeom.Mesh) and not _bound_material(prim) and _is_clear(UsdGeom.PrimvarsAPI(prim)):
        yield "displayOpacity"


def _is_refined(mesh: UsdGeom.Mesh) -> bool:
    """Whether a mesh is drawn finer than its faces: as it says, or for its creases and corners."""
    if mesh.GetPrim().GetAttribute("refinementEnableOverride").Get():
        return True
    is_sharp = bool(mesh.GetCreaseIndicesAttr().Get(_FIRST) or mesh.GetCornerIndicesAttr().Get(_FIRST))
    return is_sharp and mesh.GetSubdivisionSchemeAttr().Get() != UsdGeom.Tokens.none


def _is_clear(primvars: UsdGeom.PrimvarsAPI) -> bool:
    opacity = _values(primvars.FindPrimvarWithInheritance("displayOpacity"), 1)
    return opacity is not None and bool((opacity[0] < 1.0).any())


def _beside(stage: Usd.Stage) -> list[str]:
    """Return what is drawn beside the default prim, in words, which references leave out, too."""
    root = stage.GetDefaultPrim()
    drawn = Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()) if root else ()
    beside = [prim for prim in drawn if prim.IsA(UsdGeom.Gprim) and not prim.GetPath().HasPrefix(root.GetPath())]
    count = sum(map(_is_drawn, beside))
    return [f"{counted(count, 'shape')} beside the default prim {root.GetPath()}"] if count else []


def _is_preview(material: UsdShade.Material) -> bool:
    source = material.ComputeSurfaceSource()[0]
    return bool(source) and source.GetIdAttr().Get() == "UsdPreviewSurface"


def _prims(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    """Yield the default prim and all below it, those of instances too; without a default prim the whole stage."""
    root = stage.GetDefaultPrim() or stage.GetPseudoRoot()
    yield from Usd.PrimRange(root, Usd.TraverseInstanceProxies())


def _meshes(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    instancer = None
    for prim in _prims(stage):
        if instancer is not None and prim.GetPath().HasPrefix(instancer):
            continue  # its prototypes are drawn where its points are, and not where they stand
        if prim.IsA(UsdGeom.PointInstancer):
            instancer = prim.GetPath()
        if prim.IsA(UsdGeom.Mesh) and _is_drawn(prim):
            yield prim


def _is_drawn(prim: Usd.Prim) -> bool:
    image = UsdGeom.Imageable(prim)
    is_hidden = image.ComputeVisibility(_FIRST) == UsdGeom.Tokens.invisible
    return not is_hidden and image.ComputePurpose() in DRAWN_PURPOSES


@dataclass(frozen=True)
class _Faces:
    """The triangles of a mesh before they are divided by material."""

    points: np.ndarray  # (T, 3) points of each triangle
    corners: np.ndarray  # (T, 3) places of these in faceVertexIndices
    faces: np.ndarray  # (T,) the face that each is part of
    count: int  # faces of the mesh

    def chosen(self, faces: np.ndarray) -> _Faces:
        """Return the triangles of some faces."""
        kept = np.isin(self.faces, faces)
        return _Faces(self.points[kept], self.corners[kept], self.faces[kept], self.count)


def _parts(mesh: UsdGeom.Mesh, looks: Looks) -> Iterator[Part]:
    """Yield a part for each material of a mesh."""
    points = np.array(mesh.GetPointsAttr().Get(_FIRST) or (), np.float64).reshape(-1, 3)
    triangles = _triangles(mesh)
    binding = UsdShade.MaterialBindingAPI(mesh)
    left = np.ones(triangles.count, bool)
    for subset in binding.GetMaterialBindSubsets():
        faces = np.array(subset.GetIndicesAttr().Get(_FIRST) or (), np.int64)
        faces = faces[(faces >= 0) & (faces < triangles.count)]
        left[faces] = False
        if len(faces):
            material = _bound_material(subset.GetPrim())
            yield _part(mesh, subset.GetPrim().GetName(), points, triangles.chosen(faces), material, looks)
    if left.any():
        name = mesh.GetPrim().GetName()
        material = _bound_material(mesh.GetPrim())
        yield _part(mesh, name, points, triangles.chosen(np.flatnonzero(left)), material, looks)


def _bound_material(prim: Usd.Prim) -> UsdShade.Material:
    """Return the material that is drawn: of purpose full, else all-purpose, else preview."""
    binding = UsdShade.MaterialBindingAPI(prim)
    return (
        binding.ComputeBoundMaterial(UsdShade.Tokens.full)[0]
        or binding.ComputeBoundMaterial(UsdShade.Tokens.preview)[0]
    )


def _triangles(mesh: UsdGeom.Mesh) -> _Faces:
    """Split the faces of a mesh to triangles, counterclockwise from outside."""
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get(_FIRST) or (), np.int64)
    indices = np.array(mesh.GetFaceVertexIndicesAttr().Get(_FIRST) or (), np.int64)
    if len(counts) and (counts.min() < 0 or counts.sum() > len(indices)):
        raise AssetUnreadable(f"{mesh.GetPath()}: faceVertexCounts do not fit the length of faceVertexIndices")
    starts = np.cumsum(counts) - counts
    kept = counts >= 3
    holes = np.array(mesh.GetHoleIndicesAttr().Get(_FIRST) or (), np.int64)
    kept[holes[(holes >= 0) & (holes < len(kept))]] = False
    points = np.array(mesh.GetPointsAttr().Get(_FIRST) or (), np.float64).reshape(-1, 3)
    if (used := indices[: counts.sum()]).size and (used.min() < 0 or used.max() >= len(points)):
        raise AssetUnreadable(f"{mesh.GetPath()}: faceVertexIndices name points that do not exist")
    found = triangulate(points, counts[kept], indices, starts[kept])
    corners, faces = found.face_vertices, np.flatnonzero(kept)[found.faces]
    if mesh.GetOrientationAttr().Get(_FIRST) == UsdGeom.Tokens.leftHanded:
        corners = corners[:, ::-1]
    return _Faces(indices[corners], corners, faces, len(counts))


def _part(
    mesh: UsdGeom.Mesh, name: str, points: np.ndarray, faces: _Faces, material: UsdShade.Material, looks: Looks
) -> Part:
    primvars = UsdGeom.PrimvarsAPI(mesh)
    index, coordinates = looks.index(material)
    uvs = _uvs(primvars, coordinates.primvar)
    if uvs is not None:
        uvs = coordinates.of(uvs[0]), uvs[1]
    colors = _values(primvars.FindPrimvarWithInheritance("displayColor"), 3)
    normals = _values(primvars.GetPrimvar("normals"), 3)
    if normals is None and mesh.GetNormalsAttr().HasAuthoredValue():
        given = np.array(mesh.GetNormalsAttr().Get(_FIRST) or (), np.float64).reshape(-1, 3)
        normals = given, str(mesh.GetNormalsInterpolation())
    shared = _at_points(normals, points), _at_points(uvs, points), _at_points(colors, points)
    triangles = faces.points
    if any(given is not None and found is None for given, found in zip((normals, uvs, colors), shared)):
        # Values that differ by corner: each corner becomes a point.
        points, triangles = _taken(points, faces.points), np.arange(faces.points.size).reshape(-1, 3)
        shared = tuple(_at_corners(given, faces) for given in (normals, uvs, colors))
    return Part(name, points, triangles, *shared, material=index, is_double_sided=bool(mesh.GetDoubleSidedAttr().Get()))


_Values = tuple[np.ndarray, str]  # (N, C) and how they are interpolated


def _uvs(primvars: UsdGeom.PrimvarsAPI, name: str) -> _Values | None:
    """Return the texture coordinates by their name or another one in use, as they are drawn."""
    names = uv_candidates(name)
    found = (_values(primvar, 2) for primvar in map(primvars.GetPrimvar, names))
    own = next((values for values in found if values is not None), None)
    return _values(primvars.FindPrimvarWithInheritance(names[0]), 2) if own is None else own


def _values(primvar: UsdGeom.Primvar, size: int) -> _Values | None:
    """Return rows of `size` numbers; None where there are none. One value that is no array is that of all."""
    values = primvar.ComputeFlattened(_FIRST) if primvar and primvar.HasAuthoredValue() else None
    if values is None:
        return None
    rows = np.asarray(values)
    if rows.dtype.kind not in "biuf":
        return None
    interpolation = primvar.GetInterpolation()
    if rows.ndim < (1 if size == 1 else 2):
        rows, interpolation = rows[None], UsdGeom.Tokens.constant
    if not len(rows):
        return None
    rows = rows.astype(np.float64).reshape(len(rows), -1)
    return (rows[:, :size], str(interpolation)) if rows.shape[1] >= size else None


def _at_points(given: _Values | None, points: np.ndarray) -> np.ndarray | None:
    """Return a value for each point; None where values belong to corners or faces, or there are none."""
    if given is None:
        return None
    values, interpolation = given
    if interpolation == UsdGeom.Tokens.constant:
        return np.repeat(values[:1], len(points), axis=0)
    return values if interpolation in ("vertex", "varying") and len(values) == len(points) else None


def _at_corners(given: _Values | None, faces: _Faces) -> np.ndarray | None:
    """Return a value for each corner of the triangles; None where there are too few."""
    if given is None:
        return None
    values, interpolation = given
    rows = {"faceVarying": faces.corners, "uniform": np.repeat(faces.faces[:, None], 3, axis=1)}
    chosen = np.zeros_like(faces.points) if interpolation == "constant" else rows.get(interpolation, faces.points)
    return values[chosen.ravel()] if not chosen.size or chosen.max() < len(values) else None


def _taken(points: np.ndarray, indices: np.ndarray) -> np.ndarray:
    """Return the points of corners; those that are not there are not finite, so that repairs remove their triangles."""
    inside = (indices >= 0) & (indices < len(points))
    taken = np.full((indices.size, 3), np.nan)
    taken[inside.ravel()] = points[indices[inside]]
    return taken
