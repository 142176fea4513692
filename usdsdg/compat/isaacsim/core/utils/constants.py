"""`isaacsim.core.utils.constants`: axes by their names, in both cases."""

from pxr import UsdGeom

__all__ = ["AXES_INDICES", "AXES_TOKEN"]

AXES_INDICES = {name: index for index, both in enumerate(("Xx", "Yy", "Zz")) for name in both}
AXES_TOKEN = {name: getattr(UsdGeom.Tokens, name.lower()) for name in AXES_INDICES}
