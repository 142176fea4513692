"""`isaacsim.core.experimental.utils.transform`: rotations as Warp arrays.

Quaternions are (w, x, y, z), matrices are for column vectors. Results have the scalar type of floats that are given,
float32 for integers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from pxr import Gf

from usdsdg.compat.wrappers import rotations
from usdsdg.compat.wrappers.arrays import as_numpy, as_warp, known_device
from usdsdg.stage.poses.look_at import look_at_rotations

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Values

# Cosine of the angle between view and up below which another direction is up.
_STEEP = 0.99


def rotation_matrix_to_quaternion(
    rotation_matrix: Values, *, dtype: type | None = None, device: str | None = None
) -> wp.array:
    """Return quaternions (..., 4), w >= 0, of matrices (..., 3, 3)."""
    matrix = _given(rotation_matrix, (3, 3), dtype)
    return _warp(rotations.quat_of_matrix(matrix), matrix.dtype, device)


def euler_angles_to_rotation_matrix(
    euler_angles: Values,
    *,
    degrees: bool = False,
    extrinsic: bool = True,
    dtype: type | None = None,
    device: str | None = None,
) -> wp.array:
    """Return matrices (..., 3, 3) of angles (..., 3) about x, y, z: Rz Ry Rx, or Rx Ry Rz if not `extrinsic`."""
    angles = _given(euler_angles, (3,), dtype)
    matrix = rotations.matrix_of_euler(angles, degrees=degrees, extrinsic=extrinsic)
    return _warp(matrix, angles.dtype, device)


def euler_angles_to_quaternion(
    euler_angles: Values,
    *,
    degrees: bool = False,
    extrinsic: bool = True,
    dtype: type | None = None,
    device: str | None = None,
) -> wp.array:
    """Return quaternions (..., 4), w >= 0, of angles (..., 3); see `euler_angles_to_rotation_matrix`."""
    angles = _given(euler_angles, (3,), dtype)
    matrix = rotations.matrix_of_euler(angles, degrees=degrees, extrinsic=extrinsic)
    return _warp(rotations.quat_of_matrix(matrix), angles.dtype, device)


def quaternion_multiplication(
    first_quaternion: Values, second_quaternion: Values, *, dtype: type | None = None, device: str | None = None
) -> wp.array:
    """Return the products (..., 4).

    Raises:
        ValueError: the shapes differ.
    """
    first, second = _given(first_quaternion, (4,), dtype), _given(second_quaternion, (4,), dtype)
    if first.shape != second.shape:
        raise ValueError(f"quaternions have different shapes, {first.shape} and {second.shape}")
    return _warp(rotations.multiplied(first, second), first.dtype, device)


def quaternion_conjugate(quaternion: Values, *, dtype: type | None = None, device: str | None = None) -> wp.array:
    """Return the quaternions (..., 4) of the inverse rotations."""
    quat = _given(quaternion, (4,), dtype)
    return _warp(quat * (1.0, -1.0, -1.0, -1.0), quat.dtype, device)


def quaternion_to_rotation_matrix(
    quaternion: Values, *, dtype: type | None = None, device: str | None = None
) -> wp.array:
    """Return matrices (..., 3, 3) of quaternions (..., 4)."""
    quat = _given(quaternion, (4,), dtype)
    return _warp(rotations.matrix_of_quat(quat), quat.dtype, device)


def quaternion_to_euler_angles(
    quaternion: Values,
    *,
    degrees: bool = False,
    extrinsic: bool = True,
    dtype: type | None = None,
    device: str | None = None,
) -> wp.array:
    """Return angles (..., 3) about x, y, z of quaternions (..., 4); where y is ±90° x is 0."""
    quat = _given(quaternion, (4,), dtype)
    matrix = rotations.matrix_of_quat(quat)
    return _warp(rotations.euler_of_matrix(matrix, degrees=degrees, extrinsic=extrinsic), quat.dtype, device)


def look_at_quaternion(
    eye: Values,
    target: Values,
    up: Values | None = None,
    *,
    dtype: type | None = None,
    device: str | None = None,
) -> wp.array:
    """Return quaternions (..., 4) that point -Z from `eye` to `target`, (..., 3), with +Y upwards.

    For a view within 8° of `up`, +Y of the world is up.

    Raises:
        DegenerateFrame: eye and target coincide.
    """
    eyes, targets = _given(eye, (3,), dtype), _given(target, (3,), dtype)
    view = np.atleast_2d(targets - eyes).astype(np.float64)
    upwards = np.broadcast_to(np.array([0.0, 0.0, 1.0]) if up is None else as_numpy(up), view.shape)
    steep = np.abs(np.sum(view * upwards, -1, keepdims=True)) > _STEEP * np.linalg.norm(view, axis=-1, keepdims=True)
    turned = look_at_rotations(np.atleast_2d(eyes), np.atleast_2d(targets), np.where(steep, (0.0, 1.0, 0.0), upwards))
    quat = rotations.quat_of_matrix(turned.swapaxes(-1, -2))
    return _warp(quat.reshape(*eyes.shape[:-1], 4), eyes.dtype, device)


def look_at_matrix(
    eye: ArrayLike, target: ArrayLike, up: ArrayLike | None = None, *, epsilon: float = 1e-5
) -> Gf.Matrix4d:
    """Return the matrix to the world of a camera at `eye` that looks along -Z at `target`, with +Y upwards.

    Where the view is along `up`, +Y of the world is up, or +X.
    """
    places = [np.asarray(each, np.float64).ravel() for each in (eye, target, (0, 0, 1) if up is None else up)]
    view = places[1] - places[0]
    upwards = next(
        (each for each in (places[2], (0.0, 1.0, 0.0)) if np.linalg.norm(np.cross(view, each)) >= epsilon),
        (1.0, 0.0, 0.0),
    )
    vectors = [Gf.Vec3d(*(float(part) for part in each)) for each in (*places[:2], upwards)]
    return Gf.Matrix4d(1).SetLookAt(*vectors).GetInverse()


def compute_relative_transform(source_to_world: ArrayLike, target_to_world: ArrayLike) -> np.ndarray:
    """Return the matrix (4, 4) for column vectors from the source's to the target's space.

    The matrices that are given are USD's, for row vectors.
    """
    source, target = (np.asarray(as_numpy(each), np.float64) for each in (source_to_world, target_to_world))  # pyright: ignore[reportArgumentType]
    return (source @ np.linalg.inv(target)).T


def _given(values: Values, shape: tuple[int, ...], dtype: type | None) -> np.ndarray:
    """Return floats whose last dimensions are `shape`.

    Raises:
        ValueError: they are not.
    """
    array = as_numpy(values)
    if array.shape[-len(shape) :] != shape:
        raise ValueError(f"an array of shape {array.shape} does not end in {shape}")
    if dtype is not None:
        import warp as wp

        return array.astype(wp.dtype_to_numpy(dtype))
    return array if array.dtype in (np.float32, np.float64) else array.astype(np.float32)


def _warp(array: np.ndarray, dtype: np.dtype, device: str | None) -> wp.array:
    return as_warp(array.astype(dtype), "cpu" if device is None else known_device(str(device)))
