"""The parts that GeomSubsets make of the faces of a mesh."""

import numpy as np
from pxr import Sdf, Usd, UsdGeom


def read_face_parts(mesh: Usd.Prim, time: Usd.TimeCode) -> tuple[tuple[Sdf.Path, ...], np.ndarray]:
    """Return the subsets of faces of a mesh, and for each face the index of its subset, (F,) int32, -1 for none.

    A face of several subsets is of the last of them, and subsets that are left without a face are left out. Meshes
    without subsets have none, as have other prims.
    """
    geometry = UsdGeom.Mesh(mesh)
    # Those of a mesh in a prototype may be in a class or an over, where UsdGeom finds none.
    below = mesh.GetFilteredChildren(Usd.TraverseInstanceProxies(Usd.PrimIsActive)) if geometry else []
    every = [UsdGeom.Subset(child) for child in below if child.IsA(UsdGeom.Subset)]
    subsets = [subset for subset in every if subset.GetElementTypeAttr().Get(time) == UsdGeom.Tokens.face]
    counts = geometry.GetFaceVertexCountsAttr().Get(time) if subsets else None
    if not counts:
        return (), np.zeros(0, np.int32)
    of_face = np.full(len(counts), -1, np.int32)
    for index, subset in enumerate(subsets):
        chosen = np.asarray(subset.GetIndicesAttr().Get(time) or (), np.int64)
        of_face[chosen[(chosen >= 0) & (chosen < len(of_face))]] = index
    kept, of_face[of_face >= 0] = np.unique(of_face[of_face >= 0], return_inverse=True)
    return tuple(subsets[index].GetPath() for index in kept.tolist()), of_face
