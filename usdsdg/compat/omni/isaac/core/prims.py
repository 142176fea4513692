"""`omni.isaac.core.prims`: wrappers of prims under their older names: those of several prims end in "View"."""

from usdsdg.compat.isaacsim.core.prims import GeometryPrim as GeometryPrimView
from usdsdg.compat.isaacsim.core.prims import RigidPrim as RigidPrimView
from usdsdg.compat.isaacsim.core.prims import SingleGeometryPrim as GeometryPrim
from usdsdg.compat.isaacsim.core.prims import SingleRigidPrim as RigidPrim
from usdsdg.compat.isaacsim.core.prims import SingleXFormPrim as XFormPrim
from usdsdg.compat.isaacsim.core.prims import XFormPrim as XFormPrimView
from usdsdg.compat.isaacsim.core.prims.contact_view import RigidContactView

__all__ = [
    "GeometryPrim", "GeometryPrimView", "RigidContactView", "RigidPrim", "RigidPrimView", "XFormPrim", "XFormPrimView",
]  # fmt: skip
