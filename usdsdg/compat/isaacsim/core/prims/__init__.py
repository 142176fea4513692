"""`isaacsim.core.prims`: wrappers of prims with NumPy arrays, or torch's or Warp's as the backend says.

Names without "Single" wrap several prims, with one row per prim.
"""

from usdsdg.compat.isaacsim.core.prims.articulation import Articulation
from usdsdg.compat.isaacsim.core.prims.geometry_prim import GeometryPrim
from usdsdg.compat.isaacsim.core.prims.rigid_prim import RigidPrim
from usdsdg.compat.isaacsim.core.prims.single_articulation import SingleArticulation
from usdsdg.compat.isaacsim.core.prims.single_geometry_prim import SingleGeometryPrim
from usdsdg.compat.isaacsim.core.prims.single_rigid_prim import SingleRigidPrim
from usdsdg.compat.isaacsim.core.prims.single_xform_prim import SingleXFormPrim
from usdsdg.compat.isaacsim.core.prims.xform_prim import XFormPrim

__all__ = [
    "Articulation", "GeometryPrim", "RigidPrim", "SingleArticulation", "SingleGeometryPrim", "SingleRigidPrim",
    "SingleXFormPrim", "XFormPrim",
]  # fmt: skip
