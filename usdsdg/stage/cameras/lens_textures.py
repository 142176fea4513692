"""Reading of the two textures of a generalized projection: directions of pixels, and positions of directions.

Mirrors OmniLensDistortionLutAPI's rayEnterDirectionTexture and rayExitPositionTexture.
"""

import os
from functools import lru_cache

import numpy as np
from pxr import Ar

from usdsdg import errors
from usdsdg.image_files import exr
from usdsdg.stage import assets
from usdsdg.stage.cameras.lens_tables import LensTable, to_octahedral

_REMEDY = "write an OpenEXR file with 32-bit floats"
# Vectors shorter than this transmit no light; the median length of the others may differ from 1 by rounding.
_MIN_LENGTH, _ROUNDING = 0.25, 0.01
# Backwards: the direction of texels without light in Omniverse's textures.
_BACK = (0.0, 0.0, 1.0)
# Samples per axis at which the two textures are compared, and the difference that is allowed [texels of the first].
_SAMPLES, _MAX_DIFFERENCE = 48, 2.0


def read_table(directions: str, positions: str) -> LensTable:
    """Read the table of the file `directions`, and compare it with the file `positions` ("" = none).

    Warns, once, of texels that are not finite, of 16-bit floats and of textures that contradict each other: rendering
    and projection use the directions alone.

    Raises:
        AssetNotFound: there is no such file.
        AssetUnreadable: the file is damaged, too small, or has too few channels.
        Unsupported: it holds no unit directions, or is not an OpenEXR file of a supported kind.
    """
    if not directions:
        raise errors.AssetNotFound(
            "a generalized projection needs the texture of the directions of its pixels: set "
            "generalizedProjectionDirectionTexturePath, or omni:lensdistortion:lut:rayEnterDirectionTexture"
        )
    files = [assets.resolve(directions), *([assets.resolve(positions)] if positions else [])]
    return _table(*(each for file in files for each in (file, _stamp(file))))


@lru_cache(maxsize=8)
def _table(directions: str, stamp: object, positions: str = "", positions_stamp: object = None) -> LensTable:
    table = _make_table(_read(directions, 3), directions)
    if positions:
        _compare(table, directions, _read(positions, 2)[..., :2], positions)
    return table


def _stamp(file: str) -> tuple[int, int]:
    status = os.stat(Ar.SplitPackageRelativePathOuter(file)[0] if "[" in file else file)
    return status.st_mtime_ns, status.st_size


def _read(file: str, channels: int) -> np.ndarray:
    """(height, width, at least `channels`) float32."""
    asset = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(file))
    if not asset:
        raise errors.AssetUnreadable(f"{file} cannot be opened")
    with asset as opened:
        data = bytes(opened.GetBuffer())
    if data[:4] != exr.MAGIC:
        raise errors.Unsupported(f"{file} is not an OpenEXR file, and other formats cannot hold directions: {_REMEDY}")
    image = exr.decode(data, name=file)
    image = image[..., None] if image.ndim == 2 else image
    height, width, found = image.shape
    if found < channels or min(height, width) < 2:
        raise errors.AssetUnreadable(
            f"{file} has {width} x {height} texels of {found} numbers; a lens needs {channels} numbers and 2 x 2 texels"
        )
    if image.dtype == np.float16:
        errors.warn_once(
            f"{file} has 16-bit floats, which resolve directions to a thirtieth of a degree only: {_REMEDY}"
        )
    return image.astype(np.float32)


def _make_table(image: np.ndarray, file: str) -> LensTable:
    directions = image[..., :3].astype(np.float64)
    invalid = ~np.all(np.isfinite(directions), axis=-1)
    if invalid.any():
        row, column = np.argwhere(invalid)[0]
        errors.warn_once(
            f"{file}: {errors.counted(int(invalid.sum()), 'texel is', 'texels are')} NaN or infinite, the first in "
            f"column {column} of row {row}; no light gets in there"
        )
    length = np.linalg.norm(np.where(invalid[..., None], 0.0, directions), axis=-1)
    lit = (length > _MIN_LENGTH) & ~(directions == _BACK).all(axis=-1)
    if not lit.any() or np.abs(np.median(length[lit]) - 1.0) > _ROUNDING:
        found = f"of length {np.median(length[lit]):.3g}" if lit.any() else "all zero, NaN or (0, 0, 1)"
        raise errors.Unsupported(
            f"{file} holds no directions: its texels are {found}, and should be unit vectors in the camera's frame, "
            "which looks along -Z with +Y up"
        )
    return LensTable.of(directions / np.where(lit, length, 1.0)[..., None], lit)


def _compare(table: LensTable, directions: str, positions: np.ndarray, file: str) -> None:
    """Warn if the texture of positions is not the inverse of the table."""
    width, height = table.size
    across, down = np.meshgrid((np.arange(_SAMPLES) + 0.5) / _SAMPLES, (np.arange(_SAMPLES) + 0.5) / _SAMPLES)
    fractions = np.stack([across, down], axis=-1).reshape(-1, 2)
    rays = table.to_directions(fractions * (width, height) - 0.5)
    seen = np.isfinite(rays).all(axis=1)
    # It is not documented which pole of the sphere is in the middle of the map: the better one counts.
    differences = [
        np.median(
            np.linalg.norm(
                (_sampled(positions, to_octahedral(rays[seen] * axes)) - fractions[seen]) * table.size, axis=1
            )
        )
        for axes in ((1.0, 1.0, 1.0), (1.0, 1.0, -1.0))
    ]
    difference = np.nanmin([*differences, np.inf])
    if difference > _MAX_DIFFERENCE:
        errors.warn_once(
            f"{file} is not the inverse of {directions}: half of its positions differ by {difference:.1f} texels or "
            "more. Images and labels use the directions"
        )


def _sampled(image: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """Interpolate an octahedral map at coordinates (N, 2), from -1 to 1."""
    size = np.array(image.shape[1::-1])
    positions = (flat * 0.5 + 0.5) * size - 0.5
    x, y = np.clip(np.floor(positions), 0, size - 2).astype(np.int64).T
    u, v = np.clip(positions - np.stack([x, y], axis=1), 0.0, 1.0).T[..., None]
    a, b, c, d = (image[y + j, x + i].astype(np.float64) for j in (0, 1) for i in (0, 1))
    return (a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v
