"""Conversion of arguments of the functional API to one value per prim.

A value may be given once for all prims or once per prim, as tuples, lists or arrays.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Gf

from usdsdg.arguments.values import shown
from usdsdg.errors import ArgumentError
from usdsdg.graph.node import ReplicatorItem
from usdsdg.stage.poses.pose_batch import Rotations
from usdsdg.stage.poses.rotations import ROTATION_ORDERS, euler_from_matrix, matrix_from_euler

Array = NDArray[np.float64]

_QUATERNIONS = (Gf.Quatd, Gf.Quatf, Gf.Quath)


def per_prim(value: Any, count: int) -> list[Any]:
    """Return `count` values: those of a list of that length, else `value` (or a list's only element) for every prim."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if not isinstance(value, list):
        return [value] * count
    if len(value) == count:
        return value
    return value * count if len(value) == 1 else [value] * count


def vectors(name: str, value: Any, count: int, *, number_per_prim: bool = False) -> Array:
    """Return (count, 3) numbers from one number, three numbers, or a list with one of these per prim.

    With `number_per_prim` a list or array of `count` numbers is one number per prim, even for three prims; a tuple of
    three is always one vector.

    Raises:
        ArgumentError: `value` is none of these.
    """
    numbers = _numbers(value)
    rows = None
    if numbers is not None and np.isfinite(numbers).all():
        if numbers.shape == (count,) and number_per_prim and count != 1 and not isinstance(value, tuple):
            rows = np.repeat(numbers[:, None], 3, axis=1)
        elif numbers.shape in ((), (1,), (3,), (1, 3), (count, 3), (count, 1)):
            rows = np.broadcast_to(numbers, (count, 3))
    elif isinstance(value, (list, tuple)) and len(value) == count and count > 1 and numbers is None:
        # Numbers and vectors mixed.
        rows = np.concatenate([vectors(name, each, 1) for each in value])
    if rows is None:
        raise ArgumentError(_mismatch(name, value, count, "three numbers, one number for all of them"))
    return np.array(rows, np.float64)


def rotations(name: str, value: Any, count: int, order: str) -> Rotations:
    """Return `count` rotations from Euler angles [degrees], quaternions (x, y, z, w), Gf quaternions or Gf.Rotation.

    Angle i of a triple rotates about axis i of `order`, the first axis first; one number is used for all three.

    Raises:
        ArgumentError: the value or the order is none of these.
    """
    if order not in ROTATION_ORDERS:
        raise ArgumentError(f"rotation order is {order!r}; expected one of {', '.join(ROTATION_ORDERS)}")
    each = [value] if isinstance(value, (*_QUATERNIONS, Gf.Rotation)) else value
    if isinstance(each, (list, tuple)) and each and all(isinstance(v, (*_QUATERNIONS, Gf.Rotation)) for v in each):
        value = np.array([_xyzw(v) for v in each])
    numbers = _numbers(value)
    if numbers is not None and np.isfinite(numbers).all() and numbers.shape in ((4,), (1, 4), (count, 4)):
        return Rotations(quats=np.array(np.broadcast_to(numbers, (count, 4))))
    try:
        degrees = vectors(name, value, count)
    except ArgumentError:
        expected = "three angles in degrees, a quaternion (x, y, z, w), a Gf.Rotation"
        raise ArgumentError(_mismatch(name, value, count, expected)) from None
    if order == "XYZ":
        return Rotations(degrees=degrees)
    by_axis = degrees[:, [order.index(axis) for axis in "XYZ"]]
    return Rotations(degrees=euler_from_matrix(matrix_from_euler(by_axis, order)))


def _xyzw(value: Any) -> tuple[float, ...]:
    quat = value.GetQuat() if isinstance(value, Gf.Rotation) else value
    return (*quat.GetImaginary(), quat.GetReal())


def _numbers(value: Any) -> Array | None:
    """Convert `value` to an array; None if it is not numeric."""
    try:
        return np.asarray(value, np.float64)
    except (TypeError, ValueError):
        return None


def _mismatch(name: str, value: Any, count: int, expected: str) -> str:
    if isinstance(value, ReplicatorItem) or hasattr(value, "node"):
        return (
            f"{name} is a distribution, but functional calls act at once, when the line runs. Sample the numbers first "
            f"(rep.rng.ReplicatorRNG().generator.uniform(...)), or use rep.modify / rep.create, which sample it when a "
            "trigger fires"
        )
    return f"{name} is {shown(value)}; expected {expected}, or a list with one such value for each of {count} prims"
