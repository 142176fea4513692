"""NumPy arrays as tensors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch  # pyright: ignore[reportMissingImports]

# What PyTorch computes with, for what it does not: ids stay below 2³¹.
_AS_SIGNED = {np.dtype(np.uint16): np.int32, np.dtype(np.uint32): np.int64, np.dtype(np.uint64): np.int64}


def tensor(array: np.ndarray, device: Any = "cpu") -> torch.Tensor | dict[str, torch.Tensor]:
    """Return an array as a tensor on `device`, which shares its memory where the CPU and the type allow.

    Records, such as boxes, become one tensor for each field; strings are left out. uint16 becomes int32, uint32 and
    uint64 become int64.
    """
    if array.dtype.names is not None:
        fields = {name: array[name] for name in array.dtype.names}
        return {name: _plain(each, device) for name, each in fields.items() if each.dtype.kind in "biuf"}
    return _plain(array, device)


def tensors(arrays: Mapping[str, np.ndarray], device: Any = "cpu") -> dict[str, Any]:
    """Return arrays by name as tensors; see `tensor`."""
    return {name: tensor(array, device) for name, array in arrays.items()}


def _plain(array: np.ndarray, device: Any) -> torch.Tensor:
    signed = _AS_SIGNED.get(array.dtype)
    contiguous = np.ascontiguousarray(array if signed is None else array.astype(signed))
    return torch.from_numpy(contiguous).to(device)
