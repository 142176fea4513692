"""Decode image files to arrays: Pillow's formats, 16-bit PNG, Radiance HDR, and OpenEXR if its module is installed."""

import io
import os
import warnings
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from PIL import Image, UnidentifiedImageError
from pxr import Ar, Sdf, Usd, UsdShade

from usdsdg import errors
from usdsdg.image_files import png16, png_transparency, radiance_hdr
from usdsdg.image_files.radiance_hdr import LARGE_PIXELS, MOST_PIXELS_A_BYTE
from usdsdg.image_files.unreadable import UNREADABLE
from usdsdg.stage import assets
from usdsdg.stage.assets.opened import note_opened
from usdsdg.stage.time_code import current_value

EXR_MAGIC = b"\x76\x2f\x31\x01"
# Names of the channels of OpenEXR that are a picture; the first set counts that a file has.
_EXR_CHANNELS = ("RGBA", "RGB", "YA", "Y", "RG", "R")
UDIM, FIRST_TILE, TILES = "<UDIM>", 1001, 100


class DecodedImage(NamedTuple):
    """The contents of an image file.

    `texels` is (H, W, 4), row 0 at the top, straight alpha: uint8 or uint16 as stored, or float32 linear.
    `channels` is how many the file has: 1 gray, 2 gray + alpha, 3 RGB, 4 RGBA.
    """

    texels: np.ndarray
    channels: int


def asset_file(attribute: Usd.Attribute) -> tuple[str, str]:
    """Return (path as authored, resolved file or "" if there is none) of an asset-valued attribute.

    Paths that USD cannot resolve are looked up under the assets root, as references are. The file of a set of UDIM
    tiles still holds <UDIM>.
    """
    value = current_value(attribute)
    if isinstance(value, str):
        value = Sdf.AssetPath(value)
    if value is not None and not isinstance(value, Sdf.AssetPath):
        return str(value), ""
    if value is None or not value.path:
        return "", ""
    if value.resolvedPath:
        return value.path, value.resolvedPath
    layer = _authoring_layer(attribute)
    for path in dict.fromkeys((value.path, assets.with_slashes(value.path))):
        if file := _located(path, layer):
            return value.path, file
    return value.path, ""


def _located(path: str, layer: Sdf.Layer | None) -> str:
    """Return the file of an asset path that USD does not resolve by itself, "" if there is none."""
    if UDIM in path:  # a path without ./ is relative to the layer only where that file exists, so tiles are tried
        return UsdShade.UdimUtils.ResolveUdimPath(path, layer)
    anchored = Sdf.ComputeAssetPathRelativeToLayer(layer, path) if layer else path
    resolved = Ar.GetResolver().Resolve(anchored)
    return resolved.GetPathString() if resolved else assets.locate_or_none(path) or ""


def _authoring_layer(attribute: Usd.Attribute) -> Sdf.Layer | None:
    """Return the layer with the strongest value of an attribute; stronger ones may have metadata alone."""
    for spec in attribute.GetPropertyStack():
        if spec.HasInfo("default") or spec.HasInfo("timeSamples"):
            return spec.layer
    return None


def udim_tiles(path: str) -> list[tuple[int, str]]:
    """Return (tile, file) of each file of an image: of <UDIM> the existing tiles, else (0, path).

    Tiles are numbered from 0 (UDIM 1001) to 99 (UDIM 1100).
    """
    if UDIM not in path:
        return [(0, path)]
    resolver = Ar.GetResolver()
    files = ((tile, path.replace(UDIM, str(FIRST_TILE + tile))) for tile in range(TILES))
    return [(tile, file) for tile, file in files if resolver.Resolve(file)]


def modified(path: str) -> tuple[int, int]:
    """Return (modification time [ns], size) of a file, or of the .usdz that it is in; (0, 0) if there is none.

    Of UDIM tiles the latest time and the total size.
    """
    files = files_of(path)
    for file in files:
        if _stamp(file) != (0, 0):
            note_opened(file)
    return stamp(files)


def files_of(path: str) -> tuple[str, ...]:
    """Return the files of an image: the path itself, or its UDIM tiles where there are any."""
    return tuple(file for _, file in udim_tiles(path)) or (path,)


def stamp(files: Sequence[str]) -> tuple[int, int]:
    """Return `modified` of an image by its files, which are not looked for."""
    stamps, sizes = zip(*map(_stamp, files))
    return max(stamps), sum(sizes)


def folder_stamp(path: str) -> tuple[int, int]:
    """Return what changes where a UDIM tile is added to those of an image, or removed; the same for other images."""
    return _stamp(os.path.dirname(path)) if UDIM in path and not Ar.IsPackageRelativePath(path) else (0, 0)


def _stamp(path: str) -> tuple[int, int]:
    try:
        status = os.stat(Ar.SplitPackageRelativePathOuter(path)[0] if "[" in path else path)
    except OSError:
        return 0, 0
    return status.st_mtime_ns, status.st_size


def read_bytes(path: str) -> bytes:
    """Read a file, which may be inside a .usdz.

    Raises:
        AssetUnreadable: it cannot be opened.
    """
    if not Ar.IsPackageRelativePath(path):
        assets.check_regular(path)
        note_opened(path)
        try:
            with open(path, "rb") as file:
                return file.read()
        except OSError as error:
            raise errors.AssetUnreadable(f"{path}: {error.strerror}") from error
    note_opened(path)
    asset = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(path))
    if not asset:
        raise errors.AssetUnreadable(f"{path}: the package has no such file")
    with asset as opened:
        return bytes(opened.GetBuffer())


def read(path: str) -> DecodedImage:
    """Decode an image file.

    Raises:
        AssetUnreadable: unknown format or damaged file; OpenEXR without its module.
    """
    values, channels = _decoded(path)
    return DecodedImage(_with_alpha(values), channels)


def read_rgb(path: str) -> np.ndarray:
    """Decode an image file to (H, W, 3), without alpha, of the dtype that `read` gives."""
    values, _ = _decoded(path)
    if values.ndim == 2:
        values = values[..., None]
    return values[..., [0, 0, 0]] if values.shape[-1] < 3 else values[..., :3]


def _decoded(path: str) -> tuple[np.ndarray, int]:
    """(H, W) gray or (H, W, 2 to 4) gray + alpha, RGB or RGBA, and the number of channels in the file."""
    data = read_bytes(path)
    if data.startswith(b"#?"):
        return radiance_hdr.decode(data, name=path), 3
    if data.startswith(EXR_MAGIC):
        return _read_exr(data, path)
    _refuse_bomb(data, path)
    values, color = png16.decode(data, name=path), png_transparency.transparent_color(data)
    if values is None:
        values, channels = _by_pillow(data, path, has_alpha=color is None)
    else:
        channels = values.shape[2]
    if color is None:
        return values, channels
    values = png_transparency.with_alpha(values, color)
    return values, values.shape[2]


def _by_pillow(data: bytes, path: str, *, has_alpha: bool) -> tuple[np.ndarray, int]:
    """`_decoded` by Pillow. has_alpha: whether a color that the file says to be transparent is."""
    try:
        with Image.open(io.BytesIO(data)) as image:
            is_wide = _has_wide_channels(image)
            image.load()
            if not has_alpha:
                image.info.pop("transparency", None)
            values, channels = _from_pillow(image)
            # Bits that Pillow drops are lost, but files of 16 bits are no colors by sRGB's curve unless they say so.
            return (values.astype(np.uint16) * 257 if is_wide and values.dtype == np.uint8 else values), channels
    except UnidentifiedImageError:
        why = assets.not_a_file_of_its_own(path) or "is no image of a format that is read"
        raise errors.AssetUnreadable(f"{path}: it {why}") from None
    except UNREADABLE as error:
        raise errors.AssetUnreadable(f"{path}: {error}") from error


def _refuse_bomb(data: bytes, path: str) -> None:
    """Refuse a small file of a very large image, which would take all memory.

    Raises:
        AssetUnreadable: it is one.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with Image.open(io.BytesIO(data)) as image:
                width, height = image.size
    except Image.DecompressionBombError as error:
        raise errors.AssetUnreadable(f"{path}: {error}") from error
    except UNREADABLE:
        return  # which decoding tells
    if width * height > max(LARGE_PIXELS, MOST_PIXELS_A_BYTE * len(data)):
        raise errors.AssetUnreadable(
            f"{path}: its {len(data)} bytes would become an image of {width} x {height}; such an image is not read"
        )


def _has_wide_channels(image: Image.Image) -> bool:
    """Whether the file of an image that is not loaded yet has channels of 16 bits."""
    return any(";16" in str(getattr(tile, "args", "")) for tile in getattr(image, "tile", ()))


def _from_pillow(image: Image.Image) -> tuple[np.ndarray, int]:
    mode = image.mode
    if mode.startswith("I;16"):
        return np.asarray(image).astype(np.uint16), 1
    if mode == "I":  # Pillow widens 16-bit gray PNGs to 32 bits
        return np.clip(np.asarray(image), 0, 65535).astype(np.uint16), 1
    if mode == "F":
        return np.asarray(image, dtype=np.float32), 1
    if mode == "P" or "transparency" in image.info:
        image = image.convert("RGBA")
        opaque = image.getchannel("A").getextrema()[0] == 255
        return np.array(image), 3 if opaque else 4
    channels = {"1": 1, "L": 1, "LA": 2, "La": 2, "PA": 4, "RGBA": 4, "RGBa": 4}.get(mode, 3)
    return np.array(image.convert("RGBA")), channels


def _with_alpha(values: np.ndarray) -> np.ndarray:
    """(H, W, 4) of gray, RGB or RGBA values of any dtype; opaque where there is no alpha."""
    if values.ndim == 2:
        values = np.repeat(values[..., None], 3, axis=-1)
    if values.shape[-1] == 4:
        return values
    if values.shape[-1] == 2:
        return values[..., [0, 0, 0, 1]]
    opaque = 1.0 if values.dtype.kind == "f" else np.iinfo(values.dtype).max
    return np.concatenate([values, np.full((*values.shape[:2], 1), opaque, values.dtype)], axis=-1)


def _read_exr(data: bytes, path: str) -> tuple[np.ndarray, int]:
    try:
        import OpenEXR  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise errors.AssetUnreadable(
            f"{path}: OpenEXR files need the exr extra. Install it with `pip install 'usdsdg[exr]'`, or convert the "
            "file to Radiance HDR."
        ) from None
    try:
        with OpenEXR.File(io.BytesIO(data)) as file:
            channels = {name: np.asarray(c.pixels, np.float32) for name, c in file.channels().items()}
    except (RuntimeError, ValueError, TypeError, OSError) as error:
        raise errors.AssetUnreadable(f"{path}: {error}") from error
    for packed in ("RGBA", "RGB"):  # the module joins channels of these names
        if packed in channels:
            return channels[packed], len(packed)
    names = next((each for each in _EXR_CHANNELS if set(each) <= channels.keys()), sorted(channels)[:1])
    values = [channels[name] for name in names]
    if tuple(names) == ("R", "G"):  # blue is 0, as in textures of two channels
        values.append(np.zeros_like(values[0]))
    return np.stack(values, axis=-1) if len(values) > 1 else values[0], len(values)
