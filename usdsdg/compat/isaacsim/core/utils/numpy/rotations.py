"""`isaacsim.core.utils.numpy.rotations`: one rotation or many (N) as float64 NumPy arrays.

Quaternions are (w, x, y, z), matrices are for column vectors, and Euler angles are about x, y and z: extrinsic ones
about the fixed axes, others about the moving ones. `device` is ignored: there is only the CPU.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from pxr import Gf

from usdsdg.compat.isaacsim.core.utils.rotations import gf_quat_to_np_array

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

_ORDERS = {True: "xyz", False: "XYZ"}  # of SciPy, whose quaternions have the signs that scripts may compare


def gf_quat_to_tensor(orientation: Gf.Quatd | Gf.Quatf | Gf.Quaternion, device: object = None) -> np.ndarray:
    """Return a quaternion of pxr as (4,)."""
    return gf_quat_to_np_array(orientation)


def euler_angles_to_quats(
    euler_angles: ArrayLike, degrees: bool = False, extrinsic: bool = True, device: object = None
) -> np.ndarray:
    """Return quaternions (N, 4) or (4,) of Euler angles (N, 3) or (3,)."""
    return _quats(_rotations().from_euler(_ORDERS[extrinsic], np.asarray(euler_angles), degrees=degrees))


def quats_to_euler_angles(
    quaternions: ArrayLike, degrees: bool = False, extrinsic: bool = True, device: object = None
) -> np.ndarray:
    """Return Euler angles (N, 3) or (3,) of quaternions (N, 4) or (4,)."""
    return _of_quats(quaternions).as_euler(_ORDERS[extrinsic], degrees=degrees)


def rot_matrices_to_quats(rotation_matrices: ArrayLike, device: object = None) -> np.ndarray:
    """Return quaternions (N, 4) or (4,) of matrices (N, 3, 3) or (3, 3)."""
    return _quats(_rotations().from_matrix(np.asarray(rotation_matrices)))


def quats_to_rot_matrices(quaternions: ArrayLike, device: object = None) -> np.ndarray:
    """Return matrices (N, 3, 3) or (3, 3) of quaternions (N, 4) or (4,)."""
    return _of_quats(quaternions).as_matrix()


def rotvecs_to_quats(rotation_vectors: ArrayLike, degrees: bool = False, device: object = None) -> np.ndarray:
    """Return quaternions (N, 4) or (4,) of rotation vectors (N, 3) or (3,): axes as long as their angles."""
    return _quats(_rotations().from_rotvec(np.asarray(rotation_vectors), degrees=degrees))


def quats_to_rotvecs(quaternions: ArrayLike, device: object = None) -> np.ndarray:
    """Return rotation vectors (N, 3) or (3,) [rad] of quaternions (N, 4) or (4,)."""
    return _of_quats(quaternions).as_rotvec()


def rad2deg(radian_value: ArrayLike, device: object = None) -> np.ndarray:
    return np.rad2deg(radian_value)


def deg2rad(degree_value: ArrayLike, device: object = None) -> np.ndarray:
    return np.deg2rad(degree_value)


def xyzw2wxyz(q: ArrayLike, ret_torch: bool = False) -> np.ndarray:
    return np.roll(q, 1, -1)


def wxyz2xyzw(q: ArrayLike, ret_torch: bool = False) -> np.ndarray:
    return np.roll(q, -1, -1)


def _rotations() -> type[Rotation]:
    from scipy.spatial.transform import Rotation

    return Rotation


def _quats(rotations: Rotation) -> np.ndarray:
    return xyzw2wxyz(rotations.as_quat())


def _of_quats(quaternions: ArrayLike) -> Rotation:
    return _rotations().from_quat(wxyz2xyzw(quaternions))
