"""The dome light's picture, and the density from which directions towards it are drawn."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import warp as wp

from usdsdg_render.kernels import types
from usdsdg_render.scene import Dome

# A finer grid finds small suns better and costs more cache.
MAX_GRID = (512, 1024)
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)


class SkyGrid(NamedTuple):
    """A piecewise-constant density over latitude rows and longitude columns."""

    irradiance: float  # luminance times solid angle, over the whole sky
    density: np.ndarray  # (H, W) float32 per steradian
    row_cdf: np.ndarray  # (H + 1,) float32
    cell_cdf: np.ndarray  # (H, W + 1) float32


def sampled(dome: Dome) -> SkyGrid | None:
    """The sampling grid of a dome; None for a black one."""
    weight = np.maximum(np.nan_to_num(dome.radiance @ _LUMINANCE, posinf=0.0), 0.0)
    weight = _shrunk(_spread(weight))
    height, width = weight.shape
    weight = weight.astype(np.float64)
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    solid_angle = (edges[:-1] - edges[1:])[:, None] * (2 * np.pi / width)
    mass = weight * solid_angle
    total = mass.sum()
    if not total > 0:
        return None
    rows = mass.sum(1)
    row_cdf = np.append(0.0, np.cumsum(rows) / total)
    within = np.cumsum(mass, 1) / np.where(rows > 0, rows, 1.0)[:, None]
    cell_cdf = np.concatenate([np.zeros((height, 1)), within], 1)
    row_cdf[-1] = cell_cdf[:, -1] = 1.0
    return SkyGrid(
        float(total),
        (mass / total / solid_angle).astype(np.float32),
        row_cdf.astype(np.float32),
        cell_cdf.astype(np.float32),
    )


def upload(dome: Dome | None, device: str) -> types.Dome:
    """The kernels' record of a dome."""
    record = types.Dome()
    record.dome_from_world = wp.mat33(np.eye(3))
    if dome is None:
        return record
    record.height, record.width = dome.radiance.shape[:2]
    texels = np.nan_to_num(dome.radiance.astype(np.float32), posinf=0.0).reshape(-1, 3)
    record.radiance = wp.array(texels, dtype=wp.vec3, device=device)
    record.dome_from_world = wp.mat33(dome.dome_from_world.astype(np.float32))
    record.visible = int(dome.visible)
    grid = sampled(dome)
    if grid is None:
        grid = SkyGrid(0.0, np.zeros((1, 1), np.float32), np.zeros(2, np.float32), np.zeros((1, 2), np.float32))
    record.grid_height, record.grid_width = grid.density.shape
    record.density = wp.array(grid.density.reshape(-1), dtype=wp.float32, device=device)
    record.row_cdf = wp.array(grid.row_cdf, dtype=wp.float32, device=device)
    record.cell_cdf = wp.array(grid.cell_cdf.reshape(-1), dtype=wp.float32, device=device)
    # A surface sees half the sky, at half its projected area on average.
    record.strength = grid.irradiance / 4.0
    return record


def _spread(weight: np.ndarray) -> np.ndarray:
    """Half of each texel and a share of its neighbours: bilinear look-up reaches half a texel beyond a bright one."""
    rows = np.pad(weight, ((1, 1), (0, 0)), mode="edge")
    rows = 0.25 * rows[:-2] + 0.5 * rows[1:-1] + 0.25 * rows[2:]
    return 0.25 * np.roll(rows, 1, 1) + 0.5 * rows + 0.25 * np.roll(rows, -1, 1)


def _shrunk(weight: np.ndarray) -> np.ndarray:
    """Averages over the cells of a grid no larger than MAX_GRID."""
    for axis, most in enumerate(MAX_GRID):
        count = weight.shape[axis]
        if count > most:
            running = np.insert(np.cumsum(weight, axis, dtype=np.float64), 0, 0.0, axis)
            edges = np.linspace(0, count, most + 1)
            below = np.minimum(edges.astype(int), count - 1)
            part = np.expand_dims(edges - below, 1 - axis)
            at_edges = np.take(running, below, axis) + part * np.take(weight, below, axis)
            weight = np.diff(at_edges, axis=axis) * (most / count)
    return weight
