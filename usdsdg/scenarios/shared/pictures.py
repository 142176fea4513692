"""A folder of pictures as backgrounds or skies: what is in it, and how bright a sky is."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from PIL import Image, UnidentifiedImageError

from usdsdg.errors import AssetError, AssetNotFound, ConfigError
from usdsdg.image_files import exr, radiance_hdr
from usdsdg.stage import assets
from usdsdg.stage.assets.file_checks import version_of
from usdsdg.stage.assets.folder_files import files_in
from usdsdg.stage.colors import LUMINANCE, srgb_to_linear

PICTURES = (".jpg", ".jpeg", ".png", ".bmp", ".webp", ".tif", ".tiff")
SKIES = (".hdr", ".exr", *PICTURES)


@dataclass(frozen=True)
class Picture:
    """A picture file that can be opened."""

    file: str
    width: int
    height: int


def pictures_in(folder: str) -> list[Picture]:
    """Return the pictures of a folder and its subfolders, by path.

    Raises:
        ConfigError: there is no such folder, no picture in it, or one that cannot be opened.
        AssetUnreadable: this user may not read the folder, or one in it.
    """
    found, broken = [], []
    for file in _files(folder, PICTURES):
        try:
            with Image.open(file) as image:
                found.append(Picture(file, *image.size))
        except (OSError, UnidentifiedImageError, Image.DecompressionBombError) as error:
            broken.append(f"{file}: {error}")
    if broken:
        more = f"\n  and {len(broken) - 10} more" if len(broken) > 10 else ""
        raise ConfigError("pictures that cannot be opened:\n  " + "\n  ".join(broken[:10]) + more)
    return found


def skies_in(folder: str) -> list[str]:
    """Return the equirectangular pictures of a folder and its subfolders, by path.

    Raises:
        ConfigError: there is no such folder, or no picture in it.
        AssetUnreadable: this user may not read the folder, or one in it.
    """
    return _files(folder, SKIES)


def _files(folder: str, suffixes: tuple[str, ...]) -> list[str]:
    try:
        root = Path(assets.resolve(folder))
    except AssetNotFound as error:
        raise ConfigError(str(error)) from None
    if not root.is_dir():
        raise ConfigError(f"{folder} is a file; expected a folder of pictures")
    found = files_in(root, suffixes)
    if not found:
        raise ConfigError(f"{folder} has no pictures; expected files {', '.join(suffixes)}")
    return found


def mean_luminance(sky: str) -> float:
    """Return the mean luminance of an equirectangular picture over all directions, in its own units.

    Raises:
        AssetError: it cannot be read, or is black.
    """
    try:
        return _mean_luminance(sky, version_of(sky))
    except OSError as error:
        raise AssetError(f"{sky}: the sky cannot be read: {error}") from error


@lru_cache(maxsize=256)
def _mean_luminance(sky: str, _version: tuple[int, int]) -> float:
    file = Path(sky)
    try:
        if file.suffix.lower() == ".hdr":
            image = radiance_hdr.decode(file.read_bytes(), name=sky)
        elif file.suffix.lower() == ".exr":
            image = exr.decode(file.read_bytes(), name=sky)
        else:
            with Image.open(file) as picture:
                image = srgb_to_linear(np.asarray(picture.convert("RGB").resize((256, 128)), np.float64) / 255.0)
    except (OSError, ValueError, UnidentifiedImageError, Image.DecompressionBombError) as error:
        raise AssetError(f"{sky}: the sky cannot be read: {error}") from error
    image = np.asarray(image, np.float64)
    image = image if image.ndim == 3 else image[..., None]
    light = image[..., :3] @ LUMINANCE if image.shape[2] >= 3 else image[..., 0]
    rows = np.cos((np.arange(len(light)) + 0.5) / len(light) * np.pi - np.pi / 2)  # areas on the sphere
    mean = float((light.mean(axis=1) * rows).sum() / rows.sum())
    if not (np.isfinite(mean) and mean > 0.0):
        raise AssetError(f"{sky}: the sky is black or not finite, so that it cannot light anything")
    return mean
