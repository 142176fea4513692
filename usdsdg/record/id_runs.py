"""Images of ids as run lengths, row by row."""

import numpy as np


def encode(ids: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the ids of the runs and their lengths, in the smallest types that hold them."""
    flat = ids.ravel()
    starts = np.append(0, np.flatnonzero(flat[1:] != flat[:-1]) + 1) if flat.size else np.zeros(0, np.int64)
    return narrow(flat[starts]), narrow(np.diff(starts, append=flat.size))


def decode(values: np.ndarray, lengths: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return the image, int32 (H, W).

    Raises:
        ValueError: the runs do not fill an image of this shape.
    """
    return np.repeat(values.astype(np.int32), lengths).reshape(shape)


def narrow(numbers: np.ndarray) -> np.ndarray:
    """Return whole numbers in the smallest type that holds them."""
    low, high = (int(numbers.min()), int(numbers.max())) if numbers.size else (0, 0)
    kinds = (np.int8, np.uint8, np.int16, np.uint16, np.int32)
    fitting = (kind for kind in kinds if np.iinfo(kind).min <= low and high <= np.iinfo(kind).max)
    return numbers.astype(next(fitting, np.int64))
