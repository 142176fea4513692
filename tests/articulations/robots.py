"""Robots for tests, authored with pxr alone."""

from __future__ import annotations

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics


def link(stage: Usd.Stage, path: str, at=(0.0, 0.0, 0.0), size: float = 0.1) -> Usd.Prim:
    """A rigid body without children's scale: an Xform with a cube below it."""
    prim = stage.DefinePrim(path, "Xform")
    UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(*at))
    UsdGeom.Xformable(prim).AddOrientOp().Set(Gf.Quatf(1))
    UsdPhysics.RigidBodyAPI.Apply(prim)
    cube = UsdGeom.Cube.Define(stage, f"{path}/geometry")
    cube.CreateSizeAttr(size)
    UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
    return prim


def joint(stage, path, kind, body0, body1, *, pos0=(0, 0, 0), pos1=(0, 0, 0), axis="Z", lower=None, upper=None):
    """A joint of a type such as UsdPhysics.RevoluteJoint."""
    made = kind.Define(stage, path)
    if body0:
        made.CreateBody0Rel().SetTargets([Sdf.Path(body0)])
    if body1:
        made.CreateBody1Rel().SetTargets([Sdf.Path(body1)])
    made.CreateLocalPos0Attr(Gf.Vec3f(*pos0))
    made.CreateLocalPos1Attr(Gf.Vec3f(*pos1))
    if kind is not UsdPhysics.FixedJoint:
        made.CreateAxisAttr(axis)
        if lower is not None:
            made.CreateLowerLimitAttr(lower)
            made.CreateUpperLimitAttr(upper)
    return made


def planar_arm(stage: Usd.Stage, root: str = "/World/Arm") -> Usd.Prim:
    """Revolute joints about Z at x = 0 and x = 1, and a slider at x = 2; the links' frames are at their joints."""
    prim = stage.DefinePrim(root, "Xform")
    UsdGeom.Xformable(prim).AddTranslateOp()
    UsdPhysics.ArticulationRootAPI.Apply(prim)
    for name, x in (("base", 0.0), ("upper", 0.0), ("lower", 1.0), ("hand", 2.0)):
        link(stage, f"{root}/{name}", (x, 0, 0))
    joint(stage, f"{root}/fixed", UsdPhysics.FixedJoint, "", f"{root}/base")
    joint(stage, f"{root}/shoulder", UsdPhysics.RevoluteJoint, f"{root}/base", f"{root}/upper", lower=-170, upper=170)
    joint(
        stage, f"{root}/elbow", UsdPhysics.RevoluteJoint, f"{root}/upper", f"{root}/lower",
        pos0=(1, 0, 0), lower=-90, upper=90,
    )  # fmt: skip
    joint(
        stage, f"{root}/slider", UsdPhysics.PrismaticJoint, f"{root}/lower", f"{root}/hand",
        pos0=(1, 0, 0), axis="X", lower=0, upper=0.5,
    )  # fmt: skip
    return prim


def at(prim: Usd.Prim) -> np.ndarray:
    return np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim).ExtractTranslation())
