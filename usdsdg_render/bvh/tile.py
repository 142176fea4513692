"""The closest hits of the rays of a tile of pixels, on a CPU: the tree is traversed once for all of them."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportInvalidTypeForm=false, reportReturnType=false

from pathlib import Path

import numpy as np
import warp as wp

from usdsdg.stage.cameras.pixels import PIXEL_CENTER
from usdsdg_render.bvh.query import STACK_SIZE
from usdsdg_render.memory.staging_buffer import aligned, shared
from usdsdg_render.scene.structs import Hit, Tlas

TILE = wp.constant(8)  # pixels of a side
RAYS = wp.constant(TILE * TILE)
# Values of a ray in the memory of a tile, and where the directions through its corners are.
X, Y, Z, TMIN, TMAX, T, U, V, INSTANCE, TRIANGLE, UNDECIDED, CORNERS = (wp.constant(k) for k in range(12))
_VALUES = 12
Masks = wp.types.vector(length=2, dtype=wp.uint64)  # a bit for each ray of a tile, row by row

_TILE = Path(__file__).with_name("tile.cpp").read_text()


def _snippet(*, one_instance: bool) -> str:
    flags = f"constexpr bool ONE_INSTANCE = {str(one_instance).lower()};\n"
    flags += "" if one_instance else "constexpr int only_instance = 0;\n"
    flags += f"constexpr int STACK_SIZE = {STACK_SIZE};\nconstexpr float PIXEL_CENTER = {float(PIXEL_CENTER)}f;\n"
    return f"{{\n{flags}{_TILE}}}"


@wp.func_native(_snippet(one_instance=False))
def trace_tile(
    tlas: Tlas,
    origin: wp.vec3,
    forward: wp.vec3,  # unit vector along the camera's axis
    memory: wp.array3d(dtype=wp.float32),  # see `tile_memory`: rays in rows of eight pixels
    tile: int,
): ...


@wp.func_native(_snippet(one_instance=True))
def trace_tile_in_instance(
    tlas: Tlas,
    origin: wp.vec3,
    forward: wp.vec3,
    memory: wp.array3d(dtype=wp.float32),
    tile: int,
    only_instance: int,
): ...


def tile_memory(tiles: int) -> wp.array:
    """Make memory for tiles that are traced at the same time, (tiles, values, RAYS) float32, aligned for SIMD."""
    return shared(aligned((tiles, _VALUES, RAYS), np.float32), wp.float32)


_MASKS_OF_TILE = f"""
typedef int int8 __attribute__((ext_vector_type(8)));
typedef bool bool8 __attribute__((ext_vector_type(8)));
const int8* const words = (const int8*)((const char*)memory.data + (size_t)tile * memory.strides[0]);
wp::vec_t<2, wp::uint64> masks;
masks[0] = masks[1] = 0;
for (int g = 0; g < 8; ++g) {{
    const int8 hits = words[{8 * int(INSTANCE)} + g] >= 0, doubts = words[{8 * int(UNDECIDED)} + g] != 0;
    masks[0] |= (wp::uint64)__builtin_bit_cast(unsigned char, __builtin_convertvector(hits, bool8)) << (8 * g);
    masks[1] |= (wp::uint64)__builtin_bit_cast(unsigned char, __builtin_convertvector(doubts, bool8)) << (8 * g);
}}
return masks;
"""


@wp.func_native(_MASKS_OF_TILE)
def hits_and_doubts(memory: wp.array3d(dtype=wp.float32), tile: int) -> Masks:
    """Return two masks with a bit for each ray of a tile: whether it hits something, and whether it is undecided."""


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


@wp.func
def put_hit(memory: wp.array3d(dtype=wp.float32), tile: int, ray: int, hit: Hit):
    """Set what has been found for a ray."""
    memory[tile, T, ray] = hit.t
    memory[tile, U, ray] = hit.u
    memory[tile, V, ray] = hit.v
    memory[tile, INSTANCE, ray] = wp.cast(hit.instance, wp.float32)
    memory[tile, TRIANGLE, ray] = wp.cast(hit.triangle, wp.float32)


@wp.func_native("return __builtin_ctzll(bits);")
def lowest_bit(bits: wp.uint64) -> int:
    """Return the number of the lowest bit that is set; there must be one."""
