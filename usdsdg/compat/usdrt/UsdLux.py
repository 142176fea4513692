"""`usdrt.UsdLux`: the same names as `pxr.UsdLux`."""

from pxr.UsdLux import *  # noqa: F403
