"""Colors of segmentation ids: a function of the id alone, so that they are the same in all frames and runs."""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

BACKGROUND, UNLABELLED, FIRST_LABELED = 0, 1, 2

_GOLDEN_RATIO = 1.618033988749895


def colors_of_ids(ids: ArrayLike) -> np.ndarray:
    """Return (N, 4) uint8 RGBA of N ids, with the colors of Replicator since 1.12.26.

    Ids of labeled prims start at 2; 0 is transparent black and 1 opaque black.
    """
    return _colors_of_ids(np.ascontiguousarray(ids, np.uint64).tobytes()).copy()


@lru_cache(maxsize=32)  # frame by frame the same ids are shown
def _colors_of_ids(content: bytes) -> np.ndarray:
    ids = np.frombuffer(content, np.uint64)
    colors = hashed_colors(ids)
    colors[ids == UNLABELLED] = (0, 0, 0, 255)
    colors[ids == BACKGROUND] = 0
    return colors


def hashed_colors(ids: ArrayLike) -> np.ndarray:
    """Return (N, 4) uint8 RGBA of N ids, as `colors_of_ids` but with opaque colors for 0 and 1 too."""
    ids = np.asarray(ids, np.uint64)
    hashed = _hash(ids)
    turn = (ids.astype(np.float64) / _GOLDEN_RATIO) % 1.0
    hue = (turn + 0.1 * (hashed & 0xFFFF) / 65536) % 1.0
    saturation = 0.7 + 0.3 * ((hashed >> 16) & 255) / 255
    value = 0.8 + 0.2 * ((hashed >> 8) & 255) / 255
    colors = np.empty((len(ids), 4), np.uint8)
    colors[:, :3] = hsv_to_rgb(hue, saturation, value) * 255
    colors[:, 3] = 255
    return colors


def pastels_of_ids(ids: np.ndarray) -> np.ndarray:
    """Return (N, 3) float32 RGB from 0 to 255: pastel colors of N ids, with the hues of `colors_of_ids`."""
    ids = np.asarray(ids, np.uint64)
    hashed = _hash(ids)
    hue = ((ids.astype(np.float64) / _GOLDEN_RATIO) % 1.0 + 0.1 * (hashed & 0xFFFF) / 65536) % 1.0
    saturation = 0.3 + 0.3 * ((hashed >> 16) & 255) / 255
    value = 0.9 + 0.1 * ((hashed >> 8) & 255) / 255
    return (hsv_to_rgb(hue, saturation, value) * 255).astype(np.float32)


def _hash(ids: np.ndarray) -> np.ndarray:
    """Return the low 24 bits of a MurmurHash3-like finalizer in unbounded integers.

    They depend only on the low 40 bits of the second product, hence on the low 53 of the first, so that the overflow of
    uint64 has no effect for ids below 2**32.
    """
    h = ids.copy()
    h ^= h >> np.uint64(16)
    h *= np.uint64(0x85EBCA6B)
    h ^= h >> np.uint64(13)
    h *= np.uint64(0xC2B2AE35)
    h ^= h >> np.uint64(16)
    return (h & np.uint64(0xFFFFFF)).astype(np.int64)


def hsv_to_rgb(hue: np.ndarray, saturation: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Return (N, 3) RGB in [0, 1]; hue in turns."""
    sector = hue * 6.0
    # Distance of each channel's hue from `hue` [sectors], clipped to a trapezoid between 0 and 1.
    offsets = np.array([5.0, 3.0, 1.0])
    k = (offsets + sector[:, None]) % 6.0
    return value[:, None] * (1 - saturation[:, None] * np.clip(np.minimum(k, 4 - k), 0, 1))
