"""Encoding of images for the page: JPEG for color, palettes for masks, colorized depth."""

import base64
import io
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import Image

from usdsdg.pictures.depth_colors import depth_colors


@dataclass(frozen=True)
class Encoded:
    """An encoded image with its media type; `values` are the nearest and farthest depth [m]."""

    media: str
    data: bytes
    values: tuple[float, float] | None = None

    @property
    def uri(self) -> str:
        return f"data:{self.media};base64,{base64.b64encode(self.data).decode()}"


def photograph(image: np.ndarray, longest: int) -> Encoded:
    """Encode an image, (H, W) or (H, W, 3 or 4) uint8, as JPEG with at most `longest` pixels per side."""
    picture = _on_gray(Image.fromarray(_bytes(image)))
    picture.thumbnail((longest, longest), Image.Resampling.LANCZOS, reducing_gap=2.0)
    return Encoded("image/jpeg", _saved(picture, "JPEG", quality=82))


def mask(values: np.ndarray, longest: int) -> Encoded:
    """Encode a mask, ids (H, W) or colors (H, W, 3 or 4), as PNG with exactly its colors; ids get generated ones."""
    values = values[:: _stride(values.shape, longest), :: _stride(values.shape, longest)]
    shown = values if values.ndim == 2 else _packed(values)
    ids, indices = np.unique(shown, return_inverse=True)
    # Four channels without any alpha are ids that were stored as colors.
    colored = values.ndim == 3 and (values.shape[2] == 3 or values[..., 3].any())
    palette = _unpacked(ids) if colored else _colors_of(ids)
    if len(ids) > 256:
        return Encoded("image/png", _saved(Image.fromarray(palette[indices.reshape(shown.shape)]), "PNG"))
    picture = Image.fromarray(indices.reshape(shown.shape).astype(np.uint8))
    picture.putpalette(palette[:, :3].tobytes())
    return Encoded("image/png", _saved(picture, "PNG", transparency=palette[:, 3].tobytes(), optimize=True))


def depth(values: np.ndarray, longest: int) -> Encoded:
    """Encode depth as JPEG in colors from near (red) to far (blue), on a logarithmic scale; black where nothing is hit.

    The ends are the 1st and 99th percentile, so that a few far pixels do not compress the scale.
    """
    step = _stride(values.shape, longest)
    colored, ends = depth_colors(values[::step, ::step])
    return Encoded("image/jpeg", _saved(Image.fromarray(colored), "JPEG", quality=80), ends)


def _bytes(image: np.ndarray) -> np.ndarray:
    """Return an image as bytes: those of 16 bits lose their lower half, yes and no become white and black."""
    if image.dtype == bool:
        return image.astype(np.uint8) * 255
    return (image >> 8).astype(np.uint8) if image.dtype == np.uint16 else image.astype(np.uint8)


def _stride(shape: tuple[int, ...], longest: int) -> int:
    """Return the integer subsampling step: averages of ids or distances would be meaningless."""
    return max(1, -(-max(shape[:2]) // longest))


def _on_gray(opened: Image.Image) -> Image.Image:
    if opened.mode in ("RGBA", "LA", "PA"):
        picture = opened.convert("RGBA")
        ground = Image.new("RGBA", picture.size, (128, 128, 128, 255))
        return Image.alpha_composite(ground, picture).convert("RGB")
    return opened.convert("RGB")


def _packed(values: np.ndarray) -> np.ndarray:
    """Pack (h, w, 3 or 4) bytes into (h, w) uint32."""
    if values.shape[2] == 3:
        values = np.concatenate([values, np.full((*values.shape[:2], 1), 255, np.uint8)], axis=2)
    return np.ascontiguousarray(values, np.uint8).view(np.uint32)[..., 0]


def _unpacked(ids: np.ndarray) -> np.ndarray:
    """Unpack colors to (n, 4) bytes; black, the color of unlabeled gprims, becomes gray."""
    colors = ids.astype(np.uint32).reshape(-1, 1).view(np.uint8).copy()
    colors[(colors[:, :3] == 0).all(axis=1) & (colors[:, 3] > 0), :3] = 70
    return colors


def _colors_of(ids: np.ndarray) -> np.ndarray:
    """Generate colors (n, 4) for ids: 0 is transparent, 1 gray, every other id a hue by the golden ratio."""
    hue = (ids.astype(np.float64) * 0.618033988749895) % 1.0 * 6.0
    wheel = np.stack([np.abs(hue - 3) - 1, 2 - np.abs(hue - 2), 2 - np.abs(hue - 4)], axis=1).clip(0, 1)
    colors = np.concatenate([60 + 190 * wheel, np.full((len(ids), 1), 255)], axis=1).astype(np.uint8)
    colors[ids == 1] = (70, 70, 70, 255)
    colors[ids == 0] = 0
    return colors


def _saved(picture: Image.Image, format: str, **options: Any) -> bytes:
    file = io.BytesIO()
    picture.save(file, format, **options)
    return file.getvalue()
