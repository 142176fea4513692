"""The rays of a tile of pixels of a pinhole camera, for `trace_tile` and `trace_tile_in_instance`."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportGeneralTypeIssues=false, reportInvalidTypeForm=false

from pathlib import Path

import warp as wp

from usdsdg.stage.cameras import pixels
from usdsdg_render.bvh.tile import CORNERS, TILE, TMAX, TMIN, X, Y, Z
from usdsdg_render.kernels.cameras.camera import Ray
from usdsdg_render.scene.structs import Camera

_PIXEL_RAYS = Path(__file__).with_name("pixel_rays.cpp").read_text()


@wp.func_native(f"{{\nconstexpr float PIXEL_CENTER = {float(pixels.PIXEL_CENTER)}f;\n{_PIXEL_RAYS}}}")
def put_pixel_rays(
    camera: Camera, left: int, top: int, needed: wp.uint64, memory: wp.array3d(dtype=wp.float32), tile: int
): ...


@wp.func
def put_corner(camera: Camera, column: int, row: int, memory: wp.array3d(dtype=wp.float32), tile: int, k: int):
    """Put the direction through a corner of the tile into its memory."""
    x = (float(column) - camera.cx) / camera.fx
    y = (camera.cy - float(row)) / camera.fy
    direction = camera.rotation * wp.vec3(x, y, -1.0)
    for i in range(3):
        memory[tile, CORNERS, 3 * k + i] = direction[i]


@wp.func
def put_tile(camera: Camera, left: int, top: int, needed: wp.uint64, memory: wp.array3d(dtype=wp.float32), tile: int):
    """Put the rays of 8 x 8 pixels into the memory of a tile; some may be beyond the image.

    needed: a bit for each pixel, row by row; the rays of the others hit nothing.
    """
    put_pixel_rays(camera, left, top, needed, memory, tile)
    put_corner(camera, left, top, memory, tile, 0)
    put_corner(camera, left + TILE, top, memory, tile, 1)
    put_corner(camera, left + TILE, top + TILE, memory, tile, 2)
    put_corner(camera, left, top + TILE, memory, tile, 3)


@wp.func
def ray_of_tile(camera: Camera, memory: wp.array3d(dtype=wp.float32), tile: int, i: int):
    """Return a ray from the memory of a tile."""
    return Ray(
        origin=camera.origin,
        direction=wp.vec3(memory[tile, X, i], memory[tile, Y, i], memory[tile, Z, i]),
        tmin=memory[tile, TMIN, i],
        tmax=memory[tile, TMAX, i],
    )
