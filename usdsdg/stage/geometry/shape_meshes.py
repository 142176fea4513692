"""Meshes of the shapes that scripts create: in Kit's sizes, with normals and UVs, along the stage's up axis."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from usdsdg.errors import Unsupported
from usdsdg.stage.poses.transforms import meters_per_unit, up_axis

SEGMENTS = 48
# Axis and side of each face of a cube, in the order of Omniverse's mesh, whose numbers scripts give to subsets.
_CUBE_FACES = ((2, 1.0), (2, -1.0), (1, 1.0), (1, -1.0), (0, -1.0), (0, 1.0))
GPRIMS = ("Sphere", "Cube", "Cylinder", "Cone", "Capsule", "Plane")


def define(stage: Usd.Stage, path: str, kind: str) -> UsdGeom.Mesh:
    """Define a mesh of shape `kind`: Sphere, Cube, Cylinder, Cone, Capsule, Torus, Disk or Plane.

    It is one meter in size, in stage units, and aligned with the stage's up axis. A capsule is one meter high with its
    caps and half a meter wide; a torus is a tube of half a meter around a ring of one meter.
    """
    size = 1.0 / meters_per_unit(stage)
    shape = _shape(kind, up_axis(stage), size)
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(shape.points)
    mesh.CreateFaceVertexCountsAttr(shape.counts)
    mesh.CreateFaceVertexIndicesAttr(shape.corners)
    mesh.CreateNormalsAttr(shape.normals)
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.faceVarying)
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying)
    st.Set(shape.uvs)
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateExtentAttr(shape.extent)
    return mesh


class _Shape(NamedTuple):
    """Attributes of a mesh; the Vt arrays are shared by all meshes of the shape."""

    points: Vt.Vec3fArray
    counts: Vt.IntArray
    corners: Vt.IntArray
    normals: Vt.Vec3fArray  # per corner
    uvs: Vt.Vec2fArray  # per corner
    extent: list[Gf.Vec3f]


@lru_cache(maxsize=64)
def _shape(kind: str, up_axis: str, size: float) -> _Shape:
    points, normals, uvs, quads = _cube() if kind == "Cube" else _surface_of_revolution(kind)
    if up_axis == "Y":
        # Rotate +Z to +Y; a cyclic permutation of the axes keeps handedness.
        points, normals = points[:, [1, 2, 0]], normals[:, [1, 2, 0]]
    points = (points * size).astype(np.float32)
    corners = quads.ravel()
    return _Shape(
        Vt.Vec3fArray.FromNumpy(points),
        Vt.IntArray.FromNumpy(np.full(len(quads), 4, np.int32)),
        Vt.IntArray.FromNumpy(corners.astype(np.int32)),
        Vt.Vec3fArray.FromNumpy(normals[corners].astype(np.float32)),
        Vt.Vec2fArray.FromNumpy(uvs[corners].astype(np.float32)),
        [Gf.Vec3f(*points.min(0).tolist()), Gf.Vec3f(*points.max(0).tolist())],
    )


def define_gprim(stage: Usd.Stage, path: str, kind: str) -> Usd.Prim:
    """Define the UsdGeom prim of shape `kind`, in USD's default size as in Replicator: two stage units across.

    Raises:
        Unsupported: UsdGeom has no such shape (torus, disk).
    """
    if kind not in GPRIMS:
        raise Unsupported(f"{path}: UsdGeom has no {kind.lower()}; create it with as_mesh=True")
    prim = stage.DefinePrim(path, kind)
    if prim.HasAttribute("axis"):
        prim.GetAttribute("axis").Set(up_axis(stage))
    UsdGeom.Boundable(prim).CreateExtentAttr(UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(prim), 0))
    return prim


def _cube() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    points, normals, uvs = [], [], []
    for axis, sign in _CUBE_FACES:
        u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
        normal = np.eye(3)[axis] * sign
        for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            points.append((normal + u * a * sign + v * b) / 2)
            normals.append(normal)
            uvs.append(((a + 1) / 2, (b + 1) / 2))
    return np.array(points), np.array(normals), np.array(uvs), np.arange(24).reshape(6, 4)


def _profile(kind: str) -> list[np.ndarray]:
    """Return the smooth pieces of the profile (radius, z), from bottom to top, each a polyline."""
    if kind == "Sphere":
        angle = np.linspace(-np.pi / 2, np.pi / 2, SEGMENTS // 2 + 1)
        return [np.stack([np.cos(angle), np.sin(angle)], 1) / 2]
    if kind == "Capsule":
        angle = np.linspace(-np.pi / 2, np.pi / 2, SEGMENTS // 2 + 1)
        ball = np.stack([np.cos(angle), np.sin(angle)], 1) / 4
        middle = len(angle) // 2
        quarter = np.array([0.0, 0.25])
        return [np.concatenate([ball[: middle + 1] - quarter, ball[middle:] + quarter])]
    if kind == "Torus":
        angle = np.linspace(0, 2 * np.pi, SEGMENTS // 2 + 1)
        return [np.stack([0.5 + 0.25 * np.cos(angle), 0.25 * np.sin(angle)], 1)]
    bottom = np.array([[0.0, -0.5], [0.5, -0.5]])
    return {
        "Cylinder": [bottom, np.array([[0.5, -0.5], [0.5, 0.5]]), np.array([[0.5, 0.5], [0.0, 0.5]])],
        "Cone": [bottom, np.array([[0.5, -0.5], [0.0, 0.5]])],
        "Disk": [np.array([[0.5, 0.0], [0.0, 0.0]])],
        "Plane": [],
    }[kind]


def _surface_of_revolution(kind: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return points, normals, UVs and quads of the surface of revolution around Z.

    Every piece of the profile has its own vertices, so that edges between pieces stay hard.
    """
    if kind == "Plane":
        square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float)
        points = np.concatenate([square - 0.5, np.zeros((4, 1))], axis=1)
        return points, np.tile([0.0, 0.0, 1.0], (4, 1)), square, np.arange(4).reshape(1, 4)
    points, normals, uvs, quads = [], [], [], []
    angle = np.linspace(0, 2 * np.pi, SEGMENTS + 1)
    first = 0
    for piece in _profile(kind):
        tangent = np.gradient(piece, axis=0)
        outward = np.stack([tangent[:, 1], -tangent[:, 0]], 1)
        outward /= np.linalg.norm(outward, axis=1, keepdims=True)
        rows = len(piece)
        ring = np.stack([np.cos(angle), np.sin(angle)], 1)
        points.append(_revolved(piece, ring))
        normals.append(_revolved(outward, ring))
        v = np.linspace(0, 1, rows)
        uvs.append(np.stack(np.broadcast_arrays(angle[None, :] / (2 * np.pi), v[:, None]), -1).reshape(-1, 2))
        i, j = np.meshgrid(np.arange(rows - 1), np.arange(SEGMENTS), indexing="ij")
        a = first + i * (SEGMENTS + 1) + j
        quads.append(np.stack([a, a + 1, a + SEGMENTS + 2, a + SEGMENTS + 1], -1).reshape(-1, 4))
        first += rows * (SEGMENTS + 1)
    return np.concatenate(points), np.concatenate(normals), np.concatenate(uvs), np.concatenate(quads)


def _revolved(profile: np.ndarray, ring: np.ndarray) -> np.ndarray:
    flat = profile[:, None, :1] * ring[None, :, :]
    height = np.broadcast_to(profile[:, None, 1:], (*flat.shape[:2], 1))
    return np.concatenate([flat, height], axis=-1).reshape(-1, 3)
