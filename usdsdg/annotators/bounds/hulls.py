"""Exact bounds of a gprim in the frame of one of its ancestors.

Authored extents are not used: they may be stale, and transforming an axis-aligned box enlarges it. Bounds of meshes are
those of the points that faces use; bounds of quadrics are those of the exact surface, which contains any tessellation.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.annotators.bounds.balls import read_balls
from usdsdg.stage.geometry.face_parts import read_face_parts
from usdsdg.stage.geometry.point_velocities import moved_points
from usdsdg.stage.geometry.skinning import Skinning

_AXES = {"X": 0, "Y": 1, "Z": 2}
# What hulls of meshes are read of, without skins and velocities.
MESH_ATTRIBUTES = (
    "points", "faceVertexCounts", "faceVertexIndices", "holeIndices", "subdivisionScheme", "refinementEnableOverride",
    "creaseIndices", "cornerIndices",
)  # fmt: skip

# Computes the bounds of a gprim under any affine transform: (matrix) → (2, 3) min and max.
Hull = Callable[[np.ndarray], np.ndarray]


def read_hull(prim: Usd.Prim, time: Usd.TimeCode, skinning: Skinning, *, divided: bool = False) -> Hull | None:
    """Return the hull of a gprim or GeomSubset in its own frame [stage units], or None when it has no finite extent.

    Skinned meshes are posed by their skeleton at `time`. divided: of a mesh, only the faces that no subset has.
    """
    kind = prim.GetTypeName()
    if kind in _QUADRICS:
        return _remembered(_QUADRICS[kind](prim, time))
    if prim.IsA(UsdGeom.Points) or prim.IsA(UsdGeom.Curves):
        centers, radii = read_balls(prim, time, skinning)
        return _remembered(_balls_hull(centers, radii)) if len(centers) else None
    if kind == "Mesh":
        left = read_face_parts(prim, time)[1] < 0 if divided else None
        points = _mesh_points(UsdGeom.Mesh(prim), time, skinning, left)
    elif kind in ("TetMesh", "NurbsPatch"):
        points = _all_points(prim, time, skinning)
    elif kind == "GeomSubset":
        points = _subset_points(prim, time, skinning)
    else:
        points = _corner_points(prim, kind, time)
    points = points[np.isfinite(points).all(axis=1)]
    return _remembered(_points_hull(points)) if len(points) else None


def _corner_points(prim: Usd.Prim, kind: str, time: Usd.TimeCode) -> np.ndarray:
    if kind == "Cube":
        half = _number(prim, "size", 2.0, time) / 2
        return _box_corners((-half,) * 3, (half,) * 3)
    if kind == "Plane":
        return _plane_corners(prim, time)
    extent = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(prim), time)
    if not extent or len(extent) != 2:
        return np.zeros((0, 3))
    return _box_corners(extent[0], extent[1])


def _all_points(prim: Usd.Prim, time: Usd.TimeCode, skinning: Skinning) -> np.ndarray:
    """Return all points of a gprim, as its skeleton or its velocities move them."""
    skinned = skinning.skin(prim, time)
    points = skinned.points if skinned is not None else moved_points(prim, time)
    points = UsdGeom.PointBased(prim).GetPointsAttr().Get(time) if points is None else points
    return np.asarray(() if points is None else points, np.float64).reshape(-1, 3)


def _mesh_points(
    mesh: UsdGeom.Mesh, time: Usd.TimeCode, skinning: Skinning, faces: np.ndarray | None = None
) -> np.ndarray:
    """Return the points that faces use which are no holes; faces: (F,) bool, of some of them."""
    points = _all_points(mesh.GetPrim(), time, skinning)
    used = np.asarray(mesh.GetFaceVertexIndicesAttr().Get(time) or (), np.int64)
    if not len(used):
        return points
    counts = np.maximum(np.asarray(mesh.GetFaceVertexCountsAttr().Get(time) or (), np.int64), 0)
    holes = np.asarray(mesh.GetHoleIndicesAttr().Get(time) or (), np.int64)
    if len(holes := holes[(holes >= 0) & (holes < len(counts))]) and not may_be_refined(mesh, time):
        faces = np.ones(len(counts), bool) if faces is None else faces.copy()
        faces[holes] = False
    if faces is not None:
        kept = np.repeat(faces, counts)
        used = used[: len(kept)][kept[: len(used)]]  # the renderer reports counts that do not add up
    # Points that no face uses are not part of the surface. The renderer reports indices out of range.
    is_used = np.zeros(len(points), bool)
    is_used[used[(used >= 0) & (used < len(points))]] = True
    return points[is_used]


def may_be_refined(mesh: UsdGeom.Mesh, time: Usd.TimeCode) -> bool:
    """Return whether pictures may show refined faces: then the points of holes shape the faces beside them."""
    if mesh.GetSubdivisionSchemeAttr().Get(time) == UsdGeom.Tokens.none:
        return False
    override = mesh.GetPrim().GetAttribute("refinementEnableOverride")
    sharp = mesh.GetCreaseIndicesAttr().Get(time) or mesh.GetCornerIndicesAttr().Get(time)
    return bool(sharp) or bool(override and override.Get(time))


def _subset_points(subset: Usd.Prim, time: Usd.TimeCode, skinning: Skinning) -> np.ndarray:
    """Return the points of the faces that are the subset's, in the frame of its mesh, which is its own."""
    mesh = subset.GetParent()
    subsets, of_face = read_face_parts(mesh, time)
    if subset.GetPath() not in subsets:
        return np.zeros((0, 3))
    return _mesh_points(UsdGeom.Mesh(mesh), time, skinning, of_face == subsets.index(subset.GetPath()))


def _plane_corners(prim: Usd.Prim, time: Usd.TimeCode) -> np.ndarray:
    axis = _axis(prim, time)
    width, length = _number(prim, "width", 2.0, time) / 2, _number(prim, "length", 2.0, time) / 2
    # UsdGeomPlane: X runs length along Y and width along Z, Y runs width along X and length along Z.
    half = {0: (0.0, length, width), 1: (width, 0.0, length), 2: (width, length, 0.0)}[axis]
    return _box_corners(tuple(-h for h in half), half)


def _box_corners(low, high) -> np.ndarray:
    return np.array([[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)], np.float64)


def _remembered(hull: Hull) -> Hull:
    """Return a hull that is not computed again for the same matrix: copies of an asset have one place in it."""

    @lru_cache(maxsize=8)
    def of_bytes(matrix: bytes) -> np.ndarray:
        return hull(np.frombuffer(matrix, np.float64).reshape(4, 4))

    return lambda matrix: of_bytes(np.ascontiguousarray(matrix, np.float64).tobytes()).copy()


def _points_hull(points: np.ndarray) -> Hull:
    def bound(matrix: np.ndarray) -> np.ndarray:
        moved = points @ matrix[:3, :3] + matrix[3, :3]
        return np.stack([moved.min(axis=0), moved.max(axis=0)])

    return bound


def _balls_hull(centers: np.ndarray, radii: np.ndarray) -> Hull:
    """Return the hull of balls, (N, 3) and (N,); see `_discs_hull`."""

    def bound(matrix: np.ndarray) -> np.ndarray:
        moved = centers @ matrix[:3, :3] + matrix[3, :3]
        reach = radii[:, None] * np.linalg.norm(matrix[:3, :3], axis=0)
        return np.stack([(moved - reach).min(axis=0), (moved + reach).max(axis=0)])

    return bound


def _discs_hull(discs: list[tuple[np.ndarray, np.ndarray | None, float]]) -> Hull:
    """Return the hull of several discs (center, unit axis, radius), or balls where the axis is None.

    Under the linear map L the support of a ball of radius r along axis j is r |L column j|; of a disc it is the same
    with the component of the column along its normal removed.
    """

    def bound(matrix: np.ndarray) -> np.ndarray:
        linear, low, high = matrix[:3, :3], [], []
        for center, normal, radius in discs:
            columns = linear if normal is None else linear - np.outer(normal, normal @ linear)
            middle, support = center @ linear + matrix[3, :3], radius * np.linalg.norm(columns, axis=0)
            low.append(middle - support)
            high.append(middle + support)
        return np.stack([np.min(low, axis=0), np.max(high, axis=0)])

    return bound


def _sphere(prim: Usd.Prim, time: Usd.TimeCode) -> Hull:
    return _discs_hull([(np.zeros(3), None, _number(prim, "radius", 1.0, time))])


def _capsule(prim: Usd.Prim, time: Usd.TimeCode) -> Hull:
    along, half = _axis_and_half_height(prim, 1.0, time)
    radius = _number(prim, "radius", 0.5, time)
    return _discs_hull([(-along * half, None, radius), (along * half, None, radius)])


def _tapered_capsule(prim: Usd.Prim, time: Usd.TimeCode) -> Hull:
    """Bound the two balls that are tangent to the cone frustum at its ends."""
    along, half = _axis_and_half_height(prim, 1.0, time)
    bottom, top = _number(prim, "radiusBottom", 0.5, time), _number(prim, "radiusTop", 0.5, time)
    if half == 0.0:
        return _discs_hull([(np.zeros(3), None, max(bottom, top))])
    slope = (bottom - top) / (2 * half)
    widening = np.hypot(1.0, slope)
    low, high = -along * (half + bottom * slope), along * (half - top * slope)
    return _discs_hull([(low, None, bottom * widening), (high, None, top * widening)])


def _tapered_cylinder(prim: Usd.Prim, time: Usd.TimeCode) -> Hull:
    along, half = _axis_and_half_height(prim, 2.0, time)
    bottom, top = _number(prim, "radiusBottom", 1.0, time), _number(prim, "radiusTop", 1.0, time)
    return _discs_hull([(-along * half, along, bottom), (along * half, along, top)])


def _cylinder(prim: Usd.Prim, time: Usd.TimeCode) -> Hull:
    along, half = _axis_and_half_height(prim, 2.0, time)
    radius = _number(prim, "radius", 1.0, time)
    return _discs_hull([(-along * half, along, radius), (along * half, along, radius)])


def _cone(prim: Usd.Prim, time: Usd.TimeCode) -> Hull:
    along, half = _axis_and_half_height(prim, 2.0, time)
    return _discs_hull([(-along * half, along, _number(prim, "radius", 1.0, time)), (along * half, along, 0.0)])


_QUADRICS: dict[str, Callable[[Usd.Prim, Usd.TimeCode], Hull]] = {
    "Sphere": _sphere,
    "Capsule": _capsule,
    "Capsule_1": _tapered_capsule,
    "Cylinder": _cylinder,
    "Cylinder_1": _tapered_cylinder,
    "Cone": _cone,
}


def _axis_and_half_height(prim: Usd.Prim, default_height: float, time: Usd.TimeCode) -> tuple[np.ndarray, float]:
    """Return the unit axis and half the height."""
    return np.eye(3)[_axis(prim, time)], _number(prim, "height", default_height, time) / 2


def _axis(prim: Usd.Prim, time: Usd.TimeCode) -> int:
    return _AXES.get(str(prim.GetAttribute("axis").Get(time) or "Z"), 2)


def _number(prim: Usd.Prim, name: str, default: float, time: Usd.TimeCode) -> float:
    value = prim.GetAttribute(name).Get(time)
    return float(default if value is None else value)
