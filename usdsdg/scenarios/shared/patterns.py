"""Pictures made by code for backgrounds: noise, gradients, stripes, checks and spots in random colors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from usdsdg.errors import OutputNotWritable
from usdsdg.stage.assets import built_folder, cache_folder

COUNT, WIDTH, HEIGHT = 36, 800, 600
# Part of the folder's name: another number paints everything again.
VERSION = 1


def pattern_folder() -> str:
    """Return the folder of the pictures in the cache; painted on first use, in a few seconds.

    Raises:
        OutputNotWritable: the cache folder cannot be written to.
    """
    target = cache_folder() / f"patterns-{VERSION}"
    try:
        return str(built_folder(target, _paint_all))
    except OSError as error:
        raise OutputNotWritable(f"patterns for backgrounds cannot be written to {target}: {error}") from error


def _paint_all(folder: Path) -> None:
    for index in range(COUNT):
        Image.fromarray(painted(index)).save(folder / f"{index:03d}.png", compress_level=1)


def painted(index: int) -> np.ndarray:
    """Return a picture (HEIGHT, WIDTH, 3) uint8, sRGB; each index gives another."""
    random = np.random.default_rng(index)
    kinds = (_clouds, _stripes, _checks, _spots, _gradient, _planks)
    amount = kinds[index % len(kinds)](random)[..., None]
    first, second = _colors(random)
    picture = first + (second - first) * amount
    # Grain and unevenness, without which surfaces look drawn.
    picture *= 1.0 + 0.25 * (_noise(random, 4) - 0.5)[..., None]
    picture += 12.0 * (_noise(random, 240) - 0.5)[..., None]
    return np.clip(picture, 0, 255).astype(np.uint8)


def _colors(random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return two sRGB colors; most pairs are muted."""
    pair = random.uniform(20.0, 235.0, (2, 3))
    if random.random() < 0.75:
        gray = pair.mean(axis=1, keepdims=True)
        pair = gray + random.uniform(0.05, 0.4) * (pair - gray)
    return pair[0], pair[1]


def _clouds(random: np.random.Generator) -> np.ndarray:
    octaves = [(_noise(random, 3 << k), 0.55**k) for k in range(6)]
    total = sum(weight * noise for noise, weight in octaves) / sum(weight for _, weight in octaves)
    return np.clip((total - 0.5) * 2.5 + 0.5, 0.0, 1.0)


def _stripes(random: np.random.Generator) -> np.ndarray:
    along, _ = _axes(random)
    period, duty = random.uniform(0.03, 0.25), random.uniform(0.2, 0.8)
    return _edge((along / period) % 1.0 - duty, 0.02)


def _checks(random: np.random.Generator) -> np.ndarray:
    along, across = _axes(random)
    period = random.uniform(0.05, 0.3)
    return ((np.floor(along / period) + np.floor(across / period)) % 2.0).astype(np.float64)


def _spots(random: np.random.Generator) -> np.ndarray:
    y, x = np.mgrid[:HEIGHT, :WIDTH] / HEIGHT
    amount = np.zeros((HEIGHT, WIDTH))
    for _ in range(int(random.integers(6, 40))):
        cx, cy, radius = random.uniform(0, WIDTH / HEIGHT), random.uniform(0, 1), random.uniform(0.02, 0.2)
        disk = _edge(radius - np.hypot(x - cx, y - cy), 0.003)
        amount = amount * (1 - disk) + disk * random.random()
    return amount


def _gradient(random: np.random.Generator) -> np.ndarray:
    along, _ = _axes(random)
    return 0.7 * (along - along.min()) / np.ptp(along) + 0.3 * _clouds(random)


def _planks(random: np.random.Generator) -> np.ndarray:
    along, across = _axes(random)
    width = random.uniform(0.06, 0.2)
    row = np.floor(along / width)
    tone = random.random(4096)[(row.astype(int) * 7 + np.floor(across / 0.7 + row * 0.37).astype(int)) % 4096]
    grain = _noise(random, 8, stretch=16)
    gap = _edge((along / width) % 1.0 - 0.03, 0.01)
    return (0.35 * tone + 0.65 * grain) * gap


def _axes(random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return coordinates along and across a random direction, in heights of the picture."""
    angle = random.uniform(0.0, np.pi)
    y, x = np.mgrid[:HEIGHT, :WIDTH] / HEIGHT
    return x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)


def _edge(distance: np.ndarray, width: float) -> np.ndarray:
    return np.clip(distance / width + 0.5, 0.0, 1.0)


def _noise(random: np.random.Generator, cells: int, *, stretch: int = 1) -> np.ndarray:
    """Return smooth noise (HEIGHT, WIDTH) in 0…1, with about `cells` values down the height."""
    shape = (cells * stretch, -(-cells * WIDTH // HEIGHT))
    values = Image.fromarray(random.integers(0, 256, shape, dtype=np.uint8))
    return np.asarray(values.resize((WIDTH, HEIGHT), Image.Resampling.BICUBIC), np.float64) / 255.0
