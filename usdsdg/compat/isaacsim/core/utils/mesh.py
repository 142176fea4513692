"""`isaacsim.core.utils.mesh`: points of a mesh."""

from __future__ import annotations

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.compat.isaacsim.core.utils.transformations import get_relative_transform


def get_mesh_vertices_relative_to(mesh_prim: UsdGeom.Mesh, coord_prim: Usd.Prim) -> np.ndarray:
    """Return the points (P, 3) of a mesh in another prim's space."""
    points = np.array(UsdGeom.Mesh(mesh_prim).GetPointsAttr().Get(), np.float64)
    matrix = get_relative_transform(UsdGeom.Mesh(mesh_prim).GetPrim(), coord_prim)
    return points @ matrix[:3, :3].T + matrix[:3, 3]
