"""The coverage pass on a CPU: a thread fills the words of an instance by tiles of pixels, traced together."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportGeneralTypeIssues=false, reportInvalidTypeForm=false

import warp as wp

from usdsdg_render.bvh.tile import TILE, Masks, hits_and_doubts, lowest_bit, tile_memory, trace_tile_in_instance
from usdsdg_render.kernels.cameras.camera import is_pinhole
from usdsdg_render.kernels.cameras.tile_rays import put_tile
from usdsdg_render.kernels.labels.coverage import (
    LEFT_OUT,
    NOTHING,
    WORD_PIXELS,
    Parts,
    columns_of,
    hits_alone,
    rows_of_part,
)
from usdsdg_render.kernels.labels.label_tiles import TILES
from usdsdg_render.kernels.scene.worlds import in_world
from usdsdg_render.scene.structs import Camera, SceneTables

__all__ = ["fill_words_by_tiles", "tile_memory"]

# So few rays take less time one by one than a tile takes to begin.
FEW_RAYS = wp.constant(4)

Rows = wp.types.vector(length=8, dtype=wp.int32)  # a value for each row of a tile


@wp.func_native(f"""
wp::vec_t<2, wp::uint64> masks;
masks[0] = masks[1] = 0;
for (int r = 0; r < 8; ++r) {{
    const int begin = firsts[r] > left ? firsts[r] : left, end = lasts[r] < left + 8 ? lasts[r] : left + 8;
    if (begin >= end)
        continue;
    const int* const pixels = wp::address(shown, image, top + r, 0);
    for (int x = begin; x < end; ++x) {{
        const wp::uint64 bit = (wp::uint64)1 << (8 * r + x - left);
        if (pixels[x] == entry)
            masks[0] |= bit;
        else if (pixels[x] != {int(NOTHING)} && pixels[x] != {int(LEFT_OUT)})
            masks[1] |= bit;
    }}
}}
return masks;
""")
def seen_and_needed(
    shown: wp.array3d(dtype=wp.int32), image: int, left: int, top: int, firsts: Rows, lasts: Rows, entry: int
) -> Masks:
    """Return two masks of the pixels of a tile: those that show an entry, and those that may show it if it is alone."""


@wp.kernel(enable_backward=False, module=TILES)
def fill_words_by_tiles(
    tables: SceneTables,
    cameras: wp.array(dtype=Camera),
    mode: int,
    shown: wp.array3d(dtype=wp.int32),  # instance of each pixel
    tested: wp.array(dtype=wp.int32),  # instances
    all_bounds: wp.array3d(dtype=wp.float32),  # (views, tested, sides)
    counts: wp.array3d(dtype=wp.int32),  # (views, tested, parts): words in each part of the rows
    after: wp.array3d(dtype=wp.int32),  # running sums of counts
    memory: wp.array3d(dtype=wp.float32),  # of tiles, one for each launch, which is of one thread
    units_at_once: int,  # at least
    first_unit: int,
    # out: the bytes of each word, one bit per pixel; zero before
    covered: wp.array2d(dtype=wp.uint8),
    visible: wp.array2d(dtype=wp.uint8),
):
    unit = wp.tid() + first_unit
    tile = first_unit / units_at_once
    parts = counts.shape[2]
    part = unit % parts
    k = unit / parts % counts.shape[1]
    v = unit / parts / counts.shape[1]
    if counts[v, k, part] == 0:
        return
    word = after[v, k, part] - counts[v, k, part]
    camera = cameras[v]
    tables = in_world(tables, camera.world)
    bounds = all_bounds[v, k]
    width = shown.shape[2]
    entry = tested[k]
    instance = tables.first_instance + entry
    by_tiles = is_pinhole(camera) and tables.tlas.instances[instance].cutout == 0
    forward = camera.rotation * wp.vec3(0.0, 0.0, -1.0)
    begin, end = rows_of_part(bounds, shown.shape[1], part, parts)
    for top in range(begin, end, TILE):
        firsts = Rows()
        lasts = Rows()
        words = Rows()
        left = int(width)
        right = int(0)
        for r in range(TILE):
            first, last = int(0), int(0)
            if top + r < end:
                first, last = columns_of(bounds, top + r, width)
            words[r] = word - first / WORD_PIXELS
            firsts[r] = first
            lasts[r] = last
            if first < last:
                word += (last - 1) / WORD_PIXELS - first / WORD_PIXELS + 1
                left = wp.min(left, first)
                right = wp.max(right, last)
        for x in range(left / TILE * TILE, right, TILE):
            masks = seen_and_needed(shown, v, x, top, firsts, lasts, entry)
            met = masks[0]
            needed = masks[1]
            if by_tiles and int(wp.bit_count(needed)) > FEW_RAYS:
                put_tile(camera, x, top, needed, memory, tile)
                trace_tile_in_instance(tables.tlas, camera.origin, forward, memory, tile, instance)
                traced = hits_and_doubts(memory, tile)
                met = met | traced[0]
                needed = needed & traced[1] & ~traced[0]
            while needed != wp.uint64(0):
                i = lowest_bit(needed)
                needed = needed & (needed - wp.uint64(1))
                if hits_alone(tables, Parts(), camera, x + i % TILE, top + i / TILE, entry, mode):
                    met = met | (wp.uint64(1) << wp.uint64(i))
            if met != wp.uint64(0):
                byte = x % WORD_PIXELS / TILE
                for r in range(TILE):
                    if wp.max(firsts[r], x) < wp.min(lasts[r], x + TILE):
                        s = words[r] + x / WORD_PIXELS
                        covered[s, byte] = wp.uint8((met >> wp.uint64(TILE * r)) & wp.uint64(255))
                        visible[s, byte] = wp.uint8((masks[0] >> wp.uint64(TILE * r)) & wp.uint64(255))
