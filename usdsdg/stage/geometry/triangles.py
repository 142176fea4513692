"""Triangles of the gprims on a stage, for code that needs geometry without a renderer."""

from collections.abc import Callable, Iterable, Iterator
from itertools import repeat
from typing import NamedTuple, TypeAlias

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.stage.geometry.face_triangles import face_triangles
from usdsdg.stage.geometry.tet_meshes import surface_faces
from usdsdg.stage.poses.transforms import as_array

# Sides of the polygons that approximate circles.
SEGMENTS = 48
# Reads a size attribute of a shape by name.
Size: TypeAlias = Callable[[str], float]
# Chooses faces of a mesh: (F,) bool; None for all of them.
Faces: TypeAlias = Callable[[Usd.Prim], np.ndarray | None]
# Gives the matrix (4, 4) from a prim to the space that triangles are placed in.
Place: TypeAlias = Callable[[Usd.Prim], np.ndarray]
# Whether a prim is left out, with all below it.
LeftOut: TypeAlias = Callable[[Usd.Prim], bool]
# Permutation of coordinates that rotates shapes around +Z to another axis.
_AXES = {"X": [2, 0, 1], "Y": [1, 2, 0], "Z": [0, 1, 2]}

# UsdGeomPlane: with the axis X its length is along Y and its width along Z; with Y, width along X, length along Z.
_SIZES_OF_TURNED_PLANES = {"width": "length", "length": "width"}


class Triangles(NamedTuple):
    """Triangles of one gprim, counter-clockwise seen from outside."""

    points: np.ndarray  # (V, 3) float64 [units of their space]
    faces: np.ndarray  # (T, 3) int64 into points

    def corners(self) -> np.ndarray:
        """Return the corners of each triangle (T, 3, 3)."""
        return self.points[self.faces]


class TriangleInstance(NamedTuple):
    """Triangles of a gprim, or of one of its instances by a point instancer, with their transform."""

    path: str
    triangles: Triangles  # in its own space
    to_world: np.ndarray  # (4, 4) row vectors

    def in_world(self) -> Triangles:
        """Return the triangles in the world; mirroring transforms reverse them, so that they keep facing outwards."""
        points = self.triangles.points @ self.to_world[:3, :3] + self.to_world[3, :3]
        mirrored = np.linalg.det(self.to_world[:3, :3]) < 0
        return Triangles(points, self.triangles.faces[:, ::-1] if mirrored else self.triangles.faces)


def triangles_below(
    prims: Iterable[Usd.Prim],
    faces_of: Faces | None = None,
    *,
    left_out: LeftOut | None = None,
    time: Usd.TimeCode = Usd.TimeCode.Default(),  # noqa: B008
) -> list[TriangleInstance]:
    """Return the triangles of all gprims at and below `prims`, visible or not, also in instances and point instancers.

    Meshes are read as their control cage; faces are triangulated. faces_of: which of a mesh are read.
    left_out: asked of all prims, also of those in prototypes.
    """
    cache = UsdGeom.XformCache(time)
    return _below(prims, lambda prim: as_array(cache.GetLocalToWorldTransform(prim)), faces_of, left_out, time)


def _below(
    prims: Iterable[Usd.Prim], place_of: Place, faces_of: Faces | None, left_out: LeftOut | None, time: Usd.TimeCode
) -> list[TriangleInstance]:
    found = []
    for root in prims:
        walk = iter(range_below(root))
        for prim in walk:
            if left_out is not None and left_out(prim):
                walk.PruneChildren()
            elif prim.IsA(UsdGeom.PointInstancer):
                walk.PruneChildren()
                found += _instances(UsdGeom.PointInstancer(prim), place_of(prim), faces_of, left_out, time)
            elif prim.IsA(UsdGeom.Gprim) and (own := own_triangles(prim, faces_of, time)) is not None:
                found.append(TriangleInstance(str(prim.GetPath()), own, place_of(prim)))
    return found


def range_below(root: Usd.Prim) -> Usd.PrimRange:
    """Return the prims at and below one, also where it is a class or an over, as prototypes may be."""
    is_drawn = root.IsDefined() and not root.IsAbstract()
    predicate = Usd.PrimDefaultPredicate if is_drawn else Usd.PrimIsActive & Usd.PrimIsLoaded
    return Usd.PrimRange(root, Usd.TraverseInstanceProxies(predicate))


def _instances(
    instancer: UsdGeom.PointInstancer,
    to_world: np.ndarray,
    faces_of: Faces | None,
    left_out: LeftOut | None,
    time: Usd.TimeCode,
) -> Iterator[TriangleInstance]:
    stage, path = instancer.GetPrim().GetStage(), str(instancer.GetPath())
    transforms = instancer.ComputeInstanceTransformsAtTime(time, time, UsdGeom.PointInstancer.ExcludeProtoXform)
    mask = instancer.ComputeMaskAtTime(time)
    every = enumerate(instancer.GetProtoIndicesAttr().Get(time) or ())
    shown = [each for each, is_shown in zip(every, mask or repeat(True)) if is_shown]
    parts: dict[int, list[TriangleInstance]] = {}
    for kind, target in enumerate(instancer.GetPrototypesRel().GetForwardedTargets()):
        root = stage.GetPrimAtPath(target)
        parts[kind] = _below([root], _place_above(root, time), faces_of, left_out, time) if root else []
    for (index, kind), transform in zip(shown, transforms):
        for part in parts.get(kind, ()):
            yield TriangleInstance(f"{path}[{index}]", part.triangles, part.to_world @ as_array(transform) @ to_world)


def _place_above(root: Usd.Prim, time: Usd.TimeCode) -> Place:
    """Return what gives the matrix of a prim in a prototype to the frame above its root, which points move.

    Points also move prims that reset the transform stack: such a prim is placed in that frame, not in the world.
    """
    cache, above = UsdGeom.XformCache(time), root.GetParent()
    return lambda prim: as_array(cache.ComputeRelativeTransform(prim, above)[0])


def own_triangles(
    prim: Usd.Prim,
    faces_of: Faces | None = None,
    time: Usd.TimeCode = Usd.TimeCode.Default(),  # noqa: B008
) -> Triangles | None:
    """Return the triangles of a gprim in its own space; None for prims without faces (curves, points, empty meshes)."""
    if prim.GetTypeName() == "TetMesh":
        return _of_tet_mesh(prim, time)
    if prim.IsA(UsdGeom.Mesh):
        return _of_mesh(UsdGeom.Mesh(prim), None if faces_of is None else faces_of(prim), time)
    shape = _SHAPES.get(str(prim.GetTypeName()))
    if shape is None:
        return None
    axis = str(prim.GetAttribute("axis").Get()) if prim.HasAttribute("axis") else "Z"
    sizes = _SIZES_OF_TURNED_PLANES if prim.GetTypeName() == "Plane" and axis != "Z" else {}
    points, faces = shape(lambda name: float(prim.GetAttribute(sizes.get(name, name)).Get(time)))
    points = points[:, _AXES[axis]]
    return Triangles(points, _with_area(points, faces))


def _cube(size: Size) -> tuple[np.ndarray, np.ndarray]:
    points = (np.array(list(np.ndindex(2, 2, 2)), np.float64) - 0.5) * size("size")
    quads = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    return points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def _plane(size: Size) -> tuple[np.ndarray, np.ndarray]:
    x, y = size("width") / 2, size("length") / 2
    return np.array([(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)]), np.array([(0, 1, 2), (0, 2, 3)])


def _sphere(size: Size) -> tuple[np.ndarray, np.ndarray]:
    return _revolved(_arc(-90, 90) * size("radius"))


def _capsule(size: Size) -> tuple[np.ndarray, np.ndarray]:
    radius, half = size("radius"), size("height") / 2
    return _revolved(np.concatenate([_arc(-90, 0) * radius - (0, half), _arc(0, 90) * radius + (0, half)]))


def _cylinder(size: Size) -> tuple[np.ndarray, np.ndarray]:
    radius, half = size("radius"), size("height") / 2
    return _revolved(np.array([(0, -half), (radius, -half), (radius, half), (0, half)]))


def _cone(size: Size) -> tuple[np.ndarray, np.ndarray]:
    radius, half = size("radius"), size("height") / 2
    return _revolved(np.array([(0, -half), (radius, -half), (0, half)]))


def _tapered_cylinder(size: Size) -> tuple[np.ndarray, np.ndarray]:
    half = size("height") / 2
    return _revolved(np.array([(0, -half), (size("radiusBottom"), -half), (size("radiusTop"), half), (0, half)]))


def _tapered_capsule(size: Size) -> tuple[np.ndarray, np.ndarray]:
    """Return a frustum with a ball at each end that is tangent to it, as in UsdGeomCapsule_1's extent."""
    bottom, top, height = size("radiusBottom"), size("radiusTop"), size("height")
    if height == 0.0:
        return _revolved(_arc(-90, 90) * max(bottom, top))
    slope = (bottom - top) / height
    tangent, widening = np.degrees(np.arctan(slope)), np.hypot(1.0, slope)
    low, high = -height / 2 - bottom * slope, height / 2 - top * slope  # centers of the balls
    ends = _arc(-90, tangent) * bottom * widening + (0, low), _arc(tangent, 90) * top * widening + (0, high)
    return _revolved(np.concatenate(ends))


def _arc(start: float, end: float) -> np.ndarray:
    angle = np.radians(np.linspace(start, end, round(abs(end - start) * SEGMENTS / 360) + 1))
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _revolved(profile: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points and faces of the surface of revolution of a profile (radius, z), bottom to top, around Z."""
    angle = np.arange(SEGMENTS) * (2 * np.pi / SEGMENTS)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    flat = profile[:, None, :1] * ring
    points = np.concatenate([flat, np.broadcast_to(profile[:, None, 1:], (*flat.shape[:2], 1))], axis=-1).reshape(-1, 3)
    row, column = np.indices((len(profile) - 1, SEGMENTS)).reshape(2, -1)
    here, following = row * SEGMENTS + column, row * SEGMENTS + (column + 1) % SEGMENTS
    lower = np.stack([here, following, following + SEGMENTS], axis=1)
    return points, np.concatenate([lower, np.stack([here, following + SEGMENTS, here + SEGMENTS], axis=1)])


_SHAPES = {
    "Cube": _cube,
    "Sphere": _sphere,
    "Cylinder": _cylinder,
    "Cylinder_1": _tapered_cylinder,
    "Cone": _cone,
    "Capsule": _capsule,
    "Capsule_1": _tapered_capsule,
    "Plane": _plane,
}


def _of_mesh(mesh: UsdGeom.Mesh, chosen: np.ndarray | None, time: Usd.TimeCode) -> Triangles | None:
    points = np.array(_value(mesh.GetPointsAttr(), time) or (), np.float64).reshape(-1, 3)
    counts = np.array(_value(mesh.GetFaceVertexCountsAttr(), time) or (), np.int64)
    indices = np.array(_value(mesh.GetFaceVertexIndicesAttr(), time) or (), np.int64)
    holes = np.array(_value(mesh.GetHoleIndicesAttr(), time) or (), np.int64)
    left_out = holes if chosen is None else np.concatenate([holes, np.flatnonzero(~chosen)])
    faces = face_triangles(points, counts, indices, left_out).triangles
    if mesh.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded:
        faces = faces[:, ::-1]
    return _of_faces(points, faces)


def _of_tet_mesh(prim: Usd.Prim, time: Usd.TimeCode) -> Triangles | None:
    points = np.array(_value(prim.GetAttribute("points"), time) or (), np.float64).reshape(-1, 3)
    faces = surface_faces(prim, time)
    faces = faces[((faces >= 0) & (faces < len(points))).all(axis=1)]
    if prim.GetAttribute("orientation").Get() == UsdGeom.Tokens.leftHanded:
        faces = faces[:, ::-1]
    return _of_faces(points, faces.astype(np.int64))


def _of_faces(points: np.ndarray, faces: np.ndarray) -> Triangles | None:
    """Return the triangles that have an area, without the points that none of them uses."""
    faces = _with_area(points, faces)
    if not len(faces):
        return None
    used, inverse = np.unique(faces, return_inverse=True)
    return Triangles(points[used], inverse.reshape(faces.shape))


def _value(attribute: Usd.Attribute, time: Usd.TimeCode) -> object:
    """Return the value of an attribute; at the default time its first time sample if it has no default."""
    value = attribute.Get(time)
    return attribute.Get(Usd.TimeCode.EarliestTime()) if value is None else value


def _with_area(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the faces without those that are degenerate or not finite."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.maximum(((b - a) ** 2).sum(1), ((c - a) ** 2).sum(1))
    return faces[np.isfinite(area) & (area > 1e-12 * longest)]
