"""The dome light's picture, and the density from which directions towards it are drawn."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import warp as wp

from usdsdg_render.kernels import types
from usdsdg_render.scene import Dome

# Cells of the coarse sky: half a megabyte stays in a core's cache.
GRID_HEIGHT, GRID_WIDTH = 256, 512
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


class SkyGrid(NamedTuple):
    """A sky of constant cells, and running sums to draw cells by the light that comes from them."""

    irradiance: float  # luminance times solid angle, over the whole sky
    density: np.ndarray  # (H, W) float32 per steradian
    row_cdf: np.ndarray  # (H + 1,) float32
    cell_cdf: np.ndarray  # (H, W + 1) float32


def sampled(radiance: np.ndarray) -> SkyGrid:
    """How to draw from a sky of cells, (H, W, 3) [nits]; a black one is drawn from uniformly, with no weight."""
    luminance = radiance.astype(np.float64) @ _LUMINANCE
    height, width = luminance.shape
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    solid_angle = (edges[:-1] - edges[1:])[:, None] * (2 * np.pi / width)
    irradiance = float((luminance * solid_angle).sum())
    mass = luminance * solid_angle if irradiance > 0 else np.broadcast_to(solid_angle, luminance.shape)
    total, rows = mass.sum(), mass.sum(1)
    row_cdf = np.append(0.0, np.cumsum(rows) / total)
    within = np.cumsum(mass, 1) / np.where(rows > 0, rows, 1.0)[:, None]
    cell_cdf = np.concatenate([np.zeros((height, 1)), within], 1)
    row_cdf[-1] = cell_cdf[:, -1] = 1.0
    density = (mass / total / solid_angle).astype(np.float32)
    return SkyGrid(irradiance, density, row_cdf.astype(np.float32), cell_cdf.astype(np.float32))


def upload(dome: Dome | None, device: str) -> types.Dome:
    """The kernels' record of a dome."""
    record = types.Dome()
    record.dome_from_world = wp.mat33(np.eye(3))
    if dome is None:
        return record
    radiance = np.maximum(np.nan_to_num(dome.radiance.astype(np.float32), posinf=0.0), 0.0)
    cells = resized(radiance)
    record.unit = packing_unit(radiance)
    grid = sampled(cells)
    words = np.stack([packed(cells, record.unit), grid.density.view(np.uint32)], -1)
    record.texels = wp.array(packed(radiance, record.unit).reshape(-1), dtype=wp.uint32, device=device)
    record.cells = wp.array(words.reshape(-1), dtype=wp.uint32, device=device)
    record.row_cdf = wp.array(grid.row_cdf, dtype=wp.float32, device=device)
    record.cell_cdf = wp.array(grid.cell_cdf.reshape(-1), dtype=wp.float32, device=device)
    record.height, record.width = radiance.shape[:2]
    record.grid_height, record.grid_width = grid.density.shape
    record.dome_from_world = wp.mat33(dome.dome_from_world.astype(np.float32))
    record.visible = int(dome.visible)
    record.diffuse, record.specular = dome.diffuse, dome.specular
    # A surface sees half the sky, at half its projected area on average.
    record.strength = grid.irradiance / 4.0
    return record


def packing_unit(radiance: np.ndarray) -> float:
    """Radiance of one step at exponent 0, such that the largest mantissa and exponent just hold the peak [nits]."""
    peak = float(radiance.max(initial=0.0))
    return 2.0 ** (np.ceil(np.log2(peak / 511.0)) - 31) if peak > 0.0 else 1.0


def packed(radiance: np.ndarray, unit: float) -> np.ndarray:
    """(H, W) uint32 words of three 9-bit mantissas and a 5-bit exponent.

    A quarter of the memory of floats keeps more of the sky in cache. Values are right to 1/512 of the texel's largest
    channel; the darkest step is 2^-40 of the brightest value.
    """
    steps = radiance / np.float32(unit)
    largest = np.maximum(steps.max(2), 1.0)
    exponent = np.clip(np.ceil(np.log2(largest / 511.0)), 0, 31).astype(np.int32)
    mantissa = np.minimum(np.rint(np.ldexp(steps, -exponent[..., None])), 511).astype(np.uint32)
    return mantissa[..., 0] | mantissa[..., 1] << 9 | mantissa[..., 2] << 18 | exponent.astype(np.uint32) << 27


def resized(radiance: np.ndarray) -> np.ndarray:
    """The sky at the resolution of the grid: averages over cells, or where it is coarser bilinear at their centres."""
    for axis, most in enumerate((GRID_HEIGHT, GRID_WIDTH)):
        count = radiance.shape[axis]
        if count > most:
            radiance = _averaged(radiance, axis, most)
        elif count < most:
            at = (np.arange(most) + 0.5) * (count / most) - 0.5
            first = np.floor(at).astype(int)
            part = np.expand_dims(at - first, [k for k in range(3) if k != axis]).astype(np.float32)
            # Columns go round, rows end at the poles.
            mode = "wrap" if axis == 1 else "clip"
            radiance = np.take(radiance, first, axis, mode=mode) * (1 - part) + part * np.take(
                radiance, first + 1, axis, mode=mode
            )
    return radiance


def _averaged(values: np.ndarray, axis: int, most: int) -> np.ndarray:
    count = values.shape[axis]
    if count % most == 0:
        shape = (*values.shape[:axis], most, count // most, *values.shape[axis + 1 :])
        return values.reshape(shape).mean(axis + 1)
    running = np.insert(np.cumsum(values, axis, dtype=np.float64), 0, 0.0, axis)
    edges = np.linspace(0, count, most + 1)
    below = np.minimum(edges.astype(int), count - 1)
    part = np.expand_dims(edges - below, [k for k in range(3) if k != axis])
    at_edges = np.take(running, below, axis) + part * np.take(values, below, axis)
    return (np.diff(at_edges, axis=axis) * (most / count)).astype(np.float32)
