"""`isaacsim.core.utils.rotations`: rotations as float64 NumPy arrays.

Quaternions are (w, x, y, z), matrices are for column vectors.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from pxr import Gf

from usdsdg.compat.wrappers import rotations
from usdsdg.compat.wrappers.rotations import matrix_of_quat as quat_to_rot_matrix
from usdsdg.compat.wrappers.rotations import quat_of_matrix as rot_matrix_to_quat

__all__ = [
    "euler_angles_to_quat", "euler_to_rot_matrix", "gf_quat_to_np_array", "gf_rotation_to_np_array", "lookat_to_quatf",
    "matrix_to_euler_angles", "quat_to_euler_angles", "quat_to_rot_matrix", "rot_matrix_to_quat",
]  # fmt: skip


def euler_to_rot_matrix(euler_angles: ArrayLike, degrees: bool = False, extrinsic: bool = True) -> np.ndarray:
    """Return the matrix (3, 3) of angles about x, y, z: Rz Ry Rx if `extrinsic`, else Rx Ry Rz."""
    return rotations.matrix_of_euler(euler_angles, degrees=degrees, extrinsic=extrinsic)


def euler_angles_to_quat(euler_angles: ArrayLike, degrees: bool = False, extrinsic: bool = True) -> np.ndarray:
    return rot_matrix_to_quat(euler_to_rot_matrix(euler_angles, degrees=degrees, extrinsic=extrinsic))


def matrix_to_euler_angles(mat: ArrayLike, degrees: bool = False, extrinsic: bool = True) -> np.ndarray:
    """Return the angles (3,) about x, y, z of a matrix (3, 3); where y is ±90° z is 0."""
    matrix = np.asarray(mat, np.float64)[:3, :3]
    return rotations.euler_of_matrix(matrix, degrees=degrees, extrinsic=extrinsic, zero="z")


def quat_to_euler_angles(quat: ArrayLike, degrees: bool = False, extrinsic: bool = True) -> np.ndarray:
    return matrix_to_euler_angles(quat_to_rot_matrix(quat), degrees=degrees, extrinsic=extrinsic)


def lookat_to_quatf(camera: Gf.Vec3f, target: Gf.Vec3f, up: Gf.Vec3f) -> Gf.Quatf:
    """Return the rotation that turns +Z to the view from `camera` to `target`, and +Y toward `up`.

    Where the two points coincide it is the identity.
    """
    view = Gf.Vec3d(target) - Gf.Vec3d(camera)
    if view.GetLength() < 1e-10:
        return Gf.Quatf(1.0)
    forward = view.GetNormalized()
    right = Gf.Cross(Gf.Vec3d(up), forward).GetNormalized()
    axes = np.array([right, Gf.Cross(forward, right), forward]).T
    w, x, y, z = rot_matrix_to_quat(axes).tolist()
    return Gf.Quatf(w, x, y, z)


def gf_quat_to_np_array(orientation: Gf.Quatd | Gf.Quatf | Gf.Quaternion) -> np.ndarray:
    """Return a quaternion of pxr as (4,) w, x, y, z."""
    return np.array([orientation.GetReal(), *orientation.GetImaginary()], np.float64)


def gf_rotation_to_np_array(orientation: Gf.Rotation) -> np.ndarray:
    """Return a rotation of pxr as a quaternion (4,) w, x, y, z."""
    return gf_quat_to_np_array(orientation.GetQuat())
