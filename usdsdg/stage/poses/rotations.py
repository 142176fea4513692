"""Conversions between matrices, quaternions and Euler angles, for batches in NumPy arrays.

Matrices are USD's: row vectors, so that p_out = p @ matrix and translation is the last row. Quaternions are
(x, y, z, w), as Warp and Newton order them; angles are degrees, as in USD's rotate ops.

scipy's Rotation differs in the last bits, on which saved datasets depend. With it, 10,000 rotations take 22 times as
long from matrices to Euler angles and 10 times as long from Euler angles to matrices. It is faster from quaternions to
matrices: 0.03 times as long for 10,000 rotations, 0.28 times for one.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# The orders of three-axis rotate ops; the first axis is applied first.
ROTATION_ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")

# Scales below this count as zero: the direction of their axis is undefined.
_TINY = 1e-12


class Pose(NamedTuple):
    """Scale first, then rotate, then translate; leading dimensions are those of the matrices."""

    translate: Array  # (..., 3) stage units
    rotation: Array  # (..., 4) unit quaternion x, y, z, w
    scale: Array  # (..., 3); all three negative where the matrix mirrors


def quat_from_matrix(matrix: ArrayLike) -> Array:
    """Return the unit quaternions (..., 4), w >= 0, of rotation matrices (..., 3, 3) or of those in (..., 4, 4)."""
    m = np.asarray(matrix, np.float64)[..., :3, :3]
    if m.ndim == 2:
        return np.array(_quat_of_one(m.tolist()))
    xx, yy, zz = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    # Four times the outer product of the quaternion with itself. Its longest row is the accurate one.
    yz, zx, xy = m[..., 1, 2] + m[..., 2, 1], m[..., 2, 0] + m[..., 0, 2], m[..., 0, 1] + m[..., 1, 0]
    xw, yw, zw = m[..., 1, 2] - m[..., 2, 1], m[..., 2, 0] - m[..., 0, 2], m[..., 0, 1] - m[..., 1, 0]
    outer = np.stack(
        [
            np.stack([1 + xx - yy - zz, xy, zx, xw], -1),
            np.stack([xy, 1 - xx + yy - zz, yz, yw], -1),
            np.stack([zx, yz, 1 - xx - yy + zz, zw], -1),
            np.stack([xw, yw, zw, 1 + xx + yy + zz], -1),
        ],
        -2,
    )
    longest = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), -1)
    quat = np.take_along_axis(outer, longest[..., None, None], -2)[..., 0, :]
    quat = np.where(quat[..., 3:] < 0, -quat, quat)
    return quat / np.linalg.norm(quat, axis=-1, keepdims=True)


def _quat_of_one(m: list[list[float]]) -> tuple[float, float, float, float]:
    """Return what `quat_from_matrix` returns of one of many matrices, bit for bit, in a tenth of the time."""
    xx, yy, zz = m[0][0], m[1][1], m[2][2]
    yz, zx, xy = m[1][2] + m[2][1], m[2][0] + m[0][2], m[0][1] + m[1][0]
    xw, yw, zw = m[1][2] - m[2][1], m[2][0] - m[0][2], m[0][1] - m[1][0]
    outer = (
        (1 + xx - yy - zz, xy, zx, xw),
        (xy, 1 - xx + yy - zz, yz, yw),
        (zx, yz, 1 - xx - yy + zz, zw),
        (xw, yw, zw, 1 + xx + yy + zz),
    )
    x, y, z, w = outer[max(range(4), key=lambda row: outer[row][row])]
    if w < 0:
        x, y, z, w = -x, -y, -z, -w
    length = math.sqrt(x * x + y * y + z * z + w * w)
    return x / length, y / length, z / length, w / length


def matrix_from_quat(quat_xyzw: ArrayLike) -> Array:
    """Return the rotation matrices (..., 3, 3) of quaternions of any length."""
    q = np.asarray(quat_xyzw, np.float64)
    if q.ndim == 1:
        return np.array(_matrix_of_one(*q.tolist()))
    x, y, z, w = np.moveaxis(q / np.linalg.norm(q, axis=-1, keepdims=True), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
        [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
        [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, -1) for row in rows], -2)


def _matrix_of_one(x: float, y: float, z: float, w: float) -> list[list[float]]:
    """Return what `matrix_from_quat` returns of one of many quaternions, bit for bit, in a tenth of the time."""
    length = math.sqrt(x * x + y * y + z * z + w * w)
    if length == 0.0:
        return [[math.nan] * 3] * 3
    x, y, z, w = x / length, y / length, z / length, w / length
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
        [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
        [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)],
    ]


def rotated(quat_xyzw: ArrayLike, vectors: ArrayLike) -> Array:
    """Return vectors (..., 3) rotated by quaternions (..., 4)."""
    return np.asarray(np.einsum("...i,...ij->...j", np.asarray(vectors), matrix_from_quat(quat_xyzw)))


def matrix_from_euler(degrees: ArrayLike, order: str = "XYZ") -> Array:
    """Return the rotation matrices (..., 3, 3) of a USD rotate op; "XYZ" rotates about x first.

    Angles (..., 3) are about x, y, z, whatever the order. By quaternions, as USD computes them: that decides what is
    left of the cosine of 90 degrees.
    """
    half = np.moveaxis(np.radians(np.asarray(degrees, np.float64)) / 2.0, -1, 0)
    real, imaginary = np.cos(half), np.sin(half)
    inverse_length = 1.0 / np.sqrt(real * real + imaginary * imaginary)
    real, imaginary = real * inverse_length, imaginary * inverse_length
    cosines, sines = 1.0 - 2.0 * (imaginary * imaginary), 2.0 * (imaginary * real)
    if order.upper() == "XYZ":
        return _xyz_product(*cosines, *sines)
    first, second, third = (_about(axis, cosines[axis], sines[axis]) for axis in map("XYZ".index, order.upper()))
    return first @ second @ third


def euler_from_matrix(matrix: ArrayLike, order: str = "XYZ") -> Array:
    """Return the angles about x, y, z [degrees] (..., 3) with which a USD rotate op of `order` gives these rotations.

    The middle angle is within ±90°; where it is ±90° (gimbal lock) the last one is 0.
    """
    m = np.asarray(matrix, np.float64)[..., :3, :3]
    i, j, k = ("XYZ".index(axis) for axis in order.upper())
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    cosine = np.hypot(m[..., i, i], m[..., i, j])
    locked = cosine < 1e-9
    angles = np.empty((*m.shape[:-2], 3))
    angles[..., i] = np.where(
        locked, np.arctan2(-sign * m[..., k, j], m[..., j, j]), np.arctan2(sign * m[..., j, k], m[..., k, k])
    )
    angles[..., j] = np.arctan2(-sign * m[..., i, k], cosine)
    angles[..., k] = np.where(locked, 0.0, np.arctan2(sign * m[..., i, j], m[..., i, i]))
    return np.degrees(angles)


def euler_xyz_from_quat(quat_xyzw: ArrayLike) -> Array:
    """Return the angles [degrees] (..., 3) of a rotateXYZ op for quaternions (..., 4)."""
    return euler_from_matrix(matrix_from_quat(quat_xyzw), "XYZ")


def compose(
    translate: ArrayLike = (0.0, 0.0, 0.0),
    rotation: ArrayLike = (0.0, 0.0, 0.0, 1.0),
    scale: ArrayLike = (1.0, 1.0, 1.0),
) -> Array:
    """Return matrices (..., 4, 4) that scale, then rotate by a quaternion, then translate; arguments broadcast."""
    axes = np.asarray(scale, np.float64)[..., :, None] * matrix_from_quat(rotation)
    offset = np.asarray(translate, np.float64)
    m = np.zeros((*np.broadcast_shapes(axes.shape[:-2], offset.shape[:-1]), 4, 4))
    m[..., :3, :3] = axes
    m[..., 3, :3] = offset
    m[..., 3, 3] = 1.0
    return m


def decompose(matrix: ArrayLike) -> Pose:
    """Return translation, rotation and scale of matrices (..., 4, 4).

    Exact for matrices without shear; otherwise the rotation is the one nearest to the directions of the axes. Axes
    scaled to zero get a direction that completes the frame.
    """
    m = np.asarray(matrix, np.float64)
    axes = m[..., :3, :3]
    scale = np.linalg.norm(axes, axis=-1)
    scale = np.where(np.linalg.det(axes)[..., None] < 0, -scale, scale)
    vanished = np.abs(scale) < _TINY
    directions = np.where(vanished[..., None], 0.0, axes / np.where(vanished, 1.0, scale)[..., None])
    left, _, right = np.linalg.svd(directions)
    # With a zero axis the completed frame may be left-handed; the flip changes only that free direction.
    left[..., :, 2] *= np.sign(np.linalg.det(left @ right))[..., None]
    return Pose(m[..., 3, :3].copy(), quat_from_matrix(left @ right), np.where(vanished, 0.0, scale))


def _about(axis: int, cosine: Array, sine: Array) -> Array:
    """Return rotations (..., 3, 3) about an axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrices = np.zeros((*cosine.shape, 3, 3))
    matrices[..., axis, axis] = 1.0
    matrices[..., i, i] = matrices[..., j, j] = cosine
    matrices[..., i, j], matrices[..., j, i] = sine, -sine
    return matrices


def _xyz_product(cx: Array, cy: Array, cz: Array, sx: Array, sy: Array, sz: Array) -> Array:
    """Return the products of rotations about x, y and z by their cosines and sines."""
    matrices = np.empty((*cx.shape, 3, 3))
    sxsy, cxsy = sx * sy, cx * sy
    matrices[..., 0, 0], matrices[..., 0, 1], matrices[..., 0, 2] = cy * cz, cy * sz, -sy
    matrices[..., 1, 0], matrices[..., 1, 1], matrices[..., 1, 2] = sxsy * cz - cx * sz, sxsy * sz + cx * cz, sx * cy
    matrices[..., 2, 0], matrices[..., 2, 1], matrices[..., 2, 2] = cxsy * cz + sx * sz, cxsy * sz - sx * cz, cx * cy
    return matrices
