"""A ground plane: a square that is seen and an unbounded plane that collides."""

from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

SEEN, COLLIDES = "geom", "collisionPlane"
# Corners of the square, counterclockwise around the axis, in units of its half size.
_CORNERS = {
    "X": ((0, -1, -1), (0, 1, -1), (0, 1, 1), (0, -1, 1)),
    "Y": ((-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)),
    "Z": ((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)),
}


def add_ground_plane(
    stage: Usd.Stage,
    path: str | Sdf.Path,
    *,
    axis: str = "Z",
    half_size: float = 25.0,
    position: tuple[float, float, float] = (0.0, 0.0, 0.0),
    color: tuple[float, float, float] = (0.5, 0.5, 0.5),
) -> Usd.Prim:
    """Define an Xform with a mesh `geom` of 2 `half_size` [stage units] and a static collider `collisionPlane`.

    Both face along `axis`, "X", "Y" or "Z". The collider has no bounds and is not rendered.
    """
    xform = UsdGeom.Xform.Define(stage, path)
    xform.AddTranslateOp().Set(Gf.Vec3d(*position))
    xform.AddOrientOp().Set(Gf.Quatf(1.0))
    xform.AddScaleOp().Set(Gf.Vec3f(1.0))
    mesh = UsdGeom.Mesh.Define(stage, xform.GetPath().AppendChild(SEEN))
    points = [Gf.Vec3f(*corner) * half_size for corner in _CORNERS[axis]]
    mesh.CreatePointsAttr(points)
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateNormalsAttr([Gf.Vec3f(*(float(each == axis) for each in "XYZ"))] * 4)
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(points))
    mesh.CreateDisplayColorAttr([Gf.Vec3f(*color)])
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.varying)
    st.Set([Gf.Vec2f(0, 0), Gf.Vec2f(1, 0), Gf.Vec2f(1, 1), Gf.Vec2f(0, 1)])
    plane = UsdGeom.Plane.Define(stage, xform.GetPath().AppendChild(COLLIDES))
    plane.CreatePurposeAttr(UsdGeom.Tokens.guide)
    plane.CreateAxisAttr(axis)
    UsdPhysics.CollisionAPI.Apply(plane.GetPrim())
    return xform.GetPrim()
