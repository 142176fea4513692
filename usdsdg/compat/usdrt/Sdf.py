"""`usdrt.Sdf`: the same names as `pxr.Sdf`."""

from pxr.Sdf import *  # noqa: F403
