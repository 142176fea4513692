"""Rotations toward a point, and the xform op of a prim that holds its rotation."""

from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.arguments.values import vector
from usdsdg.errors import ArgumentError
from usdsdg.stage.attributes import set_value
from usdsdg.stage.poses.rotations import ROTATION_ORDERS, euler_from_matrix, quat_from_matrix
from usdsdg.stage.poses.transforms import as_array
from usdsdg.stage.poses.xform_ops import gf_quat

# Below this length a vector has no direction [stage units].
_SHORTEST = 1e-6


def look_at(
    target: Any,
    look_at_up_axis: Any = (0, 1, 0),
    eye: Any = (0, 0, 0),
    stage_up_axis: str = "Y",
    use_usdrt: bool = False,
) -> Gf.Rotation:
    """Return the rotation with which -Z points from `eye` at `target`, with +Y as far up as possible.

    Args:
        target: (x, y, z) [stage units], as is `eye`.
        look_at_up_axis: direction of up.
        stage_up_axis: "Y" or "Z": what a view straight up or down has at the sides, X or -Y.
        use_usdrt: has no effect.

    Raises:
        ArgumentError: (a ValueError) `look_at_up_axis` has no length, or the target is the eye.
    """
    up, backward = np.array(vector("look_at_up_axis", look_at_up_axis)), np.subtract(eye, target).astype(np.float64)
    if np.linalg.norm(up) < _SHORTEST:
        raise ArgumentError("utils.look_at: look_at_up_axis has no length; give a direction, such as (0, 0, 1)")
    if np.linalg.norm(backward) < _SHORTEST:
        raise ArgumentError(f"utils.look_at: the target {tuple(target)} is the eye; give another point")
    right = np.cross(up, backward)
    if not right.any():
        right = np.cross(up, (0, 0, 1) if stage_up_axis == "Y" else (1, 0, 0))
    if not right.any():
        right = np.cross(up, (0, 1, 0))
    x, z = right / np.linalg.norm(right), backward / np.linalg.norm(backward)
    return Gf.Rotation(gf_quat(quat_from_matrix(np.array([x, np.cross(z, x), z]))))


def select_rotation_op(prim: Usd.Prim) -> str:
    """Return the name of the op that holds a prim's rotation, and remove further rotation ops from its order.

    It is xformOp:transform if there is one, else the first rotate or orient op; where there is none xformOp:rotateXYZ
    is added, before the scale.
    """
    attribute = UsdGeom.Xformable(prim).CreateXformOpOrderAttr()
    order: list[str] = list(attribute.Get() or ())
    if "xformOp:transform" in order:
        return "xformOp:transform"
    rotations = [name for name in order if name == "xformOp:orient" or name.startswith("xformOp:rotate")]
    chosen = rotations[0] if rotations else "xformOp:rotateXYZ"
    kept = [name for name in order if name not in rotations[1:]]
    if not rotations:
        if not prim.HasAttribute(chosen):
            prim.CreateAttribute(chosen, Sdf.ValueTypeNames.Float3, custom=False)
        kept.insert(kept.index("xformOp:scale") if "xformOp:scale" in kept else len(kept), chosen)
    if kept != order:
        attribute.Set(kept)
    return chosen


def set_rotation_by_op(prim: Usd.Prim, rotation_op: str, rotation_value: Gf.Rotation) -> None:
    """Set a rotation in the op that `select_rotation_op` names: rotate of three axes, orient, or transform.

    Of a transform translation and scale stay.

    Raises:
        ArgumentError: it is another op.
        BadValue: an orient op is no quaternion.
    """
    attribute, kind = prim.GetAttribute(rotation_op), rotation_op.removeprefix("xformOp:")
    if kind == "transform":
        whole = Gf.Transform(Gf.Matrix4d(attribute.Get() or 1.0))
        whole.SetRotation(rotation_value)
        attribute.Set(whole.GetMatrix())
    elif kind == "orient":
        quat = rotation_value.GetQuat()
        set_value(attribute, (quat.GetReal(), *quat.GetImaginary()))
    elif (order := kind.removeprefix("rotate")) in ROTATION_ORDERS:
        set_value(attribute, euler_from_matrix(as_array(Gf.Matrix4d(rotation_value, Gf.Vec3d(0))), order).tolist())
    else:
        raise ArgumentError(f"utils.set_rotation_by_op: {rotation_op!r} of {prim.GetPath()} holds no whole rotation")
