"""The surface of a UsdGeomTetMesh."""

import numpy as np
from pxr import Usd, UsdGeom, Vt


def surface_faces(prim: Usd.Prim, time: Usd.TimeCode) -> np.ndarray:
    """Return the triangles (T, 3) of a TetMesh into its points, as its orientation winds them.

    They are surfaceFaceVertexIndices, else those that are faces of one tetrahedron only. None where both are of
    another type, as a layer may have them.
    """
    mesh = UsdGeom.TetMesh(prim)
    if time.IsDefault() and mesh.GetTetVertexIndicesAttr().Get() is None:
        time = Usd.TimeCode.EarliestTime()
    faces = mesh.GetSurfaceFaceVertexIndicesAttr().Get(time)
    if not isinstance(faces, Vt.Vec3iArray) or not len(faces):
        if not isinstance(mesh.GetTetVertexIndicesAttr().Get(time), Vt.Vec4iArray):
            return np.zeros((0, 3), np.int32)
        faces = UsdGeom.TetMesh.ComputeSurfaceFaces(mesh, time)
    return np.asarray(faces, np.int32).reshape(-1, 3)
