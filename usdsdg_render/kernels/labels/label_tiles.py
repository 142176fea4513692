"""The label pass of cameras without a lens model on a CPU: a thread traces the rays of a tile of pixels together."""

import warp as wp

from usdsdg_render.bvh.tile import RAYS, TILE, UNDECIDED, hit_in_tile, tile_memory, trace_tile
from usdsdg_render.kernels.cameras.tile_rays import put_tile, ray_of_tile
from usdsdg_render.kernels.labels.label_kernels import AovImages, write_label
from usdsdg_render.kernels.labels.motion import PreviousFrame
from usdsdg_render.kernels.labels.views import Views
from usdsdg_render.kernels.scene.visibility import closest, opacity_of_hit
from usdsdg_render.kernels.scene.worlds import in_world
from usdsdg_render.scene.structs import SceneTables

__all__ = ["TILE", "label_tiles", "tile_memory"]

TILES = wp.get_module(__name__)


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
    put_tile(camera, left, top, memory, first_band)
    forward = camera.rotation * wp.vec3(0.0, 0.0, -1.0)
    trace_tile(tables.tlas, camera.origin, forward, memory, first_band)
    for i in range(RAYS):
        x = left + i % TILE
        y = top + i / TILE
        if x < views.width and y < views.height:
            ray = ray_of_tile(camera, memory, first_band, i)
            hit = hit_in_tile(memory, first_band, i)
            decided = wp.cast(memory[first_band, UNDECIDED, i], wp.int32) == 0
            if decided and tables.cutouts != 0 and hit.instance >= 0:
                decided = opacity_of_hit(tables, hit, mode) > 0.5
            if not decided:
                hit = closest(tables, ray.origin, ray.direction, ray.tmin, ray.tmax, mode, 0.5)
            write_label(out, v, y, x, tables, camera, ray, hit, previous, meters_per_unit, asked)
