"""`usdrt`: the USD stage in the names of Fabric's API; there is no copy of its values."""

from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdPhysics, UsdShade, Vt

from usdsdg.compat.usdrt import Rt, Usd

__all__ = ["Gf", "Rt", "Sdf", "Usd", "UsdGeom", "UsdLux", "UsdPhysics", "UsdShade", "Vt"]
