"""`usdrt.Gf`: the same names as `pxr.Gf`."""

from pxr.Gf import *  # noqa: F403
