"""`usdrt.Vt`: the same names as `pxr.Vt`."""

from pxr.Vt import *  # noqa: F403
