"""Arrays as Isaac Sim's wrappers take and return them: numbers, lists, NumPy, Warp and torch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from usdsdg.errors import counted, warn_once
from usdsdg.warp_start import quiet_warp

if TYPE_CHECKING:
    import warp as wp

    # What a script may pass; torch tensors too, which are not named since torch may be absent.
    Values: TypeAlias = float | Sequence[float] | Sequence[Sequence[float]] | np.ndarray | wp.array
    Indices: TypeAlias = int | Sequence[int] | np.ndarray | wp.array | None


def as_numpy(value: Values) -> np.ndarray:
    """Return a NumPy array of a number, sequence, NumPy or Warp array or torch tensor; from a device it is copied."""
    if hasattr(value, "detach"):
        value = value.detach().cpu()  # pyright: ignore[reportAttributeAccessIssue]  # a torch tensor
    if not isinstance(value, np.ndarray) and hasattr(value, "numpy"):
        value = value.numpy()  # pyright: ignore[reportAttributeAccessIssue]  # Warp or torch
    return np.asarray(value)


def rows(value: Values, width: int, count: int) -> np.ndarray:
    """Return `count` rows (count, width); one row serves for all.

    Raises:
        ValueError: the numbers do not fill one row or `count` rows.
    """
    numbers = as_numpy(value)
    if numbers.size % width or numbers.size // width not in (1, count):
        raise ValueError(
            f"an array of shape {numbers.shape} has no {counted(count, 'row')} of {counted(width, 'number')}, nor one "
            "for all"
        )
    return np.broadcast_to(numbers.reshape(-1, width), (count, width))


def rows_or_none(value: Values | None, width: int, count: int) -> np.ndarray | None:
    """Return `rows` of what is given; None where nothing is."""
    return None if value is None else rows(value, width, count)


def pose_rows(
    points: Values | None, orientations: Values | None, count: int
) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Return `rows` of points (count, 3) and of orientations (count, 4), likewise."""
    return rows_or_none(points, 3, count), rows_or_none(orientations, 4, count)


def grid(value: Values, shape: tuple[int, int]) -> np.ndarray:
    """Return an array of a shape (n, d); one number, one row or one column serves for all, as NumPy broadcasts.

    Raises:
        ValueError: the numbers cannot be broadcast to that.
    """
    numbers = as_numpy(value)
    if numbers.size == shape[0] * shape[1]:
        return numbers.reshape(shape)
    try:
        return np.broadcast_to(numbers, shape)
    except ValueError:
        raise ValueError(
            f"an array of shape {numbers.shape} does not fill {counted(shape[0], 'row')} of "
            f"{counted(shape[1], 'number')}"
        ) from None


def column(value: Values, count: int) -> list[float]:
    """Return one Python number (or bool) per prim; one serves for all."""
    return rows(value, 1, count)[:, 0].tolist()


def names(value: str | Sequence[str], count: int) -> list[str]:
    """Return one text per prim; one serves for all.

    Raises:
        ValueError: there are neither one nor `count` texts.
    """
    texts = [value] if isinstance(value, str) else list(value)
    if len(texts) not in (1, count):
        given = counted(len(texts), "value is", "values are")
        raise ValueError(f"{given} given for {counted(count, 'prim')}; give one for each or one for all")
    return texts * count if len(texts) == 1 else texts


def chosen(indices: Indices, count: int) -> list[int]:
    """Return the indices as a list; all `count` if they are None."""
    return list(range(count)) if indices is None else [int(index) for index in as_numpy(indices).reshape(-1)]


def as_warp(array: np.ndarray, device: str = "cpu") -> wp.array:
    """Return a copy as a Warp array of the same scalar type."""
    quiet_warp()
    import warp as wp

    return wp.array(np.ascontiguousarray(array), device=device)


def as_backend(array: np.ndarray, backend: str, device: str = "cpu") -> np.ndarray:
    """Return the array as the backend "numpy", "torch" or "warp" has it; the type that is declared is NumPy's.

    Raises:
        ValueError: there is no such backend.
    """
    if backend == "numpy":
        return array
    if backend == "warp":
        return as_warp(array, device)  # pyright: ignore[reportReturnType]
    if backend == "torch":
        import torch  # pyright: ignore[reportMissingImports]

        # torch cannot index with unsigned integers.
        signed = array.astype(np.int32) if array.dtype == np.uint32 else np.array(array)
        return torch.from_numpy(signed).to(device)
    raise ValueError(f"there is no backend {backend!r}; give 'numpy', 'torch' or 'warp'")


def known_device(device: str) -> str:
    """Return "cpu" or the CUDA device of that name; "cpu", with a warning, where there is no CUDA device.

    Raises:
        ValueError: it is the name of no kind of device.
    """
    quiet_warp()
    import warp as wp

    if device.split(":")[0] not in ("cpu", "cuda"):
        raise ValueError(f"device {device!r} is neither 'cpu' nor 'cuda' nor 'cuda:N'")
    if device != "cpu" and not wp.is_cuda_available():
        warn_once(f"device {device!r}: there is no CUDA device, so arrays are on the CPU")
        return "cpu"
    return "cuda:0" if device == "cuda" else device
