"""`createJoint`: joints between prims where they are."""

from __future__ import annotations

from collections.abc import Iterable

from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

# Joints with these forces break at none.
MAX_FLOAT = 3.40282347e38
_LOCKED = ("transX", "transY", "transZ", "rotX", "rotY", "rotZ")
_NAMES = {"Gear": "PhysxPhysicsGearJoint", "RackAndPinion": "PhysxPhysicsRackAndPinionJoint"}
_WITH_AXIS = ("Revolute", "Prismatic", "Spherical")


def createJoint(stage: Usd.Stage, joint_type: str, from_prim: Usd.Prim | None, to_prim: Usd.Prim | None) -> Usd.Prim:
    """Define a joint below `to_prim` whose frames are both at its origin; return it.

    Args:
        joint_type: "Fixed", "Revolute", "Prismatic", "Spherical", "Distance", "Gear" or "RackAndPinion"; any other
            gives a general joint with all axes locked. Axes are X.
        from_prim: Body 0; None: the world.
        to_prim: Body 1; None: body 1 is `from_prim`, and body 0 the world.
    """
    if to_prim is None:
        from_prim, to_prim = None, from_prim
    first = from_prim if from_prim is not None and from_prim.IsValid() else None
    second = to_prim if to_prim is not None and to_prim.IsValid() else None
    joint = _define(stage, joint_type, second)
    cache = UsdGeom.XformCache()
    placed = cache.GetLocalToWorldTransform(second) if second else Gf.Matrix4d(1.0)
    if first and second:
        placed = placed * cache.GetLocalToWorldTransform(first).GetInverse()
        joint.CreateBody0Rel().SetTargets([first.GetPath()])
    if second:
        joint.CreateBody1Rel().SetTargets([second.GetPath()])
    placed = placed.RemoveScaleShear()
    joint.CreateLocalPos0Attr(Gf.Vec3f(placed.ExtractTranslation()))
    joint.CreateLocalRot0Attr(Gf.Quatf(placed.ExtractRotationQuat()))
    joint.CreateLocalPos1Attr(Gf.Vec3f(0.0))
    joint.CreateLocalRot1Attr(Gf.Quatf(1.0))
    joint.CreateBreakForceAttr(MAX_FLOAT)
    joint.CreateBreakTorqueAttr(MAX_FLOAT)
    return joint.GetPrim()


def createJoints(
    stage: Usd.Stage, joint_type: str, paths: Iterable[str | Sdf.Path], join_to_parent: bool = False
) -> list[Usd.Prim]:
    """Define a joint between each prim and its parent, or the world; return them."""
    joints = []
    for path in paths:
        prim = stage.GetPrimAtPath(str(path))
        parent = prim.GetParent() if join_to_parent and prim else None
        joints.append(createJoint(stage, joint_type, None if not parent or parent.IsPseudoRoot() else parent, prim))
    return joints


def create_unused_path(stage: Usd.Stage, base_path: str, path: str) -> str:
    """Return a name below `base_path` that no prim has: `path`, or with the first free number."""
    name, number = path, 0
    while stage.GetPrimAtPath(f"{base_path}/{name}"):
        name, number = f"{path}{number}", number + 1
    return name


def _define(stage: Usd.Stage, kind: str, below: Usd.Prim | None) -> UsdPhysics.Joint:
    """Define a joint below a prim, or the first above it that can be edited."""
    while below and (below.IsInPrototype() or below.IsInstanceProxy() or below.IsInstanceable()):
        below = below.GetParent()
    base = "" if not below or below.IsPseudoRoot() else str(below.GetPath())
    path = f"{base}/{create_unused_path(stage, base, f'{kind}Joint')}"
    known = hasattr(UsdPhysics, f"{kind}Joint")
    prim = stage.DefinePrim(path, _NAMES.get(kind, f"Physics{kind}Joint" if known else "PhysicsJoint"))
    if kind in _WITH_AXIS:
        prim.GetAttribute("physics:axis").Set("X")
    elif kind == "Distance":
        distance = UsdPhysics.DistanceJoint(prim)
        distance.CreateMinDistanceAttr(0.0)
        distance.CreateMaxDistanceAttr(0.0)
    elif not known and kind not in _NAMES:
        for name in _LOCKED:
            limit = UsdPhysics.LimitAPI.Apply(prim, name)
            limit.CreateLowAttr(1.0)
            limit.CreateHighAttr(-1.0)
    return UsdPhysics.Joint(prim)
