"""Images made by looking pixels up by the gprim that they show, and what all annotators share of the gprims.

Tables have an entry for each gprim and a last one for pixels that show none. Results are where the AOV `instance` is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from usdsdg.annotators.pixels.launch import (
    Pixels,
    band_of,
    in_a_row,
    new,
    on_host,
    pieces,
    placed,
    run,
    run_over_pixels,
)
from usdsdg.annotators.pixels.look_up_table import LookUpTable

# Columns of sums.
PIXELS, X_MIN, Y_MIN, X_MAX, Y_MAX = range(5)
# Initial sums, of no pixels.
_NONE = np.array([0, 1 << 30, 1 << 30, -1, -1], np.int32)
# Pixels of a row that a thread of a GPU goes through.
_PART_PIXELS = 64


def look_up(instance: Pixels, table: LookUpTable) -> Pixels:
    """Return the table's value of each pixel, (H, W, *channels); entries have 4 bytes or a multiple."""
    from usdsdg.annotators.pixels import look_up_kernels as kernels  # imports Warp

    values = new((*instance.shape, *table.values.shape[1:]), table.values.dtype, instance)
    run_over_pixels(kernels.look_up, instance.size, [instance, table.on(instance), table.words], [_words(values)])
    return values


def look_up_all(instances: Sequence[Pixels], table: LookUpTable) -> list[Pixels]:
    """Return `look_up` of images of one size; those of a GPU that lie one after the other take one launch."""
    if len(instances) == 1 or (whole := in_a_row(instances)) is None:
        return [look_up(each, table) for each in instances]
    return pieces(look_up(whole, table), len(instances))


def sum_by_gprim(instance: Pixels, gprims: int) -> np.ndarray:
    """Return pixels and bounds of each gprim, (G, 5) int64: pixels, x_min, y_min, x_max, y_max (inclusive), or -1."""
    from usdsdg.annotators.pixels import look_up_kernels as kernels

    height, width = instance.shape
    rows = band_of(height, width)
    sums = placed(np.tile(_NONE, (max(-(-height // rows), 1), gprims, 1)), instance)
    run(kernels.sum_runs, (height, _parts(width)), [instance, _PART_PIXELS, rows], [sums], band=rows)
    sums = on_host(sums)
    found = np.empty((gprims, 5), np.int64)
    found[:, PIXELS] = sums[..., PIXELS].sum(axis=0)
    found[:, X_MIN:X_MAX] = sums[..., X_MIN:X_MAX].min(axis=0)
    found[:, X_MAX:] = sums[..., X_MAX:].max(axis=0)
    found[found[:, PIXELS] == 0, X_MIN:] = -1
    return found


def sum_all_by_gprim(instances: Sequence[Pixels], gprims: int) -> list[np.ndarray]:
    """Return `sum_by_gprim` of images of one size; those of a GPU that lie one after the other take one launch."""
    from usdsdg.annotators.pixels import look_up_kernels as kernels

    if len(instances) == 1 or (whole := in_a_row(instances)) is None:
        return [sum_by_gprim(each, gprims) for each in instances]
    height, width = instances[0].shape
    table = placed(np.tile(_NONE, (len(instances), gprims, 1)), whole)
    rows = len(instances) * height
    run(kernels.sum_runs, (rows, _parts(width)), [whole, _PART_PIXELS, height], [table], band=rows)
    found = on_host(table).astype(np.int64)
    # Rows were counted through all images.
    found[..., [Y_MIN, Y_MAX]] -= height * np.arange(len(instances))[:, None, None]
    found[found[..., PIXELS] == 0, X_MIN:] = -1
    return list(found)


def shade(instance: Pixels, normals: Pixels, colors: np.ndarray, light: np.ndarray, darkest: float) -> Pixels:
    """Return colors of a table (0 to 255) shaded by a light, uint8 (H, W, 3).

    normals: (H, W, 3). light: unit vector toward it. darkest: brightness of surfaces that face away from it.
    """
    from usdsdg.annotators.pixels import look_up_kernels as kernels

    image = new((*instance.shape, 3), np.uint8, instance)
    inputs = [instance, normals, colors.astype(np.float32), kernels.wp.vec3(*light.tolist()), darkest]
    run_over_pixels(kernels.shade, instance.size, inputs, [image])
    return image


def gather_points(
    instance: Pixels, is_kept: np.ndarray, tables: Mapping[str, np.ndarray], images: Mapping[str, Pixels]
) -> tuple[Pixels, ...]:
    """Return position, normal, color, class and id of the pixels whose gprims are kept, row by row.

    is_kept: bool table. tables: "classes" and "ids". images: the AOVs position, normals and LdrColor.
    """
    from usdsdg.annotators.pixels import point_kernels as kernels

    height, width = instance.shape
    shape, kept = (height, _parts(width)), is_kept.astype(np.int32)
    counts = new(shape, np.int32, instance)
    run(kernels.count_kept, shape, [instance, kept, _PART_PIXELS], [counts], band=band_of(height, width))
    counts = on_host(counts)
    ends = np.cumsum(counts, dtype=np.int32).reshape(shape)
    count = int(ends[-1, -1]) if ends.size else 0
    kinds = (((3,), np.float32), ((4,), np.float32), ((4,), np.uint8), ((), np.uint32), ((), np.uint32))
    # Of the size of the picture, so that the memory fits the next one.
    found = [new((height * width, *channels), kind, instance) for channels, kind in kinds]
    ids = [tables[name].astype(np.uint32) for name in ("classes", "ids")]
    inputs = [instance, kept, *ids, images["position"], images["normals"], images["LdrColor"], ends - counts]
    run(kernels.gather_points, shape, [*inputs, _PART_PIXELS], found, band=band_of(height, width))
    return tuple(each[:count] for each in found)


def map_points(instance: Pixels, points: Pixels, matrices: np.ndarray, is_mapped: np.ndarray) -> Pixels:
    """Return points (H, W, 3) under the matrices of their gprims, within 0 to 1, and 1, float32 (H, W, 4); else 0.

    matrices: (G, 4, 4) for row vectors. is_mapped: (G,) bool, of which gprims points are mapped.
    """
    from usdsdg.annotators.pixels import point_kernels as kernels

    mapped = new((*instance.shape, 4), np.float32, instance)
    linear = np.ascontiguousarray(matrices[:, :3, :3].transpose(0, 2, 1), np.float32)
    inputs = [instance, points, linear, matrices[:, 3, :3].astype(np.float32), is_mapped.astype(np.int32)]
    run_over_pixels(kernels.map_points, instance.size, inputs, [mapped])
    return mapped


def _words(values: Pixels) -> Pixels:
    """Return values as words of 4 bytes; those on a device are viewed as what a kernel takes."""
    return values.reshape(-1).view(np.uint32) if isinstance(values, np.ndarray) else values


def _parts(width: int) -> int:
    return -(-width // _PART_PIXELS)
