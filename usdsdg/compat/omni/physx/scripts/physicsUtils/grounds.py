"""Grounds, and meshes for them."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from usdsdg.compat.omni.physx.scripts.physicsUtils.shapes import AnyPath, get_stage_next_free_path
from usdsdg.compat.omni.physx.scripts.physicsUtils.xform_ops import Vector, place

_UNTURNED, _ONE = Gf.Quatf(1.0), Gf.Vec3f(1.0)
# Directions of the corners of a square in its plane, counterclockwise around its normal.
_SQUARES = {
    "X": ((0, -1, -1), (0, 1, -1), (0, 1, 1), (0, -1, 1)),
    "Y": ((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)),
    "Z": ((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)),
}
_FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


def add_ground_plane(
    stage: Usd.Stage, planePath: AnyPath, axis: str, size: float, position: Vector, color: Gf.Vec3f
) -> str:
    """Add an Xform with a square that is seen and an unbounded plane that collides; return its path.

    Args:
        axis: Normal of the plane: "X", "Y" or "Z".
        size: Half of the length of the square's edges [stage units].
    """
    path = get_stage_next_free_path(stage, planePath, True)
    place(UsdGeom.Xform.Define(stage, path), position, _UNTURNED, _ONE)
    create_mesh_square_axis(stage, f"{path}/CollisionMesh", axis, size).CreateDisplayColorAttr([Gf.Vec3f(color)])
    plane = UsdGeom.Plane.Define(stage, f"{path}/CollisionPlane")
    plane.CreatePurposeAttr(UsdGeom.Tokens.guide)
    plane.CreateAxisAttr(axis)
    UsdPhysics.CollisionAPI.Apply(plane.GetPrim())
    return path


def add_quad_plane(
    stage: Usd.Stage, quadPath: AnyPath, axis: str, size: float, position: Vector, color: Gf.Vec3f
) -> None:
    """Add a square that collides; see `add_ground_plane`."""
    mesh = create_mesh_square_axis(stage, get_stage_next_free_path(stage, quadPath, True), axis, size)
    mesh.CreateDisplayColorAttr([Gf.Vec3f(color)])
    place(mesh, position, _UNTURNED, _ONE)
    UsdPhysics.CollisionAPI.Apply(mesh.GetPrim())


def add_cube_ground_plane(
    stage: Usd.Stage, cubePath: AnyPath, axis: str, size: float, position: Vector, color: Gf.Vec3f
) -> None:
    """Add a Cube of `size` that is flattened to a hundredth along `axis` and collides."""
    cube = UsdGeom.Cube.Define(stage, get_stage_next_free_path(stage, cubePath, True))
    cube.CreateSizeAttr(size)
    cube.CreateExtentAttr([Gf.Vec3f(-size / 2), Gf.Vec3f(size / 2)])
    cube.CreateDisplayColorAttr([Gf.Vec3f(color)])
    flat = Gf.Vec3f(1.0)
    flat["XYZ".index(axis)] = 0.01
    place(cube, position, _UNTURNED, flat)
    UsdPhysics.CollisionAPI.Apply(cube.GetPrim())


def create_mesh(
    stage: Usd.Stage,
    path: AnyPath,
    points: Sequence[Gf.Vec3f],
    normals: Sequence[Gf.Vec3f],
    indices: Sequence[int],
    vertexCounts: Sequence[int],
) -> UsdGeom.Mesh:
    """Define a mesh."""
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreateFaceVertexCountsAttr(vertexCounts)
    mesh.CreateFaceVertexIndicesAttr(indices)
    mesh.CreatePointsAttr(points)
    mesh.CreateDoubleSidedAttr(False)
    mesh.CreateNormalsAttr(normals)
    return mesh


def create_mesh_square_axis(stage: Usd.Stage, path: AnyPath, axis: str, halfSize: float) -> UsdGeom.Mesh:
    """Define a square that faces along an axis, "X", "Y" or "Z"."""
    points = [Gf.Vec3f(*corner) * halfSize for corner in _SQUARES[axis]]
    normal = Gf.Vec3f(*(float(each == axis) for each in "XYZ"))
    mesh = create_mesh(stage, path, points, [normal] * 4, [0, 1, 2, 3], [4])
    if axis == "Z":
        st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.varying)
        st.Set([Gf.Vec2f(0, 0), Gf.Vec2f(1, 0), Gf.Vec2f(1, 1), Gf.Vec2f(0, 1)])
    return mesh


def create_mesh_cube(stage: Usd.Stage, path: AnyPath, halfSize: float) -> UsdGeom.Mesh:
    """Define a cube as a mesh of six faces."""
    corners = [Gf.Vec3f(*corner[:2], side) for side in (-1, 1) for corner in _SQUARES["Z"]]
    points = [corner * halfSize for corner in corners]
    indices = [index for face in _FACES for index in face]
    return create_mesh(stage, path, points, [each.GetNormalized() for each in corners], indices, [4] * 6)
