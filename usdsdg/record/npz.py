"""Arrays by name as the bytes of a compressed .npz, the same bytes for the same arrays; `numpy.load` opens them."""

import io
import math
import zipfile
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

# The earliest that the format knows: a file must not depend on when it was written.
_DATE = (1980, 1, 1, 0, 0, 0)


def encode(arrays: Mapping[str, np.ndarray], *, level: int = 4) -> bytes:
    """Return the bytes of the file."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=level) as archive:
        for name, array in arrays.items():
            member = zipfile.ZipInfo(f"{name}.npy", _DATE)
            member.compress_type = zipfile.ZIP_DEFLATED
            content = io.BytesIO()
            np.lib.format.write_array(content, np.ascontiguousarray(array), allow_pickle=False)
            archive.writestr(member, content.getvalue(), compresslevel=level)
    return file.getvalue()


def decode(data: bytes) -> dict[str, np.ndarray]:
    """Return the arrays.

    Raises:
        ValueError, OSError, zipfile.BadZipFile: `data` are not those of a .npz, or damaged.
    """
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        return dict(arrays)


def packed(arrays: Mapping[str, np.ndarray]) -> tuple[np.ndarray, list[tuple[str, str, tuple[int, ...]]]]:
    """Return small arrays as one, uint8 (N,), and for each its name, dtype and shape, in their order.

    Compressing an array costs as much as some ten kilobytes of it, so that one takes a fraction of the time of many.
    """
    whole = [np.ascontiguousarray(array) for array in arrays.values()]
    places = [(name, array.dtype.str, array.shape) for name, array in zip(arrays, whole)]
    return np.concatenate([array.reshape(-1).view(np.uint8) for array in whole] or [np.zeros(0, np.uint8)]), places


def unpacked(data: np.ndarray, places: Sequence[tuple[str, str, Sequence[int]]]) -> dict[str, np.ndarray]:
    """Return the arrays of `packed`.

    Raises:
        ValueError, TypeError: `places` are not those of `data`.
    """
    arrays: dict[str, Any] = {}
    start = 0
    for name, kind, shape in places:
        dtype = np.dtype(kind)
        end = start + math.prod(shape) * dtype.itemsize
        if dtype.hasobject or min(shape, default=0) < 0 or end > len(data):
            raise ValueError(f"there are {len(data)} bytes, and {name} would end at {end}")
        arrays[name] = data[start:end].copy().view(dtype).reshape(shape)  # a copy is aligned
        start = end
    if start != len(data):
        raise ValueError(f"there are {len(data)} bytes, of which the arrays have {start}")
    return arrays
