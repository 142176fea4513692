"""`isaacsim.core.utils.interops`: arrays of one library as those of another, without a copy where both allow it.

All functions are named like `warp2torch`; torch, JAX and TensorFlow are needed only by those that have their name.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

import numpy as np

from usdsdg.errors import Unsupported

_LIBRARIES = ("warp", "torch", "jax", "tensorflow", "numpy")


def _library(name: str, caller: str) -> Any:
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        package = name.partition(".")[0]
        raise Unsupported(f"{caller}: {package} is not installed; pip install {package}") from None


def _to_numpy(array: Any) -> np.ndarray:
    if hasattr(array, "detach"):
        array = array.detach().cpu()
    return array.numpy() if hasattr(array, "numpy") else np.asarray(array)


def _to_warp(array: Any) -> Any:
    import warp as wp

    return wp.from_numpy(array) if isinstance(array, np.ndarray) else wp.from_dlpack(array)


def _converter(source: str, target: str) -> Callable[[Any], Any]:
    caller = f"{source}2{target}"

    def convert(array: Any) -> Any:
        if target == "numpy":
            return _to_numpy(array)
        if target == "warp":
            return _to_warp(array)
        if target == "torch":
            torch = _library("torch", caller)
            return torch.from_numpy(array) if source == "numpy" else torch.from_dlpack(array)
        if target == "jax":
            return _library("jax.numpy", caller).asarray(_to_numpy(array) if source == "tensorflow" else array)
        return _library("tensorflow", caller).convert_to_tensor(_to_numpy(array))

    convert.__name__ = convert.__qualname__ = caller
    convert.__doc__ = (
        f"Return an array of {source} as one of {target}.\n\nRaises:\n    Unsupported: `{target}` is not installed."
    )
    return convert


_NAMES = [f"{source}2{target}" for source in _LIBRARIES for target in _LIBRARIES if source != target]
__all__ = _NAMES  # pyright: ignore[reportUnsupportedDunderAll]
globals().update({name: _converter(*name.split("2")) for name in _NAMES})
