"""Pictures small enough for a page: JPEG for photographs, palettes for masks, colors for depth."""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from PIL import Image

# Colors of depth from near to far: dark red over yellow and green to dark blue (the Turbo map, thinned out).
_DEPTH_COLORS = (
    (122, 4, 3), (183, 29, 2), (224, 73, 12), (246, 117, 26), (254, 163, 49), (235, 207, 53), (199, 239, 52),
    (147, 254, 77), (78, 248, 122), (30, 229, 181), (40, 188, 235), (70, 134, 251), (65, 69, 171), (48, 18, 59),
)  # fmt: skip


@dataclass(frozen=True)
class Encoded:
    """Bytes of a picture for a page with their media type; `values` are the nearest and farthest depth [m]."""

    media: str
    data: bytes
    values: tuple[float, float] | None = None

    @property
    def uri(self) -> str:
        return f"data:{self.media};base64,{base64.b64encode(self.data).decode()}"


def photograph(path: Path, longest: int, quality: int = 82) -> tuple[Encoded, tuple[int, int]]:
    """A JPEG no longer than `longest` pixels, and the original's (width, height).

    Raises:
        OSError, ValueError: the picture is broken.
    """
    with Image.open(path) as opened:
        size = opened.size
        # JPEG sources are decoded at a fraction of their size where that is enough.
        opened.draft("RGB", (longest, longest))
        picture = _on_gray(opened)
    picture.thumbnail((longest, longest), Image.Resampling.LANCZOS, reducing_gap=2.0)
    return Encoded("image/jpeg", _saved(picture, "JPEG", quality=quality)), size


def mask(path: Path, longest: int) -> Encoded:
    """A PNG whose colors are the original's, exactly; ids without colors get some of their own."""
    with Image.open(path) as opened:
        opened.load()
        values = np.asarray(opened)
    values = values[:: _stride(values.shape, longest), :: _stride(values.shape, longest)]
    packed = values if values.ndim == 2 else _packed(values)
    ids, indices = np.unique(packed, return_inverse=True)
    # Four bytes without any alpha are ids that were only stored as colors.
    colored = values.ndim == 3 and (values.shape[2] == 3 or values[..., 3].any())
    palette = _unpacked(ids) if colored else _colors_of(ids)
    if len(ids) > 256:
        return Encoded("image/png", _saved(Image.fromarray(palette[indices.reshape(packed.shape)]), "PNG"))
    picture = Image.fromarray(indices.reshape(packed.shape).astype(np.uint8))
    picture.putpalette(palette[:, :3].tobytes())
    return Encoded("image/png", _saved(picture, "PNG", transparency=palette[:, 3].tobytes(), optimize=True))


def depth(values: np.ndarray, longest: int) -> Encoded:
    """A JPEG of depth in colors from near (red) to far (blue), on a logarithmic scale; black where nothing is hit.

    The ends are the 1st and 99th percentile, so that a few far pixels do not flatten the rest.
    """
    values = np.asarray(values, np.float32).reshape(values.shape[:2])
    values = values[:: _stride(values.shape, longest), :: _stride(values.shape, longest)]
    hit = np.isfinite(values) & (values > 0)
    near, far = (float(part) for part in np.percentile(values[hit], (1, 99))) if hit.any() else (0.0, 0.0)
    share = np.zeros(values.shape, np.float32)
    if far > near:
        share[hit] = np.log(np.clip(values[hit], near, far) / near) / np.log(far / near)
    colored = _depth_table()[(share * 255).astype(np.uint8)]
    colored[~hit] = 0
    return Encoded("image/jpeg", _saved(Image.fromarray(colored), "JPEG", quality=80), (near, far))


def _stride(shape: tuple[int, ...], longest: int) -> int:
    """Whole steps keep ids and distances what they are; averages would invent new ones."""
    return max(1, -(-max(shape[:2]) // longest))


def _on_gray(opened: Image.Image) -> Image.Image:
    if opened.mode in ("RGBA", "LA", "PA"):
        picture = opened.convert("RGBA")
        ground = Image.new("RGBA", picture.size, (128, 128, 128, 255))
        return Image.alpha_composite(ground, picture).convert("RGB")
    return opened.convert("RGB")


def _packed(values: np.ndarray) -> np.ndarray:
    """(h, w) uint32 of (h, w, 3 or 4) bytes."""
    if values.shape[2] == 3:
        values = np.concatenate([values, np.full((*values.shape[:2], 1), 255, np.uint8)], axis=2)
    return np.ascontiguousarray(values, np.uint8).view(np.uint32)[..., 0]


def _unpacked(ids: np.ndarray) -> np.ndarray:
    """(n, 4) bytes; black, which stands for things without a label, is shown as gray."""
    colours = ids.astype(np.uint32).reshape(-1, 1).view(np.uint8).copy()
    colours[(colours[:, :3] == 0).all(axis=1) & (colours[:, 3] > 0), :3] = 70
    return colours


def _colors_of(ids: np.ndarray) -> np.ndarray:
    """(n, 4) bytes: 0 is clear, 1 gray, every other id a hue by the golden ratio."""
    hue = (ids.astype(np.float64) * 0.618033988749895) % 1.0 * 6.0
    wheel = np.stack([np.abs(hue - 3) - 1, 2 - np.abs(hue - 2), 2 - np.abs(hue - 4)], axis=1).clip(0, 1)
    colours = np.concatenate([60 + 190 * wheel, np.full((len(ids), 1), 255)], axis=1).astype(np.uint8)
    colours[ids == 1] = (70, 70, 70, 255)
    colours[ids == 0] = 0
    return colours


@lru_cache(maxsize=1)
def _depth_table() -> np.ndarray:
    """(256, 3) bytes from near to far."""
    anchors = np.linspace(0, 255, len(_DEPTH_COLORS))
    columns = [np.interp(np.arange(256), anchors, channel) for channel in zip(*_DEPTH_COLORS)]
    return np.stack(columns, axis=1).astype(np.uint8)


def _saved(picture: Image.Image, format: str, **options) -> bytes:
    file = io.BytesIO()
    picture.save(file, format, **options)
    return file.getvalue()
