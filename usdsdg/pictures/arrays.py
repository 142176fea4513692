"""Arrays of annotators as pictures: colors, distances, directions, ids and other numbers per pixel."""

from __future__ import annotations

import numpy as np

from usdsdg.annotators.colors import colors_of_ids
from usdsdg.pictures.depth_colors import depth_colors

_IDS = "segmentation"
_DEPTHS = ("distance", "DepthLinearized", "DepthSensorDistance")


def picture_of(name: str, array: np.ndarray) -> tuple[np.ndarray, str] | None:
    """Return the array of an annotator as a picture, uint8 (H, W, 3), and what its colors mean; None if it is no image.

    name: of the registered annotator.
    """
    if array.dtype.names or array.ndim not in (2, 3) or not array.size:
        return None
    if array.ndim == 3 and array.shape[2] == 1:
        array = array[..., 0]
    if array.ndim == 3 and array.shape[2] > 4:
        return None
    if array.ndim == 3 and array.dtype == np.uint8:
        return _on_black(array), ""
    if array.ndim == 3 and array.shape[2] >= 3:
        return _channels(name, array[..., :3].astype(np.float32))
    if array.ndim == 3:
        array = array[..., 0]
    if array.dtype.kind in "ui" and _IDS in name:
        return _colors_of(array), "colors of ids; black is the background"
    if name.startswith(_DEPTHS):
        colored, (near, far) = depth_colors(array)
        return colored, f"red {near:.2f} m to blue {far:.2f} m; black where nothing is hit"
    return _gray(array)


def looks_like_image(array: np.ndarray) -> bool:
    """Return whether an array may be an image, and not a list of points or values."""
    return array.ndim >= 2 and min(array.shape[:2]) > 1 and not (array.ndim == 2 and array.shape[1] <= 4)


def _on_black(array: np.ndarray) -> np.ndarray:
    """Return colors without alpha, as they are over black."""
    if array.shape[2] < 4:
        return np.repeat(array[..., :1], 3, axis=2) if array.shape[2] < 3 else array
    return np.rint(array[..., :3] * (array[..., 3:].astype(np.float32) / 255)).astype(np.uint8)


def _colors_of(ids: np.ndarray) -> np.ndarray:
    present, place = np.unique(ids, return_inverse=True)
    return colors_of_ids(present)[place.reshape(ids.shape)][..., :3]


def _channels(name: str, array: np.ndarray) -> tuple[np.ndarray, str]:
    if "ormal" in name:
        return np.rint(np.clip(array * 0.5 + 0.5, 0, 1) * 255).astype(
            np.uint8
        ), "x, y, z from -1 to 1 as red, green, blue"
    return _stretched(array), "each channel from its lowest to its highest value"


def _gray(array: np.ndarray) -> tuple[np.ndarray, str]:
    values = array.astype(np.float32)
    low, high = _range(values)
    gray = _stretched(values[..., None])
    return np.repeat(gray, 3, axis=2), f"black {low:.4g} to white {high:.4g}"


def _stretched(array: np.ndarray) -> np.ndarray:
    """Return (H, W, C) uint8, each channel from its lowest to its highest finite value."""
    made = np.zeros(array.shape, np.uint8)
    for channel in range(array.shape[2]):
        low, high = _range(array[..., channel])
        finite = np.nan_to_num(array[..., channel], nan=low, posinf=high, neginf=low)
        made[..., channel] = np.rint((finite - low) / (high - low or 1.0) * 255)
    return made


def _range(values: np.ndarray) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)
