"""The two textures of a generalized projection: directions of pixels, and positions of directions.

Mirrors OmniLensDistortionLutAPI's rayEnterDirectionTexture and rayExitPositionTexture.
"""

from __future__ import annotations

import os
from functools import lru_cache

import numpy as np
from pxr import Ar

from usdsdg import errors
from usdsdg.stage import assets
from usdsdg.stage.cameras.lens_tables import LensTable, folded
from usdsdg.stage.image_files import exr

_REMEDY = "write an OpenEXR file with 32-bit floats"
# Texels that are shorter than this let no light in; the others' lengths may differ from 1 by as much as is rounding.
_SHORTEST, _ROUNDING = 0.25, 0.01
# Straight back: what Omniverse's textures hold where no light comes in.
_BACK = (0.0, 0.0, 1.0)
# Where the two textures are compared, and the texels of the first by which they may differ.
_SAMPLES, _MOST_APART = 48, 2.0


def read_table(directions: str, positions: str) -> LensTable:
    """The table in the file `directions`, held against the file `positions` where there is one ("" = none).

    Warns, once, of texels that are no number, of 16-bit floats and of textures that contradict each other: the
    directions are what pictures show, and what places points in them.

    Raises:
        AssetNotFound: there is no such file.
        AssetUnreadable: it is damaged, too small, or has too few channels.
        Unsupported: it holds no unit directions, or is no OpenEXR file of a kind that is read.
    """
    if not directions:
        raise errors.AssetNotFound(
            "a generalized projection needs the texture that says where pixels look: set "
            "generalizedProjectionDirectionTexturePath, or omni:lensdistortion:lut:rayEnterDirectionTexture"
        )
    files = [assets.resolve(directions), *([assets.resolve(positions)] if positions else [])]
    return _table(*(each for file in files for each in (file, _stamp(file))))


@lru_cache(maxsize=8)
def _table(directions: str, stamp: object, positions: str = "", positions_stamp: object = None) -> LensTable:
    table = _table_of(_read(directions, 3), directions)
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
        raise errors.Unsupported(f"{file} is no OpenEXR file, and other files hold no directions: {_REMEDY}")
    image = exr.decode(data, name=file)
    image = image[..., None] if image.ndim == 2 else image
    height, width, found = image.shape
    if found < channels or min(height, width) < 2:
        raise errors.AssetUnreadable(
            f"{file} has {width} x {height} texels of {found} numbers; a lens needs {channels} numbers and 2 x 2 texels"
        )
    if image.dtype == np.float16:
        errors.warn_once(f"{file} has 16-bit floats, which tell directions to a thirtieth of a degree: {_REMEDY}")
    return image.astype(np.float32)


def _table_of(image: np.ndarray, file: str) -> LensTable:
    directions = image[..., :3].astype(np.float64)
    broken = ~np.isfinite(directions).all(axis=-1)
    if broken.any():
        row, column = np.argwhere(broken)[0]
        errors.warn_once(
            f"{file}: {broken.sum()} of {broken.size} texels are NaN or infinite, the first in column {column} of row "
            f"{row}; no light comes in there"
        )
    length = np.linalg.norm(np.where(broken[..., None], 0.0, directions), axis=-1)
    lit = (length > _SHORTEST) & ~(directions == _BACK).all(axis=-1)
    if not lit.any() or np.abs(np.median(length[lit]) - 1.0) > _ROUNDING:
        found = f"of length {np.median(length[lit]):.3g}" if lit.any() else "all zero, NaN or (0, 0, 1)"
        raise errors.Unsupported(
            f"{file} holds no directions: its texels are {found}, and should be unit vectors in the camera's frame, "
            "that looks along -Z with +Y up"
        )
    return LensTable.of(directions / np.where(lit, length, 1.0)[..., None], lit)


def _compare(table: LensTable, directions: str, positions: np.ndarray, file: str) -> None:
    """Warn where the positions are not those of the directions."""
    width, height = table.size
    across, down = np.meshgrid((np.arange(_SAMPLES) + 0.5) / _SAMPLES, (np.arange(_SAMPLES) + 0.5) / _SAMPLES)
    shares = np.stack([across, down], axis=-1).reshape(-1, 2)
    rays = table.to_directions(shares * (width, height) - 0.5)
    seen = np.isfinite(rays).all(axis=1)
    # Which pole of the sphere is in the middle is told nowhere: the one that fits counts.
    apart = [
        np.median(np.linalg.norm((_sampled(positions, folded(rays[seen] * flip)) - shares[seen]) * table.size, axis=1))
        for flip in ((1.0, 1.0, 1.0), (1.0, 1.0, -1.0))
    ]
    least = np.nanmin([*apart, np.inf])
    if least > _MOST_APART:
        errors.warn_once(
            f"{file} does not say where the directions of {directions} lie: half of them are {least:.1f} of its texels "
            "off, or more. Pictures and labels go by the directions"
        )


def _sampled(image: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """(N, 2) of an octahedral map, between its texels."""
    size = np.array(image.shape[1::-1])
    places = (flat * 0.5 + 0.5) * size - 0.5
    x, y = np.clip(np.floor(places), 0, size - 2).astype(np.int64).T
    u, v = np.clip(places - np.stack([x, y], axis=1), 0.0, 1.0).T[..., None]
    a, b, c, d = (image[y + j, x + i].astype(np.float64) for j in (0, 1) for i in (0, 1))
    return (a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v
