"""Encoding of images, arrays, JSON and text to files: each function passes the bytes to a backend.

A backend's `schedule` runs them on the I/O queue: `backend.schedule(write_image, path="rgb_0000.png", data=rgb)`.
"""

import difflib
import io
import json
import pickle
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path, PurePath
from typing import Any, Protocol

import numpy as np

from usdsdg.errors import Unsupported, WriterError
from usdsdg.image_files import exr, runs
from usdsdg.image_files.npy import npy_chunks
from usdsdg.image_files.png import channels_of, png_chunks
from usdsdg.stores.whole_file import write_whole

# Options of Pillow's files, which it does not check itself.
_OF_PNG = ("bits", "compress_type", "dictionary", "dpi", "exif", "icc_profile", "optimize", "pnginfo", "transparency")
_OF_JPEG = (
    *("comment", "dpi", "exif", "icc_profile", "keep_rgb", "qtables", "restart_marker_blocks", "restart_marker_rows"),
    *("smooth", "subsampling", "xmp"),
)


class BlobSink(Protocol):
    """The part of a backend that the functions here use."""

    def write_blob(self, path: str, data: bytes) -> None: ...


def load_encoders(paths: Iterable[str]) -> None:
    """Load what files with these names are encoded with: threads that write them cannot once the program is ending."""
    if any(path.lower().endswith((".png", ".exr")) for path in paths):
        runs.load()


def write_image(path: str, data: Any, backend_instance: BlobSink | None = None, **options: Any) -> None:
    """Write an image in the format of the path's extension: png, jpg, jpeg, exr.

    data: (H, W[, C]) array, or anything with `.numpy()` or an array interface, such as a Pillow image. uint32 ids are
        written as 16-bit gray.
    backend_instance: the backend to write to; None: `path` is a local file.
    options: those of `write_png`, `write_jpeg` or `write_exr`.

    Raises:
        WriterError: another extension, or a type or shape that the format does not support.
    """
    kind = PurePath(path).suffix.lower()
    if kind not in _ENCODERS:
        raise WriterError(f"{path}: no image format has the extension {kind!r}; use {', '.join(_ENCODERS)}.")
    _ENCODERS[kind](path, data, backend_instance, **options)


def write_png(
    path: str, data: Any, backend_instance: BlobSink | None = None, compress_level: int = 3, **options: Any
) -> None:
    """Write a PNG of uint8, uint16 or ids: (H, W), (H, W, 3) or (H, W, 4); `data` and the rest are as in `write_image`.

    compress_level: accepted and ignored where there are no other options: our own encoder has a single, fast level.
    options: those of Pillow's PNG files, such as `optimize` and `dpi`; Pillow then encodes the image, if it can: it has
        no 16-bit colors.

    Raises:
        WriterError: floats, ids above 65535, or another shape. TypeError: there is no such option.
    """
    _check_options("write_png", options, ("compress_level", *_OF_PNG))
    image = _png_ready(path, as_array(data))
    try:
        if options and (channels_of(image) == 1 or image.dtype == np.uint8):
            flat = image.reshape(image.shape[:2]) if channels_of(image) == 1 else image
            _put(backend_instance, path, _by_pillow(flat, "PNG", compress_level=compress_level, **options))
        else:
            _put(backend_instance, path, *png_chunks(image))
    except ValueError as error:
        raise WriterError(f"{path}: {error}. Give uint8 or uint16 of (H, W), (H, W, 3) or (H, W, 4).") from error


def write_jpeg(
    path: str,
    data: Any,
    backend_instance: BlobSink | None = None,
    quality: int = 75,
    *,
    progressive: bool = False,
    optimize: bool = False,
    **options: Any,
) -> None:
    """Write a JPEG of a uint8 image, (H, W[, C]); alpha is dropped. `data` and the rest are as in `write_image`.

    quality: 1 (smallest file) to 100.
    options: others of Pillow's JPEG files, such as `subsampling` and `dpi`.

    Raises:
        WriterError: another type or shape. TypeError: there is no such option.
    """
    _check_options("write_jpeg", options, ("quality", "progressive", "optimize", *_OF_JPEG))
    image = as_array(data)
    if image.dtype != np.uint8 or image.ndim not in (2, 3):
        raise WriterError(f"{path}: a JPEG cannot hold {image.dtype} of shape {image.shape}; give uint8.")
    if image.ndim == 3:
        image = image[..., 0] if image.shape[2] == 1 else image[..., :3]
    options = {"quality": quality, "progressive": progressive, "optimize": optimize, **options}
    _put(backend_instance, path, _by_pillow(image, "JPEG", **options))


def _check_options(function: str, options: Iterable[str], known: Sequence[str]) -> None:
    for name in options:
        if name not in known:
            close = difflib.get_close_matches(name, known, 1)
            meant = f"; did you mean {close[0]!r}?" if close else f"; it has {', '.join(known)}"
            raise TypeError(f"{function}() got an unexpected keyword argument {name!r}{meant}")


def _by_pillow(image: np.ndarray, kind: str, **options: Any) -> bytes:
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(image)).save(buffer, kind, **options)
    return buffer.getvalue()


def write_exr(
    path: str,
    data: Any,
    backend_instance: BlobSink | None = None,
    half_precision: bool = False,
    *,
    exr_flag: Any = None,
    compression: Any = None,
) -> None:
    """Write floats or ids as OpenEXR: (H, W) or (H, W, C) with up to four channels; `half_precision`: in 16 bits.

    `exr_flag`, FreeImage's of older scripts, and `compression` are accepted and ignored: files are ZIP, without loss.

    Raises:
        WriterError: an 8-bit image, or another shape.
    """
    image = as_array(data)
    if image.dtype == np.uint8:
        raise WriterError(f"{path}: an EXR file holds linear floats, not 8-bit colors. Give floats, or write a png.")
    try:
        _put(backend_instance, path, exr.encode(image, half=half_precision))
    except ValueError as error:
        raise WriterError(f"{path}: {error}. Give floats of (H, W), (H, W, 3) or (H, W, 4).") from error


def read_exr(path: str, backend_instance: Any = None) -> np.ndarray:
    """Read an OpenEXR file as (H, W) or (H, W, C): RGB, RGBA, or the channels in alphabetical order.

    Without a backend `path` is a local file.

    Raises:
        AssetUnreadable: the file is not an EXR file, or is damaged. FileNotFoundError: it does not exist.
        Unsupported: tiles, several parts, deep pixels, or compressions other than ZIP, ZIPS, RLE and none.
    """
    if backend_instance is None or isinstance(backend_instance, type):
        return exr.decode(Path(path).read_bytes(), name=path)
    return exr.decode(backend_instance.read_blob(path), name=path)


def write_json(
    path: str,
    data: Any,
    backend_instance: BlobSink | None = None,
    *,
    encoding: str = "utf-8",
    errors: str = "strict",
    **options: Any,
) -> None:
    """Write JSON in the key order of `data`; NumPy values become numbers and lists.

    encoding, errors: those of `str.encode`.
    options: those of `json.dumps`; `default` is asked for what has no form here.
    """
    default = options.pop("default", None)
    text = json.dumps(data, default=plain if default is None else _plain_or(default), **options)
    _put(backend_instance, path, text.encode(encoding, errors))


def _plain_or(default: Callable[[Any], Any]) -> Callable[[Any], Any]:
    def convert(value: Any) -> Any:
        return plain(value) if isinstance(value, (np.generic, np.ndarray, PurePath)) else default(value)

    return convert


def write_text(path: str, text: str, backend_instance: BlobSink | None = None) -> None:
    """Write text as UTF-8."""
    _put(backend_instance, path, text.encode())


def write_parts(path: str, texts: Callable[[], Iterable[str]], backend_instance: BlobSink | None = None) -> None:
    """Write text as UTF-8 that `texts` makes in parts, of which a file on disk never has more than one in memory."""
    chunks = _Chunks(texts)
    if backend_instance is None or isinstance(backend_instance, type):
        write_whole(Path(path), chunks)
    elif hasattr(backend_instance, "write_chunks"):
        backend_instance.write_chunks(path, chunks)  # type: ignore[attr-defined]
    else:
        backend_instance.write_blob(path, b"".join(chunks))


class _Chunks:
    """Parts of a text as bytes, which may be gone over several times."""

    def __init__(self, texts: Callable[[], Iterable[str]]) -> None:
        self._texts = texts

    def __iter__(self) -> Iterator[bytes]:
        return (text.encode() for text in self._texts())


def write_bytes(path: str, data: bytes, backend_instance: BlobSink | None = None) -> None:
    """Write bytes as they are."""
    _put(backend_instance, path, data)


def write_np(
    path: str,
    data: Any,
    backend_instance: BlobSink | None = None,
    allow_pickle: bool = True,
    *,
    fix_imports: bool = True,
) -> None:
    """Write an array as .npy; with `allow_pickle` False arrays of objects raise a ValueError.

    `fix_imports` is accepted and ignored: it concerns readers with Python 2.
    """
    _put(backend_instance, path, *npy_chunks(as_array(data), allow_pickle=allow_pickle))


def write_pickle(path: str, data: Any, backend_instance: BlobSink | None = None, **options: Any) -> None:
    """Write anything that can be pickled; `options` go to `pickle.dumps`."""
    _put(backend_instance, path, pickle.dumps(data, **options))


_ENCODERS = {".png": write_png, ".jpg": write_jpeg, ".jpeg": write_jpeg, ".exr": write_exr}


def checked_image_format(name: str) -> str:
    """Check a writer's `image_output_format` and return the file extension.

    Raises:
        WriterError: there is no such format.
        Unsupported: the format cannot hold 8-bit color.
    """
    known = (name or "").lower()
    if known == "exr":
        raise Unsupported("image_output_format 'exr' is for floats, and rendered images are 8-bit; use 'png'.")
    if f".{known}" not in _ENCODERS:
        formats = ", ".join(repr(suffix[1:]) for suffix in _ENCODERS if suffix != ".exr")
        raise WriterError(f"image_output_format {name!r} does not exist; use {formats}.")
    return known


_MOST_DIGITS = 100


def checked_padding(digits: int) -> int:
    """Check a writer's `frame_padding` and return the number of digits.

    Raises:
        WriterError: it is negative, or more than a file name can hold.
    """
    if not 0 <= digits <= _MOST_DIGITS:
        raise WriterError(f"frame_padding is {digits}; expected 0 to {_MOST_DIGITS} digits.")
    return digits


def as_array(data: Any) -> np.ndarray:
    """Convert an array, a Warp array, a tensor or a Pillow image to a NumPy array."""
    if isinstance(data, np.ndarray):
        return data
    if hasattr(data, "detach"):  # a torch tensor may be on a GPU and part of a graph
        data = data.detach().cpu()
    return np.asarray(data.numpy() if hasattr(data, "numpy") else data)


def _png_ready(path: str, image: np.ndarray) -> np.ndarray:
    """Convert an image losslessly to a type that PNG supports."""
    if image.dtype == bool:
        return image.astype(np.uint8) * 255
    if image.dtype.kind in "iu" and image.dtype.itemsize > 2:
        if image.size and not 0 <= image.min() <= image.max() <= 0xFFFF:
            raise WriterError(
                f"{path}: ids from {image.min()} to {image.max()} do not fit into a 16-bit PNG. Write an array, by "
                "write_np, or colors, as BasicWriter does with colorize_instance_segmentation."
            )
        return image.astype(np.uint16)
    return image


def plain(value: Any) -> Any:
    """Convert NumPy values and paths for `json.dumps`."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, PurePath):
        return str(value)
    raise TypeError(f"{type(value).__name__} has no JSON form: {value!r}")


def _put(backend: BlobSink | None, path: str, *chunks: bytes | memoryview) -> None:
    if backend is None or isinstance(backend, type):
        write_whole(Path(path), chunks)
    elif len(chunks) > 1 and hasattr(backend, "write_chunks"):
        backend.write_chunks(path, chunks)  # type: ignore[attr-defined]
    else:
        backend.write_blob(path, b"".join(chunks))
