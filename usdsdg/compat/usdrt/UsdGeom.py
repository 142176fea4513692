"""`usdrt.UsdGeom`: the same names as `pxr.UsdGeom`."""

from pxr.UsdGeom import *  # noqa: F403
