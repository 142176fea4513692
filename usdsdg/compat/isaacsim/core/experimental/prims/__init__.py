"""`isaacsim.core.experimental.prims`: wrappers of one or more prims, with Warp arrays of one row per prim."""

from usdsdg.compat.isaacsim.core.experimental.prims.articulation import Articulation
from usdsdg.compat.isaacsim.core.experimental.prims.geom_prim import GeomPrim
from usdsdg.compat.isaacsim.core.experimental.prims.prim import Prim
from usdsdg.compat.isaacsim.core.experimental.prims.rigid_prim import RigidPrim
from usdsdg.compat.isaacsim.core.experimental.prims.xform_prim import XformPrim

__all__ = ["Articulation", "GeomPrim", "Prim", "RigidPrim", "XformPrim"]
