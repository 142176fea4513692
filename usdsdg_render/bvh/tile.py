"""The closest hits of the rays of a tile of pixels, on a CPU: the tree is traversed once for all of them."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportInvalidTypeForm=false

from pathlib import Path

import numpy as np
import warp as wp

from usdsdg_render.bvh.query import STACK_SIZE
from usdsdg_render.memory.staging_buffer import aligned, shared
from usdsdg_render.scene.structs import Hit, Tlas

TILE = wp.constant(8)  # pixels of a side
RAYS = wp.constant(TILE * TILE)
# Values of a ray in the memory of a tile, and where the directions through its corners are.
X, Y, Z, TMIN, TMAX, T, U, V, INSTANCE, TRIANGLE, UNDECIDED, CORNERS = (wp.constant(k) for k in range(12))
_VALUES = 12

_TILE = Path(__file__).with_name("tile.cpp").read_text()


def _snippet(*, one_instance: bool) -> str:
    flags = f"constexpr bool ONE_INSTANCE = {str(one_instance).lower()}, BY_COLUMNS = ONE_INSTANCE;\n"
    flags += "" if one_instance else "constexpr int only_instance = 0, rows = 8;\n"
    return f"{{\nconstexpr int STACK_SIZE = {STACK_SIZE};\n{flags}{_TILE}}}"


@wp.func_native(_snippet(one_instance=False))
def trace_tile(
    tlas: Tlas,
    origin: wp.vec3,
    forward: wp.vec3,  # unit vector along the camera's axis
    memory: wp.array3d(dtype=wp.float32),  # see `tile_memory`: rays in rows of eight pixels
    tile: int,
): ...


@wp.func_native(_snippet(one_instance=True))
def trace_columns_in_instance(
    tlas: Tlas,
    origin: wp.vec3,
    forward: wp.vec3,
    memory: wp.array3d(dtype=wp.float32),  # of a tile of columns
    tile: int,
    rows: int,  # of eight columns
    only_instance: int,
): ...


def tile_memory(tiles: int) -> wp.array:
    """Make memory for tiles that are traced at the same time, (tiles, values, RAYS) float32, aligned for SIMD."""
    return shared(aligned((tiles, _VALUES, RAYS), np.float32), wp.float32)


@wp.func
def hit_in_tile(memory: wp.array3d(dtype=wp.float32), tile: int, ray: int):
    """Return what `trace_tile` has found for a ray."""
    return Hit(
        t=memory[tile, T, ray],
        u=memory[tile, U, ray],
        v=memory[tile, V, ray],
        instance=wp.cast(memory[tile, INSTANCE, ray], wp.int32),
        triangle=wp.cast(memory[tile, TRIANGLE, ray], wp.int32),
    )
