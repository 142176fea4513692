"""Procedural albedo patterns, as functions of position on a surface."""

from collections.abc import Sequence

import numpy as np

from usdsdg.demo.paint import fractal, generator
from usdsdg.demo.skies.room import Pattern

Albedo = tuple[float, float, float]
_GRAIN = fractal((256, 256), (4, 4), "rooms", octaves=6)


def grain(u: np.ndarray, v: np.ndarray, scale: float) -> np.ndarray:
    """Fractal noise around 0, `scale` repetitions per meter."""
    rows = (v * scale * 256.0).astype(np.int64) % 256
    columns = (u * scale * 256.0).astype(np.int64) % 256
    return _GRAIN[rows, columns] - 0.5


def plain(color: Albedo, roughness: float = 0.25) -> Pattern:
    """One color with faint noise: plaster, cloth, carpet."""

    def pattern(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        shade = 1.0 + roughness * grain(u, v, 0.7) + 0.5 * roughness * grain(v, u, 5.0)
        return np.outer(shade, color)

    return pattern


def planks(color: Albedo, width: float = 0.14, length: float = 1.6, *, upright: bool = False) -> Pattern:
    """Boards of varying brightness with dark joints."""

    def pattern(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        across, along = (u, v) if upright else (v, u)
        board = np.floor(across / width)
        piece = np.floor(along / length + 0.37 * board)
        shade = 0.75 + 0.5 * _hash(board, piece) + 0.5 * grain(along, across * 9.0, 0.5)
        joint = np.abs(across / width - board - 0.5) > 0.5 - 0.004 / width
        return np.outer(np.where(joint, 0.35 * shade, shade), color)

    return pattern


def tiles(color: Albedo, joint: Albedo, size: tuple[float, float] = (0.3, 0.3), *, running: bool = False) -> Pattern:
    """A grid of tiles; with `running` every other row is shifted by half a tile, as bricks are."""

    def pattern(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        row = np.floor(v / size[1])
        column_position = u / size[0] + (0.5 * (row % 2) if running else 0.0)
        column = np.floor(column_position)
        gap_u = np.abs(column_position - column - 0.5) > 0.5 - 0.006 / size[0]
        gap_v = np.abs(v / size[1] - row - 0.5) > 0.5 - 0.006 / size[1]
        shade = 0.85 + 0.3 * _hash(row, column) + 0.3 * grain(u, v, 1.3)
        return np.where((gap_u | gap_v)[:, None], np.asarray(joint), np.outer(shade, color))

    return pattern


def slats(color: Albedo, width: float, depth: float = 0.35, *, upright: bool = False) -> Pattern:
    """Soft ribs: roller doors (horizontal) and curtains (`upright`)."""

    def pattern(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        position = u if upright else v
        return np.outer(1.0 - depth * (0.5 + 0.5 * np.sin(position * 2.0 * np.pi / width)), color)

    return pattern


def shelf(frame: Albedo, goods: Sequence[Albedo], cell: tuple[float, float] = (0.16, 0.42)) -> Pattern:
    """Shelf boards with goods of varying heights and colors."""

    def pattern(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        row = np.floor(v / cell[1])
        column = np.floor(u / cell[0])
        height = (v / cell[1] - row) / (0.45 + 0.45 * _hash(row, column))
        sides = np.abs(u / cell[0] - column - 0.5)
        palette = np.asarray(goods)
        color = palette[(_hash(column, row + 7.0) * len(palette)).astype(int) % len(palette)]
        goods_here = (height > 0.1) & (height < 1.0) & (sides < 0.44)
        board = v / cell[1] - row < 0.09
        return np.where(
            goods_here[:, None], color, np.where(board[:, None], np.asarray(frame), 0.15 * np.asarray(frame))
        )

    return pattern


def wainscot(below: Pattern, above: Pattern, height: float) -> Pattern:
    """One pattern up to a height, a dark ledge, and another pattern above it. For walls only."""

    def pattern(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        lower = (v < height)[:, None]
        ledge = (np.abs(v - height) < 0.03)[:, None]
        return np.where(ledge, 0.5 * below(u, v), np.where(lower, below(u, v), above(u, v)))

    return pattern


def rug(ground: Pattern, color: Albedo, low: tuple[float, float], high: tuple[float, float]) -> Pattern:
    """A rectangular carpet with a border on a floor."""

    def pattern(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        inside = np.minimum(np.minimum(u - low[0], high[0] - u), np.minimum(v - low[1], high[1] - v))
        weave = 1.0 + 0.4 * grain(u, v, 6.0)
        border = np.where((inside > 0.12) & (inside < 0.18), 2.2, 1.0)
        return np.where((inside > 0.0)[:, None], np.outer(weave * border, color), ground(u, v))

    return pattern


def _hash(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Hash pairs of integers to values in 0…1."""
    table = generator("hash").random(1024)
    return table[(first.astype(np.int64) * 131 + second.astype(np.int64) * 71) % 1024]
