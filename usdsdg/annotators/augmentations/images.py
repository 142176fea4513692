"""Augmentations with other pictures, drawn from a folder: backgrounds, patches, blends.

Pictures are uint8 (H, W, 3 or 4); alpha stays as it is. The other picture is resized to the same size.
"""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np

from usdsdg.annotators.augmentations.colors import to_bytes, with_rgb
from usdsdg.errors import AugmentationError
from usdsdg.graph.sampling import generator

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".gif", ".tif", ".tiff", ".webp")


def background_rand(
    data_in: np.ndarray, folderpath: str = "", instance: np.ndarray | None = None, seed: int = 0
) -> np.ndarray:
    """Put a picture behind what the camera sees.

    Args:
        data_in: the picture, (H, W, 4); where its alpha is below 255 the background shines through.
        folderpath: folder with the backgrounds.
        instance: (H, W) int32, -1 where no geometry is seen, as in the AOV "instance": there is the background alone.
        seed: of the choice.

    Raises:
        AugmentationError: the folder has no pictures.
    """
    behind = _drawn_picture(folderpath, data_in.shape[:2], seed, "background_rand").astype(np.float32)
    cover = np.ones((*data_in.shape[:2], 1), np.float32)
    if data_in.shape[2] > 3:
        cover = data_in[..., 3:4] / np.float32(255)
    if instance is not None:
        cover = np.where((instance >= 0)[..., None], cover, 0)
    return with_rgb(data_in, to_bytes(cover * data_in[..., :3] + (1 - cover) * behind))


def cut_mix(data_in: np.ndarray, folderpath: str = "", seed: int = 0) -> np.ndarray:
    """Put a rectangle of another picture over this one; its corners are drawn uniformly.

    Raises:
        AugmentationError: the folder has no pictures.
    """
    height, width = data_in.shape[:2]
    other = _drawn_picture(folderpath, (height, width), seed, "cut_mix")
    draws = generator(seed, "cut_mix/corners", 0)
    rows, columns = np.sort(draws.integers(0, height, 2)), np.sort(draws.integers(0, width, 2))
    out = data_in.copy()
    patch = slice(*rows), slice(*columns), slice(0, 3)
    out[patch] = other[patch]
    return out


def image_blend(
    data_in: np.ndarray, folderpath: str = "", blendFactor: float | None = None, seed: int = 0
) -> np.ndarray:
    """Mix with another picture: (1 - blendFactor) * this + blendFactor * other.

    blendFactor: from 0 to 1; None draws it, as older versions do.

    Raises:
        AugmentationError: the folder has no pictures.
    """
    other = _drawn_picture(folderpath, data_in.shape[:2], seed, "image_blend")
    share = generator(seed, "image_blend/factor", 0).random() if blendFactor is None else blendFactor
    return with_rgb(data_in, to_bytes((1 - share) * data_in[..., :3] + share * other + 1e-3))


def _drawn_picture(folder: str, shape: tuple[int, int], seed: int, what: str) -> np.ndarray:
    """(H, W, 3) uint8: one of the pictures of `folder`, in `shape`."""
    paths = sorted(p for p in Path(folder).expanduser().glob("*") if p.suffix.lower() in SUFFIXES) if folder else []
    if not paths:
        raise AugmentationError(
            f"{what}: folderpath is {str(folder)!r}, which has no pictures ({', '.join(SUFFIXES)}). Give a folder that "
            "has."
        )
    return _resized(str(paths[generator(seed, what, 0).integers(len(paths))]), shape)


@functools.lru_cache(maxsize=16)
def _resized(path: str, shape: tuple[int, int]) -> np.ndarray:
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as picture:
            resized = picture.convert("RGB").resize(shape[::-1], Image.Resampling.BILINEAR)
    except (UnidentifiedImageError, OSError) as error:
        raise AugmentationError(f"{path} cannot be read as a picture: {error}") from error
    pixels = np.asarray(resized)
    pixels.flags.writeable = False
    return pixels
