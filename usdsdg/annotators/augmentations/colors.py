"""Per-pixel augmentations: brightness, contrast, color spaces, colorized depth and normals.

Images are uint8 (H, W, 3 or 4); alpha does not change. Values are truncated, not rounded, as in Replicator.
"""

import numpy as np

from usdsdg.annotators.augmentations.signatures import kernel_in_replicator
from usdsdg.graph.sampling import generator

# Weights of red, green and blue in luma (ITU-R BT.601), as in Replicator.
LUMA = (0.2989, 0.587, 0.114)


@kernel_in_replicator
def rgba_to_rgb(data_in: np.ndarray) -> np.ndarray:
    """Drop alpha: (H, W, 4) to (H, W, 3) of any type."""
    return np.ascontiguousarray(data_in[..., :3])


@kernel_in_replicator
def adjust_sigmoid(data_in: np.ndarray, cutoff: float = 0.5, gain: float = 1.0) -> np.ndarray:
    """Adjust contrast by a sigmoid: 255 / (1 + exp(gain * (cutoff - value / 255))) of each value."""
    values = np.arange(256, dtype=np.float32) / 255
    return _looked_up(data_in, 255 / (1 + np.exp(gain * (cutoff - values))))


@kernel_in_replicator
def brightness(data_in: np.ndarray, brightness_factor: float = 2.0) -> np.ndarray:
    """Multiply each value by `brightness_factor`, clipped at 255."""
    return _looked_up(data_in, np.arange(256, dtype=np.float32) * brightness_factor)


def contrast(
    data_in: np.ndarray,
    contrastFactor: float | None = None,
    contrastFactorIntervalMin: float = 0.2,
    contrastFactorIntervalMax: float = 5.0,
    seed: int = 0,
) -> np.ndarray:
    """Scale values around the mean luma: 0 gives gray, 1 the input, 2 twice the contrast.

    contrastFactor: None draws it uniformly from the interval, as older versions do.
    """
    factor = contrastFactor
    if factor is None:
        low, high = contrastFactorIntervalMin, contrastFactorIntervalMax
        factor = generator(seed, "contrast", 0).uniform(low, high)
    mean = float(gray(data_in).mean())
    return _looked_up(data_in, np.arange(256, dtype=np.float32) * factor + (1 - factor) * mean)


@kernel_in_replicator
def rgb_to_hsv(data_in: np.ndarray) -> np.ndarray:
    """Convert RGB to hue, saturation and value, integers from 0 to 255; a full turn of hue is 256 (red at 0)."""
    r, g, b = (data_in[..., channel].astype(np.int32) for channel in range(3))
    value, least = np.maximum(np.maximum(r, g), b), np.minimum(np.minimum(r, g), b)
    spread = value - least
    divisor = np.maximum(spread, 1)
    hue = np.select(
        [spread == 0, value == r, value == g],
        [0, 43 * (g - b) // divisor, 85 + 43 * (b - r) // divisor],
        171 + 43 * (r - g) // divisor,
    )
    saturation = 255 * spread // np.maximum(value, 1)
    return with_rgb(data_in, np.stack([hue % 256, saturation, value], axis=-1))


@kernel_in_replicator
def hsv_to_rgb(data_in: np.ndarray) -> np.ndarray:
    """Convert hue, saturation and value to RGB: the inverse of `rgb_to_hsv`, up to integer rounding."""
    hue, saturation, value = (data_in[..., channel].astype(np.int32) for channel in range(3))
    sector, within = hue // 43, hue % 43 * 6
    low = value * (255 - saturation) // 256
    falling = value * (255 - saturation * within // 256) // 256
    rising = value * (255 - saturation * (255 - within) // 256) // 256
    sectors = [sector == number for number in range(5)]
    r = np.select(sectors, [value, falling, low, low, rising], value)
    g = np.select(sectors, [rising, value, value, falling, low], low)
    b = np.select(sectors, [low, low, rising, value, value], falling)
    rgb = np.stack([r, g, b], axis=-1)
    return with_rgb(data_in, np.where((saturation == 0)[..., None], value[..., None], rgb))


@kernel_in_replicator
def colorize_depth(data_in: np.ndarray, near: float = 0.1, far: float = 100.0) -> np.ndarray:
    """Colorize depth (H, W) [m] as uint8 (H, W, 4): white at `near`, black at `far`, logarithmic; no hit is black.

    near, far: above 0; depths are clipped to them.
    """
    depth = data_in.astype(np.float32).reshape(data_in.shape[:2])
    seen = np.isfinite(depth)
    fraction = np.log(np.clip(np.where(seen, depth, far), near, far) / np.float32(near)) / np.log(far / near)
    shade = np.where(seen, np.clip(1 - fraction, 0, 1) * 255, 0).astype(np.uint8)
    return np.dstack([shade, shade, shade, np.full_like(shade, 255)])


@kernel_in_replicator
def colorize_normals(data_in: np.ndarray) -> np.ndarray:
    """Colorize normals (H, W, 3 or 4) as uint8 (H, W, 4): -1..1 becomes 0..255; no normal is black."""
    normals = data_in[..., :3]
    out = np.full((*data_in.shape[:2], 4), 255, np.uint8)
    out[..., :3] = np.where(normals.any(axis=-1, keepdims=True), (normals * 0.5 + 0.5) * 255, 0)
    return out


def gray(image: np.ndarray) -> np.ndarray:
    """Return the luma of an image, uint8 (H, W)."""
    return (image[..., :3].astype(np.float32) @ np.array(LUMA, np.float32)).astype(np.uint8)


def to_bytes(values: np.ndarray) -> np.ndarray:
    """Clip to 0..255 and truncate to uint8."""
    return np.clip(values, 0, 255).astype(np.uint8)


def _looked_up(image: np.ndarray, table: np.ndarray) -> np.ndarray:
    """Replace each color value by its entry in `table` (256)."""
    return with_rgb(image, to_bytes(table)[image[..., :3]])


def with_rgb(image: np.ndarray, rgb: np.ndarray) -> np.ndarray:
    """Replace the color of an image and keep its alpha."""
    out = image.copy()
    out[..., :3] = rgb
    return out
