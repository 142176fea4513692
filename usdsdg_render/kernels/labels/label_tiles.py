"""The label pass of cameras without a lens model on a CPU: a thread traces the rays of a tile of pixels together."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportGeneralTypeIssues=false, reportInvalidTypeForm=false

import warp as wp

from usdsdg_render.bvh.tile import (
    INSTANCE,
    TILE,
    Masks,
    hit_in_tile,
    hits_and_doubts,
    lowest_bit,
    put_hit,
    tile_memory,
    trace_tile,
)
from usdsdg_render.kernels.cameras.tile_rays import put_tile, ray_of_tile
from usdsdg_render.kernels.labels.label_kernels import AovImages, write_label
from usdsdg_render.kernels.labels.motion import PreviousFrame
from usdsdg_render.kernels.labels.views import Views
from usdsdg_render.kernels.scene.visibility import closest, opacity_of_hit
from usdsdg_render.kernels.scene.worlds import in_world
from usdsdg_render.scene.structs import SceneTables

__all__ = ["TILE", "label_tiles", "tile_memory"]

TILES = wp.get_module(__name__)


@wp.func
def with_transparent(tables: SceneTables, memory: wp.array3d(dtype=wp.float32), tile: int, traced: Masks, mode: int):
    """Return `hits_and_doubts` with doubts at hits that labels see through."""
    hits = traced[0]
    while hits != wp.uint64(0):
        i = lowest_bit(hits)
        hits = hits & (hits - wp.uint64(1))
        if opacity_of_hit(tables, hit_in_tile(memory, tile, i), mode) < 0.5:
            traced[1] = traced[1] | (wp.uint64(1) << wp.uint64(i))
    return traced


@wp.func_native(f"""
const int* const found = (const int*)((const char*)memory.data + (size_t)tile * memory.strides[0]) + {64 * INSTANCE};
for (int r = 0; r < rows; ++r) {{
    int* const row = (int*)image + (size_t)(top + r) * width + left;
    for (int k = 0; k < 8 && left + k < width; ++k) {{
        const int hit = found[8 * r + k];
        row[k] = hit < 0 ? -1 : hit - first_instance;
    }}
}}
""")
def write_instances(
    memory: wp.array3d(dtype=wp.float32),
    tile: int,
    first_instance: int,
    left: int,
    top: int,
    rows: int,
    width: int,
    image: wp.uint64,  # address of the AOV `instance`
):
    """Write what `write_pixel` writes, for a tile at once."""


@wp.kernel(enable_backward=False, module=TILES)
def label_tiles(
    tables: SceneTables,
    views: Views,
    previous: PreviousFrame,
    meters_per_unit: float,
    asked: int,  # WITH_* of the AOVs
    mode: int,
    memory: wp.array3d(dtype=wp.float32),  # of tiles, one for each band, since a band is of one thread
    first_band: int,
    # out
    out: AovImages,
):
    band, tile = wp.tid()
    band += first_band
    bands = (views.height + TILE - 1) / TILE
    v = band / bands
    left = TILE * tile
    top = TILE * (band - v * bands)
    camera = views.cameras[v]
    tables = in_world(tables, camera.world)
    put_tile(camera, left, top, ~wp.uint64(0), memory, first_band)
    forward = camera.rotation * wp.vec3(0.0, 0.0, -1.0)
    trace_tile(tables.tlas, camera.origin, forward, memory, first_band)
    traced = hits_and_doubts(memory, first_band)
    if tables.cutouts != 0:
        traced = with_transparent(tables, memory, first_band, traced, mode)
    doubts = traced[1]
    while doubts != wp.uint64(0):
        i = lowest_bit(doubts)
        doubts = doubts & (doubts - wp.uint64(1))
        ray = ray_of_tile(camera, memory, first_band, i)
        hit = closest(tables, ray.origin, ray.direction, ray.tmin, ray.tmax, mode, 0.5)
        put_hit(memory, first_band, i, hit)
    rows = wp.min(TILE, views.height - top)
    if asked == 0:
        row = v * views.height + top
        write_instances(memory, first_band, tables.first_instance, left, row, rows, views.width, out.instance)
        return
    for row in range(rows):
        for k in range(wp.min(TILE, views.width - left)):
            i = TILE * row + k
            hit = hit_in_tile(memory, first_band, i)
            ray = ray_of_tile(camera, memory, first_band, i)
            write_label(out, v, top + row, left + k, tables, camera, ray, hit, previous, meters_per_unit, asked)
