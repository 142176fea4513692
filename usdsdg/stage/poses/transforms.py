"""Transforms of prims and stages; the numpy side is in `rotations`, writing poses in `xform_ops`."""

from __future__ import annotations

import math

import numpy as np
from pxr import Gf, Usd, UsdGeom

from usdsdg.errors import DegenerateFrame, warn_once
from usdsdg.stage.poses.rotations import (
    Pose,
    compose,
    compose_euler,
    decompose,
    euler_from_matrix,
    euler_xyz_from_quat,
    matrix_from_euler,
    matrix_from_quat,
    quat_from_matrix,
)
from usdsdg.stage.poses.xform_ops import Vector, author_pose, gf_quat

__all__ = [
    "Pose",
    "as_array",
    "author_pose",
    "compose",
    "compose_euler",
    "decompose",
    "euler_from_matrix",
    "euler_xyz_from_quat",
    "gf_quat",
    "local_to_world",
    "look_at",
    "matrix_from_euler",
    "matrix_from_quat",
    "meters_per_unit",
    "quat_from_matrix",
    "up_axis",
    "world_to_local",
]


def local_to_world(prim: Usd.Prim, time: Usd.TimeCode = Usd.TimeCode.Default()) -> Gf.Matrix4d:  # noqa: B008
    """Matrix from the prim's own space to the world [stage units]; identity where nothing has a transform."""
    return UsdGeom.XformCache(time).GetLocalToWorldTransform(prim)


def world_to_local(prim: Usd.Prim, time: Usd.TimeCode = Usd.TimeCode.Default()) -> Gf.Matrix4d:  # noqa: B008
    """Inverse of `local_to_world`.

    Raises:
        DegenerateFrame: the prim or an ancestor is scaled to zero.
    """
    matrix = local_to_world(prim, time)
    if abs(matrix.GetDeterminant()) < 1e-30:
        raise DegenerateFrame(f"{prim.GetPath()} has no inverse transform: it or an ancestor has a scale of zero")
    return matrix.GetInverse()


def as_array(matrix: Gf.Matrix4d) -> np.ndarray:
    """(4, 4) float64 copy, row vectors as in USD."""
    return np.array(matrix, np.float64)


def meters_per_unit(stage: Usd.Stage) -> float:
    """Length of one stage unit [m]; 1 (with a warning) where the stage says what is no length."""
    value = float(UsdGeom.GetStageMetersPerUnit(stage))
    if math.isfinite(value) and value > 0.0:
        return value
    warn_once(f"{stage.GetRootLayer().identifier}: metersPerUnit {value} is no length; 1 is used. Author a value > 0.")
    return 1.0


def up_axis(stage: Usd.Stage) -> str:
    """'Y' or 'Z'."""
    return str(UsdGeom.GetStageUpAxis(stage))


def look_at(eye: Vector, target: Vector, *, up: Vector = (0.0, 0.0, 1.0)) -> Gf.Matrix4d:
    """Camera-to-world matrix [stage units] of a USD camera (looks along -Z, +Y up) at `eye`.

    Raises:
        DegenerateFrame: eye and target coincide, or the view direction is parallel to `up`.
    """
    eye, target, up = (np.asarray(tuple(vector), np.float64) for vector in (eye, target, up))
    back = eye - target
    distance, height = np.linalg.norm(back), np.linalg.norm(up)
    if not distance > 1e-12 * max(1.0, float(np.abs(eye).max())):
        raise DegenerateFrame(f"a camera at {tuple(eye)} cannot look at its own position; move the eye or the target")
    right = np.cross(up, back) / (height * distance) if height > 0 else np.zeros(3)
    if not np.linalg.norm(right) > 1e-9:
        raise DegenerateFrame(
            f"a camera at {tuple(eye)} looking at {tuple(target)} looks along its up direction {tuple(up)}; "
            "choose another up or move the eye sideways"
        )
    back /= distance
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :3] = right, np.cross(back, right), back
    matrix[3, :3] = eye
    return Gf.Matrix4d(matrix.tolist())
