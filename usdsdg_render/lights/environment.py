"""The dome light's picture, and the density from which directions towards it are drawn."""

from __future__ import annotations

import weakref
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from usdsdg.stage.colors import LUMINANCE
from usdsdg_render.scene import structs
from usdsdg_render.scene.scene import Dome

# Cells of the coarse sky: half a megabyte stays in a core's cache.
GRID_HEIGHT, GRID_WIDTH = 256, 512
_TEXELS_AT_ONCE = 1 << 14  # what stays in a cache


class SkyGrid(NamedTuple):
    """A sky of constant cells, and running sums to draw cells by the light that comes from them."""

    irradiance: float  # luminance times solid angle, over the whole sky
    density: np.ndarray  # (H, W) float32 per steradian
    row_cdf: np.ndarray  # (H + 1,) float32
    cell_cdf: np.ndarray  # (H, W + 1) float32


def sampled(radiance: np.ndarray) -> SkyGrid:
    """How to draw from a sky of cells, (H, W, 3) [nits]; a black one is drawn from uniformly, with no weight."""
    luminance = radiance.astype(np.float64) @ LUMINANCE
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


class _Picture:
    """A picture on the device, and what light is drawn from in the colour that it had last."""

    def __init__(self, picture: np.ndarray, device: str) -> None:
        self.device = device
        radiance = picture.astype(np.float32, copy=False)
        if not (radiance.min(initial=0.0) >= 0.0 and radiance.max(initial=0.0) < np.inf):
            radiance = np.maximum(np.nan_to_num(radiance, posinf=0.0), 0.0)
        self.unit = packing_unit(radiance)
        self.texels = self._array(packed(radiance, self.unit), wp.uint32)
        self.cells = resized(radiance)
        self._words = packed(self.cells, self.unit)
        self._tint = np.zeros(3)

    def draw_by(self, tint: np.ndarray) -> None:
        """Make the tables that light is drawn by, for a sky of that colour."""
        if np.array_equal(self._tint, tint):
            return
        self._tint = tint
        grid = sampled(self.cells * tint.astype(np.float32))
        words = np.stack([self._words, grid.density.view(np.uint32)], -1)
        self.irradiance = grid.irradiance
        self.grid = self._array(words, wp.uint32)
        self.row_cdf, self.cell_cdf = self._array(grid.row_cdf, wp.float32), self._array(grid.cell_cdf, wp.float32)

    def _array(self, values: np.ndarray, dtype: Any) -> wp.array:
        """Values that nobody else writes, on the device."""
        return wp.array(values.reshape(-1), dtype=dtype, device=self.device, copy=self.device != "cpu")


class SkyMemory:
    """Pictures of domes on the device, up to KEPT_BYTES of them for as long as somebody else holds them too."""

    KEPT_BYTES = 1 << 28

    def __init__(self, device: str) -> None:
        self.device = device
        self._pictures: dict[int, tuple[weakref.ref[np.ndarray], _Picture]] = {}  # the last used is the last

    def upload(self, dome: Dome | None) -> structs.Dome:
        """The kernels' record of a dome."""
        record = structs.Dome()
        record.dome_from_world = wp.mat33(np.eye(3))
        if dome is None:
            return record
        sky = self._picture(dome.picture)
        color = np.array(dome.color, np.float64)
        brightness = color.max() or 1.0
        sky.draw_by(color / brightness)
        record.unit = wp.vec3(*(sky.unit * color))
        record.texels, record.cells, record.row_cdf, record.cell_cdf = sky.texels, sky.grid, sky.row_cdf, sky.cell_cdf
        record.height, record.width = dome.picture.shape[:2]
        record.grid_height, record.grid_width = sky.cells.shape[:2]
        record.dome_from_world = wp.mat33(dome.dome_from_world.astype(np.float32))
        record.visible = int(dome.visible)
        record.diffuse, record.specular = dome.diffuse, dome.specular
        # A surface sees half the sky, at half its projected area on average.
        record.strength = sky.irradiance * brightness / 4.0
        return record

    def _picture(self, picture: np.ndarray) -> _Picture:
        self._pictures = {key: held for key, held in self._pictures.items() if held[0]() is not None}
        held = self._pictures.pop(id(picture), None) or (weakref.ref(picture), _Picture(picture, self.device))
        self._pictures[id(picture)] = held
        while (
            len(self._pictures) > 1
            and sum(each.texels.size for _, each in self._pictures.values()) > self.KEPT_BYTES // 4
        ):
            del self._pictures[next(iter(self._pictures))]
        return held[1]


def packing_unit(radiance: np.ndarray) -> float:
    """Radiance of one step at exponent 0, such that the largest mantissa and exponent just hold the peak [nits]."""
    peak = float(radiance.max(initial=0.0))
    return 2.0 ** (np.ceil(np.log2(peak / 511.0)) - 31) if peak > 0.0 else 1.0


def packed(radiance: np.ndarray, unit: float) -> np.ndarray:
    """(H, W) uint32 words of three 9-bit mantissas and a 5-bit exponent.

    A quarter of the memory of floats keeps more of the sky in cache. Values are right to 1/512 of the texel's largest
    channel; the darkest step is 2^-40 of the brightest value.
    """
    height, width = radiance.shape[:2]
    words = np.empty((height, width), np.uint32)
    rows = max(1, _TEXELS_AT_ONCE // width)
    for first in range(0, height, rows):
        words[first : first + rows] = _packed(radiance[first : first + rows], unit)
    return words


def _packed(radiance: np.ndarray, unit: float) -> np.ndarray:
    steps = [radiance[..., channel] * np.float32(1.0 / unit) for channel in range(3)]
    # Limits are whole arrays: NumPy finds the lesser of two arrays four times as fast as that of one and a number.
    limit = np.full(steps[0].shape, 511.0, np.float32)
    largest = np.maximum(np.maximum(*steps[:2]), np.maximum(steps[2], limit))
    # ceil(log2) from the bits of a float: its exponent, one more where its mantissa is not zero.
    exponent = ((largest / limit).view(np.int32) - 1 >> 23) - 126
    exponent = np.minimum(exponent, np.full_like(exponent, 31))
    power = (127 - exponent << 23).view(np.float32)
    words = exponent << 27
    for channel, values in enumerate(steps):
        words |= np.minimum(np.rint(values * power), limit).astype(np.int32) << 9 * channel
    return words.view(np.uint32)


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
        before = (slice(None),) * axis
        first, second, *others = (values[*before, k :: count // most] for k in range(count // most))
        mean = first + second
        for each in others:
            mean += each
        mean /= np.float32(2 + len(others))
        return mean
    running = np.insert(np.cumsum(values, axis, dtype=np.float64), 0, 0.0, axis)
    edges = np.linspace(0, count, most + 1)
    below = np.minimum(edges.astype(int), count - 1)
    part = np.expand_dims(edges - below, [k for k in range(3) if k != axis])
    at_edges = np.take(running, below, axis) + part * np.take(values, below, axis)
    return (np.diff(at_edges, axis=axis) * (most / count)).astype(np.float32)
