"""`isaacsim.test.utils.image_io`: pictures that examples and tests of Isaac Sim save and read."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from usdsdg.errors import BadValue

__all__ = ["read_image_as_array", "save_depth_image", "save_rgb_image"]

GRAY = 128  # of a picture without two different depths


def save_rgb_image(rgb_data: np.ndarray, out_dir: str, file_name: str) -> None:
    """Save colors, uint8 or 0 to 1, (H, W, 3) or (H, W, 4), to a file of a folder, which is made.

    Raises:
        BadValue: the array has another shape.
    """
    colors = np.asarray(rgb_data)
    if colors.ndim != 3 or colors.shape[2] not in (3, 4):
        raise BadValue(f"rgb_data has the shape {colors.shape}; expected (H, W, 3) or (H, W, 4)")
    _save(_bytes_of(colors), out_dir, file_name)


def save_depth_image(depth_data: np.ndarray, out_dir: str, file_name: str, normalize: bool = False) -> None:
    """Save depths, (H, W) or (H, W, 1), to a file of a folder, which is made.

    TIFF files have them as float32. Others are gray: the smallest finite depth is black and the largest white if
    `normalize` is true, else 0 and 1 are; what is not finite is black, and with it a picture of one depth gray.

    Raises:
        BadValue: the array has another shape.
    """
    depths = np.asarray(depth_data)
    if depths.ndim == 3 and depths.shape[2] == 1:
        depths = depths[:, :, 0]
    if depths.ndim != 2:
        raise BadValue(f"depth_data has the shape {depths.shape}; expected (H, W) or (H, W, 1)")
    if Path(file_name).suffix.lower() in (".tif", ".tiff"):
        _save(depths.astype(np.float32), out_dir, file_name)
    else:
        _save(_spread(depths) if normalize else _bytes_of(depths), out_dir, file_name)


def read_image_as_array(file_path: str, squeeze_singleton_channel: bool = True) -> np.ndarray:
    """Return the pixels of a file; gray ones are (H, W), or (H, W, 1) if `squeeze_singleton_channel` is false."""
    from PIL import Image

    with Image.open(file_path) as image:
        pixels = np.array(image)
    return pixels[:, :, np.newaxis] if pixels.ndim == 2 and not squeeze_singleton_channel else pixels


def _spread(depths: np.ndarray) -> np.ndarray:
    """Return 0 to 255 from the smallest finite depth to the largest."""
    finite = np.isfinite(depths)
    least, most = (depths[finite].min(), depths[finite].max()) if finite.any() else (0.0, 0.0)
    if most <= least:
        return np.full(depths.shape, GRAY, np.uint8)
    return ((np.where(finite, depths, least) - least) / (most - least) * 255).astype(np.uint8)


def _bytes_of(values: np.ndarray) -> np.ndarray:
    """Return floats from 0 to 1 as 0 to 255, and integers as they are."""
    if np.issubdtype(values.dtype, np.floating):
        return (np.clip(np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0), 0, 1) * 255).astype(np.uint8)
    return values.astype(np.uint8)


def _save(pixels: np.ndarray, out_dir: str, file_name: str) -> None:
    from PIL import Image

    path = Path(out_dir) / file_name
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(path)
    print(f"saved {path}")
