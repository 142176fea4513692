"""`usdrt.UsdPhysics`: the same names as `pxr.UsdPhysics`."""

from pxr.UsdPhysics import *  # noqa: F403
