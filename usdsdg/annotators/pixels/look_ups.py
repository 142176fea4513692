"""Images made by looking pixels up by the gprim that they show, and what all annotators share of the gprims.

Tables have an entry for each gprim and a last one for pixels that show none.
"""

from collections.abc import Mapping

import numpy as np

from usdsdg.annotators.pixels.launch import band_of, run

# Columns of sums.
PIXELS, X_MIN, Y_MIN, X_MAX, Y_MAX = range(5)
# Initial sums, of no pixels.
_NONE = np.array([0, 1 << 30, 1 << 30, -1, -1], np.int32)
# Pixels of a row whose runs a thread of a GPU goes through.
_RUN_PIXELS = 64


def look_up(instance: np.ndarray, table: np.ndarray) -> np.ndarray:
    """Return the table's value of each pixel, (H, W, *channels), of an item of 4 or 8 bytes."""
    from usdsdg.annotators.pixels import look_up_kernels as kernels  # imports Warp

    table = np.ascontiguousarray(table)
    size = table.nbytes // len(table)
    kernel, item = (kernels.look_up, np.uint32) if size == 4 else (kernels.look_up_wide, np.uint64)
    values = np.empty(instance.shape, item)
    run(kernel, (instance.size,), [instance, table.reshape(-1).view(item)], [values])
    return values.view(table.dtype).reshape(*instance.shape, *table.shape[1:])


def sum_by_gprim(instance: np.ndarray, gprims: int) -> np.ndarray:
    """Return pixels and bounds of each gprim, (G, 5) int64: pixels, x_min, y_min, x_max, y_max (inclusive), or -1."""
    from usdsdg.annotators.pixels import look_up_kernels as kernels

    height, width = instance.shape
    rows = band_of(height, width)
    sums = np.tile(_NONE, (max(-(-height // rows), 1), gprims, 1))
    parts = -(-width // _RUN_PIXELS)
    run(kernels.sum_runs, (height, parts), [instance, _RUN_PIXELS, rows], [sums], band=rows)
    found = np.empty((gprims, 5), np.int64)
    found[:, PIXELS] = sums[..., PIXELS].sum(axis=0)
    found[:, X_MIN:X_MAX] = sums[..., X_MIN:X_MAX].min(axis=0)
    found[:, X_MAX:] = sums[..., X_MAX:].max(axis=0)
    found[found[:, PIXELS] == 0, X_MIN:] = -1
    return found


def shade(
    instance: np.ndarray, normals: np.ndarray, colors: np.ndarray, light: np.ndarray, darkest: float
) -> np.ndarray:
    """Return colors of a table (0 to 255) shaded by a light, uint8 (H, W, 3).

    normals: (H, W, 3). light: unit vector towards it. darkest: brightness of surfaces that face away from it.
    """
    from usdsdg.annotators.pixels import look_up_kernels as kernels

    image = np.empty((*instance.shape, 3), np.uint8)
    inputs = [instance, normals, colors.astype(np.float32), kernels.wp.vec3(*light.tolist()), darkest]
    run(kernels.shade, (instance.size,), inputs, [image])
    return image


def gather_points(
    instance: np.ndarray, is_kept: np.ndarray, tables: Mapping[str, np.ndarray], images: Mapping[str, np.ndarray]
) -> tuple[np.ndarray, ...]:
    """Return position, normal, color, class and id of the pixels whose gprims are kept, row by row.

    is_kept: bool table. tables: "classes" and "ids". images: the AOVs position, normals and LdrColor.
    """
    from usdsdg.annotators.pixels import look_up_kernels as kernels

    height, width = instance.shape
    kept, counts = is_kept.astype(np.int32), np.zeros(height, np.int32)
    band = band_of(height, width)
    run(kernels.count_kept, (height,), [instance, kept], [counts], band=band)
    ends = np.cumsum(counts)
    count = int(ends[-1]) if height else 0
    kinds = ((3, np.float32), (4, np.float32), (4, np.uint8))
    found = (*(np.empty((count, size), kind) for size, kind in kinds), *(np.empty(count, np.uint32) for _ in range(2)))
    ids = [tables[name].astype(np.uint32) for name in ("classes", "ids")]
    floats = [images[name].astype(np.float32, copy=False) for name in ("position", "normals")]
    starts = (ends - counts).astype(np.int32)
    run(kernels.gather_points, (height,), [instance, kept, *ids, *floats, images["LdrColor"], starts], found, band=band)
    return found


def map_points(instance: np.ndarray, points: np.ndarray, matrices: np.ndarray, is_mapped: np.ndarray) -> np.ndarray:
    """Return points (H, W, 3) under the matrices of their gprims, within 0 to 1, and 1, float32 (H, W, 4); else 0.

    matrices: (G, 4, 4) for row vectors. is_mapped: (G,) bool, of which gprims points are mapped.
    """
    from usdsdg.annotators.pixels import look_up_kernels as kernels

    mapped = np.empty((*instance.shape, 4), np.float32)
    linear = np.ascontiguousarray(matrices[:, :3, :3].transpose(0, 2, 1), np.float32)
    inputs = [instance, points, linear, matrices[:, 3, :3].astype(np.float32), is_mapped.astype(np.int32)]
    run(kernels.map_points, (instance.size,), inputs, [mapped])
    return mapped
