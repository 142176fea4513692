"""Bodies and joints for the tests of mechanisms, authored with pxr alone."""

from __future__ import annotations

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from tests.physics.scenes import add


def runge_kutta(change, turn: np.ndarray, omega: np.ndarray, seconds: float, steps: int):
    """Yield rotation (3, 3) and angular velocity after each step; `change` gives the derivatives of both."""
    h = seconds / steps
    for _ in range(steps):
        a = change(turn, omega)
        b = change(turn + h / 2 * a[0], omega + h / 2 * a[1])
        c = change(turn + h / 2 * b[0], omega + h / 2 * b[1])
        d = change(turn + h * c[0], omega + h * c[1])
        turn = turn + h / 6 * (a[0] + 2 * b[0] + 2 * c[0] + d[0])
        omega = omega + h / 6 * (a[1] + 2 * b[1] + 2 * c[1] + d[1])
        yield turn, omega


def cross_matrix(omega: np.ndarray) -> np.ndarray:
    """The matrix (3, 3) that multiplies a column vector as the cross product with `omega` does."""
    x, y, z = omega
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def rod(stage: Usd.Stage, path: str, start, end, *, width: float = 0.04, mass: float = 1.0) -> Usd.Prim:
    """A box from one point to another, along its own z axis, without angular damping."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    length = float(np.linalg.norm(end - start))
    prim = add(stage, path, scale=(width / 2, width / 2, length / 2))
    translate, scale = UsdGeom.Xformable(prim).GetOrderedXformOps()
    translate.Set(Gf.Vec3d(*((start + end) / 2).tolist()))
    orient = UsdGeom.Xformable(prim).AddOrientOp()
    rotation = Gf.Rotation(Gf.Vec3d(0, 0, 1), Gf.Vec3d(*((end - start) / length).tolist()))
    orient.Set(Gf.Quatf(rotation.GetQuat()))
    UsdGeom.Xformable(prim).SetXformOpOrder([translate, orient, scale])
    UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(mass)
    return prim


def joint(stage: Usd.Stage, path: str, kind: type, body0: str, body1: str, at, *, axis: str = "X", rotate=None):
    """A joint whose frames both are at a world point, with the world's axes, or those rotated by a quaternion."""
    made = kind.Define(stage, path)
    for number, body in enumerate((body0, body1)):
        to_world = Gf.Matrix4d(1)
        if body:
            prim = stage.GetPrimAtPath(body)
            made.GetPrim().GetRelationship(f"physics:body{number}").SetTargets([Sdf.Path(body)])
            to_world = UsdGeom.XformCache().GetLocalToWorldTransform(prim)
        turn = to_world.RemoveScaleShear().ExtractRotationQuat().GetInverse() * Gf.Quatd(rotate or Gf.Quatf(1))
        made.GetPrim().GetAttribute(f"physics:localPos{number}").Set(
            Gf.Vec3f(to_world.GetInverse().Transform(Gf.Vec3d(*at)))
        )
        made.GetPrim().GetAttribute(f"physics:localRot{number}").Set(Gf.Quatf(turn))
    if kind in (UsdPhysics.RevoluteJoint, UsdPhysics.PrismaticJoint):
        made.CreateAxisAttr(axis)
    return made


def drive(
    made, name: str, *, stiffness=0.0, damping=0.0, target=0.0, target_velocity=0.0, max_force=None, kind="force"
):
    """A drive of a joint, in the units of the stage and degrees."""
    api = UsdPhysics.DriveAPI.Apply(made.GetPrim(), name)
    api.CreateTypeAttr(kind)
    api.CreateStiffnessAttr(stiffness)
    api.CreateDampingAttr(damping)
    api.CreateTargetPositionAttr(target)
    api.CreateTargetVelocityAttr(target_velocity)
    if max_force is not None:
        api.CreateMaxForceAttr(max_force)
    return api


def limit(made, lower: float, upper: float) -> None:
    """Limits of a revolute or prismatic joint, in degrees or stage units."""
    made.CreateLowerLimitAttr(lower)
    made.CreateUpperLimitAttr(upper)


def free_axes(made, *names: str, **limits: tuple[float, float]) -> None:
    """Lock all axes of a general joint but some, and limit others."""
    for name in ("transX", "transY", "transZ", "rotX", "rotY", "rotZ"):
        if name not in names:
            low, high = limits.get(name, (1.0, -1.0))
            api = UsdPhysics.LimitAPI.Apply(made.GetPrim(), name)
            api.CreateLowAttr(low)
            api.CreateHighAttr(high)


def rotation(prim: Usd.Prim) -> np.ndarray:
    """World rotation matrix (3, 3) of a prim, rows are its axes."""
    matrix = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim))[:3, :3]
    return matrix / np.linalg.norm(matrix, axis=1)[:, None]


def angle(prim: Usd.Prim, axis: int, direction: int) -> float:
    """The angle [rad] by which a prim's axis `direction` is turned around the world axis `axis`."""
    j, k = (axis + 1) % 3, (axis + 2) % 3
    row = rotation(prim)[direction]
    start = np.zeros(3)
    start[direction] = 1.0
    return float(np.arctan2(row[k], row[j]) - np.arctan2(start[k], start[j]))
