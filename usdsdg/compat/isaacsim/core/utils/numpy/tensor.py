"""`isaacsim.core.utils.numpy.tensor`: arrays by the words that all backends share.

`device` is ignored: there is only the CPU.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from usdsdg.errors import ArgumentError

__all__ = [
    "as_type", "assign", "clone_tensor", "convert", "create_tensor_from_list", "create_zeros_tensor", "expand_dims",
    "move_data", "pad", "resolve_indices", "tensor_cat", "tensor_stack", "to_list", "to_numpy",
]  # fmt: skip

_TYPES = {"float32": np.float32, "bool": np.bool_, "int32": np.int32, "int64": np.int64, "long": np.int64,
          "uint8": np.uint8}  # fmt: skip


def as_type(data: ArrayLike, dtype: str) -> np.ndarray:
    """Return an array of a type.

    Raises:
        ArgumentError: there is no such type.
    """
    if dtype not in _TYPES:
        raise ArgumentError(f"dtype is {dtype!r}; expected one of {', '.join(_TYPES)}")
    return np.asarray(data).astype(_TYPES[dtype])


def convert(data: ArrayLike, device: object = None, dtype: str = "float32", indexed: object = None) -> np.ndarray:
    """Return data as an array of a type."""
    return as_type(data, dtype)


def create_zeros_tensor(shape: Sequence[int] | int, dtype: str, device: object = None) -> np.ndarray:
    return as_type(np.zeros(shape), dtype)


def create_tensor_from_list(data: ArrayLike, dtype: str, device: object = None) -> np.ndarray:
    return as_type(data, dtype)


def clone_tensor(data: ArrayLike, device: object = None) -> np.ndarray:
    """Return a copy."""
    return np.array(data)


def resolve_indices(indices: ArrayLike | None, count: int, device: object = None) -> np.ndarray:
    """Return indices as an array; those of all `count` elements for None."""
    return np.arange(count) if indices is None else np.asarray(indices)


def move_data(data: Any, device: object = None) -> Any:
    """Return the data as it is: there is only the CPU."""
    return data


def tensor_cat(data: Sequence[ArrayLike], device: object = None, dim: int = -1) -> np.ndarray:
    """Return arrays joined along an axis that they have."""
    return np.concatenate([np.asarray(each) for each in data], axis=dim)


def tensor_stack(data: Sequence[ArrayLike], dim: int = 0) -> np.ndarray:
    """Return arrays joined along a new axis."""
    return np.stack([np.asarray(each) for each in data], axis=dim)


def expand_dims(data: ArrayLike, axis: int) -> np.ndarray:
    return np.expand_dims(data, axis)


def pad(data: ArrayLike, pad_width: Any, mode: Any = "constant", value: Any = None) -> np.ndarray:
    """Return an array with borders: of `value`, or 0; with the mode "linear_ramp" of values that go there."""
    key = {"constant": "constant_values", "linear_ramp": "end_values"}.get(mode)
    return np.pad(np.asarray(data), pad_width, mode, **({key: value} if key and value is not None else {}))


def to_list(data: ArrayLike) -> list[Any]:
    return np.asarray(data).tolist()


def to_numpy(data: ArrayLike) -> np.ndarray:
    return np.asarray(data)


def assign(src: ArrayLike, dst: np.ndarray, indices: Any) -> np.ndarray:
    """Put `src` at the indices of `dst`, a list has those of each axis, and return `dst`."""
    dst[tuple(indices) if isinstance(indices, list) else indices] = src
    return dst
