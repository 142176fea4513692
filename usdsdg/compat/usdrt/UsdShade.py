"""`usdrt.UsdShade`: the same names as `pxr.UsdShade`."""

from pxr.UsdShade import *  # noqa: F403
