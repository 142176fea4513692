"""Augmentations with random images from a folder: backgrounds, patches, blends.

Images are uint8 (H, W, 3 or 4); alpha does not change. The other image is resized to the same size.
"""

import functools
import os
from pathlib import Path

import numpy as np

from usdsdg.annotators.augmentations.colors import to_bytes, with_rgb
from usdsdg.errors import AugmentationError
from usdsdg.graph.sampling import generator
from usdsdg.stage.assets.file_checks import version_of

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".gif", ".tif", ".tiff", ".webp")


def background_rand(
    data_in: np.ndarray, folderpath: str = "", instance: np.ndarray | None = None, seed: int = 0
) -> np.ndarray:
    """Composite the image over a random background.

    Args:
        data_in: the image, (H, W, 4); where its alpha is below 255 the background shows through.
        folderpath: folder with the backgrounds.
        instance: the AOV "instance", (H, W) int32, -1 where no geometry is hit: only the background shows there.
        seed: of the choice.

    Raises:
        AugmentationError: the folder has no images.
    """
    behind = _random_image(folderpath, data_in.shape[:2], seed, "background_rand").astype(np.float32)
    alpha = np.ones((*data_in.shape[:2], 1), np.float32)
    if data_in.shape[2] > 3:
        alpha = data_in[..., 3:4] / np.float32(255)
    if instance is not None:
        alpha = np.where((instance >= 0)[..., None], alpha, 0)
    return with_rgb(data_in, to_bytes(alpha * data_in[..., :3] + (1 - alpha) * behind))


def cut_mix(data_in: np.ndarray, folderpath: str = "", seed: int = 0) -> np.ndarray:
    """Replace a rectangle by that of a random image; its corners are drawn uniformly.

    Raises:
        AugmentationError: the folder has no images.
    """
    height, width = data_in.shape[:2]
    other = _random_image(folderpath, (height, width), seed, "cut_mix")
    draws = generator(seed, "cut_mix/corners", 0)
    rows, columns = np.sort(draws.integers(0, height, 2)), np.sort(draws.integers(0, width, 2))
    out = data_in.copy()
    patch = slice(*rows), slice(*columns), slice(0, 3)
    out[patch] = other[patch]
    return out


def image_blend(
    data_in: np.ndarray, folderpath: str = "", blendFactor: float | None = None, seed: int = 0
) -> np.ndarray:
    """Blend with a random image: (1 - blendFactor) * this + blendFactor * other.

    blendFactor: from 0 to 1; None draws it, as older versions do.

    Raises:
        AugmentationError: the folder has no images.
    """
    other = _random_image(folderpath, data_in.shape[:2], seed, "image_blend")
    factor = generator(seed, "image_blend/factor", 0).random() if blendFactor is None else blendFactor
    return with_rgb(data_in, to_bytes((1 - factor) * data_in[..., :3] + factor * other + 1e-3))


def _random_image(folder: str, shape: tuple[int, int], seed: int, what: str) -> np.ndarray:
    """Return a random image of `folder`, resized to `shape`, uint8 (H, W, 3)."""
    paths = (
        sorted(p for p in Path(os.path.expanduser(folder)).glob("*") if p.suffix.lower() in SUFFIXES) if folder else []
    )
    if not paths:
        raise AugmentationError(
            f"{what}: folderpath is {str(folder)!r}, which has no images ({', '.join(SUFFIXES)}). Give a folder "
            "with images."
        )
    path = str(paths[generator(seed, what, 0).integers(len(paths))])
    return _resized(path, version_of(path), shape)


@functools.lru_cache(maxsize=16)
def _resized(path: str, _version: tuple[int, int], shape: tuple[int, int]) -> np.ndarray:
    from PIL import Image, UnidentifiedImageError

    height, width = shape
    try:
        with Image.open(path) as opened:
            resized = opened.convert("RGB").resize((width, height), Image.Resampling.BILINEAR)
    except (UnidentifiedImageError, OSError) as error:
        raise AugmentationError(f"{path} cannot be read as an image: {error}") from error
    pixels = np.asarray(resized)
    pixels.flags.writeable = False
    return pixels
