"""Where prims are, as UsdGeom says."""

import numpy as np
from pxr import UsdGeom


def local(prim):
    """(4, 4) matrix from the prim's space to its parent's."""
    return np.array(UsdGeom.Xformable(prim).GetLocalTransformation())


def world(prim):
    """(4, 4) matrix from the prim's space to the world."""
    return np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim))


def ops(prim):
    """Names of the prim's ops, in order."""
    return list(prim.GetAttribute("xformOpOrder").Get() or ())


def value(prim, name):
    """An attribute's value as numbers."""
    return np.array(prim.GetAttribute(name).Get())
