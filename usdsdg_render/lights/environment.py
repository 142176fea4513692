"""Environment map of the dome light on the device: packed texels, and a coarse grid for importance sampling."""

import weakref
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from usdsdg.stage.colors import LUMINANCE
from usdsdg_render.scene import structs
from usdsdg_render.scene.scene import Dome

# Cells of the sampling grid: half a megabyte stays in a core's cache.
GRID_HEIGHT, GRID_WIDTH = 256, 512
_CHUNK_TEXELS = 1 << 14  # fits in a cache


class EnvironmentDistribution(NamedTuple):
    """Importance sampling of an environment of constant cells: pdf and CDFs by luminance."""

    irradiance: float  # luminance times solid angle, over the sphere
    pdf: np.ndarray  # (H, W) float32 [1/sr]
    row_cdf: np.ndarray  # (H + 1,) float32
    cell_cdf: np.ndarray  # (H, W + 1) float32


def distribution_of(radiance: np.ndarray) -> EnvironmentDistribution:
    """Build the distribution of (H, W, 3) cell radiance [nits]; a black environment is sampled uniformly."""
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
    pdf = (mass / total / solid_angle).astype(np.float32)
    return EnvironmentDistribution(irradiance, pdf, row_cdf.astype(np.float32), cell_cdf.astype(np.float32))


class _DeviceMap:
    """One texture on the device, and its sampling distribution for the last tint."""

    def __init__(self, texture: np.ndarray, device: str) -> None:
        self.device = device
        radiance = texture.astype(np.float32, copy=False)
        if not (radiance.min(initial=0.0) >= 0.0 and radiance.max(initial=0.0) < np.inf):
            radiance = np.maximum(np.nan_to_num(radiance, posinf=0.0), 0.0)
        self.unit = packing_unit(radiance)
        self.texels = self._array(packed(radiance, self.unit), wp.uint32)
        self.cells = to_grid(radiance)
        self._packed_cells = packed(self.cells, self.unit)
        self.tint = np.zeros(3)
        self._channels: np.ndarray | None = None

    @property
    def channels(self) -> np.ndarray:
        """(3,) mean of each channel over the sphere, times the solid angle of the sphere."""
        known = self._channels
        if known is None:
            edges = np.cos(np.pi * np.arange(len(self.cells) + 1) / len(self.cells))
            solid_angle = (edges[:-1] - edges[1:]) * (2 * np.pi / self.cells.shape[1])
            known = self._channels = np.asarray(self.cells.sum(1, dtype=np.float64).T @ solid_angle)
        return known

    def set_tint(self, tint: np.ndarray) -> None:
        """Build the sampling distribution for a tint of the texture."""
        if np.array_equal(self.tint, tint):
            return
        self.tint = tint
        grid = distribution_of(self.cells * tint.astype(np.float32))
        words = np.stack([self._packed_cells, grid.pdf.view(np.uint32)], -1)
        self.irradiance = grid.irradiance
        self.grid = self._array(words, wp.uint32)
        self.row_cdf, self.cell_cdf = self._array(grid.row_cdf, wp.float32), self._array(grid.cell_cdf, wp.float32)

    def _array(self, values: np.ndarray, dtype: Any) -> wp.array:
        """Copy values to the device; on a CPU wrap their memory without a copy: kernels only read it."""
        return wp.array(values.reshape(-1), dtype=dtype, device=self.device, copy=self.device != "cpu")


class EnvironmentMaps:
    """Cache of dome textures on the device: up to KEPT_BYTES, as long as the host arrays are alive."""

    KEPT_BYTES = 1 << 28

    def __init__(self, device: str) -> None:
        self.device = device
        self._maps: dict[int, tuple[weakref.ref[np.ndarray], _DeviceMap]] = {}  # in order of last use

    def upload(self, dome: Dome | None) -> structs.Dome:
        """Upload a dome and return its record for kernels."""
        record = structs.Dome()
        record.dome_from_world = wp.mat33(np.eye(3))
        if dome is None:
            return record
        environment = self._map_of(dome.texture)
        color = np.array(dome.color, np.float64)
        brightness = color.max() or 1.0
        environment.set_tint(color / brightness)
        record.unit = wp.vec3(*(environment.unit * color))
        record.texels, record.cells = environment.texels, environment.grid
        record.row_cdf, record.cell_cdf = environment.row_cdf, environment.cell_cdf
        record.height, record.width = dome.texture.shape[:2]
        record.grid_height, record.grid_width = environment.cells.shape[:2]
        record.dome_from_world = wp.mat33(dome.dome_from_world.astype(np.float32))
        record.visible = int(dome.visible)
        record.diffuse, record.specular = dome.diffuse, dome.specular
        # A surface sees half of the sphere, with a mean cosine of one half.
        record.strength = environment.irradiance * brightness / 4.0
        return record

    def light_of(self, dome: Dome | None, colors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return `Dome.unit` (N, 3) and `Dome.strength` (N,) of an uploaded dome for (N, 3) colors of it.

        All are sampled as the dome's own color is.
        """
        if dome is None:
            return np.zeros((len(colors), 3)), np.zeros(len(colors))
        environment = self._map_of(dome.texture)
        brightness = np.where(colors.max(1) > 0.0, colors.max(1), 1.0)
        tints = colors / brightness[:, None]
        own = environment.tint
        weights = environment.channels * LUMINANCE
        strength = environment.irradiance * brightness / 4.0
        if (other := np.abs(tints - own).max(1) > 1e-9).any():
            strength[other] = (tints[other] @ weights) * brightness[other] / 4.0
        return environment.unit * colors, strength

    def _map_of(self, texture: np.ndarray) -> _DeviceMap:
        self._maps = {key: held for key, held in self._maps.items() if held[0]() is not None}
        held = self._maps.pop(id(texture), None) or (weakref.ref(texture), _DeviceMap(texture, self.device))
        self._maps[id(texture)] = held
        while len(self._maps) > 1 and sum(each.texels.size for _, each in self._maps.values()) > self.KEPT_BYTES // 4:
            del self._maps[next(iter(self._maps))]
        return held[1]


def packing_unit(radiance: np.ndarray) -> float:
    """Return the radiance of one step at exponent 0 [nits], such that the peak just fits the packed format."""
    peak = float(radiance.max(initial=0.0))
    return 2.0 ** (np.ceil(np.log2(peak / 511.0)) - 31) if peak > 0.0 else 1.0


def packed(radiance: np.ndarray, unit: float) -> np.ndarray:
    """Pack radiance to (H, W) uint32 words of three 9-bit mantissas and a shared 5-bit exponent.

    A quarter of the memory of floats keeps more of the map in cache. Values are accurate to 1/512 of the texel's
    largest channel; the darkest step is 2^-40 of the brightest value.
    """
    height, width = radiance.shape[:2]
    words = np.empty((height, width), np.uint32)
    rows = max(1, _CHUNK_TEXELS // width)
    for first in range(0, height, rows):
        words[first : first + rows] = _packed(radiance[first : first + rows], unit)
    return words


def _packed(radiance: np.ndarray, unit: float) -> np.ndarray:
    steps = [radiance[..., channel] * np.float32(1.0 / unit) for channel in range(3)]
    # Limits are whole arrays: NumPy's minimum of two arrays is four times as fast as of an array and a scalar.
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


def to_grid(radiance: np.ndarray) -> np.ndarray:
    """Resample the map to the grid: box filter where it is finer, bilinear where it is coarser."""
    for axis, size in enumerate((GRID_HEIGHT, GRID_WIDTH)):
        count = radiance.shape[axis]
        if count > size:
            radiance = _box_filtered(radiance, axis, size)
        elif count < size:
            at = (np.arange(size) + 0.5) * (count / size) - 0.5
            first = np.floor(at).astype(int)
            fraction = np.expand_dims(at - first, [k for k in range(3) if k != axis]).astype(np.float32)
            # Columns wrap around, rows end at the poles.
            mode = "wrap" if axis == 1 else "clip"
            radiance = np.take(radiance, first, axis, mode=mode) * (1 - fraction) + fraction * np.take(
                radiance, first + 1, axis, mode=mode
            )
    return radiance


def _box_filtered(values: np.ndarray, axis: int, size: int) -> np.ndarray:
    count = values.shape[axis]
    if count % size == 0:
        before = (slice(None),) * axis
        first, second, *others = (values[*before, k :: count // size] for k in range(count // size))
        mean = first + second
        for each in others:
            mean += each
        mean /= np.float32(2 + len(others))
        return mean
    running = np.insert(np.cumsum(values, axis, dtype=np.float64), 0, 0.0, axis)
    edges = np.linspace(0, count, size + 1)
    below = np.minimum(edges.astype(int), count - 1)
    fraction = np.expand_dims(edges - below, [k for k in range(3) if k != axis])
    at_edges = np.take(running, below, axis) + fraction * np.take(values, below, axis)
    return (np.diff(at_edges, axis=axis) * (size / count)).astype(np.float32)
