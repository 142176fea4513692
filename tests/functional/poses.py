"""Transforms and xform ops of prims, read by UsdGeom."""

import numpy as np
from pxr import UsdGeom


def local(prim):
    """Return the matrix (4, 4) from the prim's space to its parent's."""
    return np.array(UsdGeom.Xformable(prim).GetLocalTransformation())


def world(prim):
    """Return the local-to-world matrix (4, 4) of a prim."""
    return np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim))


def ops(prim):
    """Return the names of the prim's xform ops, in order."""
    return list(prim.GetAttribute("xformOpOrder").Get() or ())


def value(prim, name):
    """Return an attribute's value as an array."""
    return np.array(prim.GetAttribute(name).Get())
