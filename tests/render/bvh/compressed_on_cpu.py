"""The traversal of the CUDA back end, compiled for a CPU with emulated CUDA intrinsics.

It does not test the arithmetic of a GPU, but every operation that decides a hit has the same rounding there.
"""

from __future__ import annotations

import numpy as np
import warp as wp

from usdsdg_render.bvh import acceleration_structure
from usdsdg_render.bvh.compress import NODE_WORDS
from usdsdg_render.bvh.query import _COMPRESSED, CUDA_STACK_SIZE, Packed, flags_of
from usdsdg_render.scene import structs
from usdsdg_render.scene.struct_rows import records

_INTRINSICS = """
#pragma clang fp contract(off)
struct uint4 { unsigned x, y, z, w; };
struct float4 { float x, y, z, w; };
static constexpr auto __fadd_rn = [](float a, float b) { return a + b; };
static constexpr auto __fsub_rn = [](float a, float b) { return a - b; };
static constexpr auto __fmul_rn = [](float a, float b) { return a * b; };
static constexpr auto __fmaf_rn = [](float a, float b, float c) { return __builtin_fmaf(a, b, c); };
static constexpr auto fmaf = [](float a, float b, float c) { return __builtin_fmaf(a, b, c); };
static constexpr auto fabsf = [](float a) { return __builtin_fabsf(a); };
static constexpr auto fminf = [](float a, float b) { return a < b ? a : b; };
static constexpr auto fmaxf = [](float a, float b) { return a > b ? a : b; };
static constexpr auto __clz = [](unsigned a) { return __builtin_clz(a); };
static constexpr auto __popc = [](unsigned a) { return __builtin_popcount(a); };
static constexpr auto __ldg = [](const auto* p) { return *p; };
static constexpr auto __uint_as_float = [](unsigned a) { return __builtin_bit_cast(float, a); };
static constexpr auto __int_as_float = [](int a) { return __builtin_bit_cast(float, a); };
static constexpr auto __vimax3_s32 = [](int a, int b, int c) { return a > b ? (a > c ? a : c) : (b > c ? b : c); };
static constexpr auto __vimin3_s32 = [](int a, int b, int c) { return a < b ? (a < c ? a : c) : (b < c ? b : c); };
static constexpr auto __byte_perm = [](unsigned x, unsigned y, unsigned s) {
    const auto byte = [=](unsigned k) { return (k < 4 ? x >> 8 * k : y >> 8 * (k - 4)) & 255u; };
    return byte(s & 7) | byte(s >> 4 & 7) << 8 | byte(s >> 8 & 7) << 16 | byte(s >> 12 & 7) << 24;
};
static constexpr auto __float_as_int = [](float a) { return __builtin_bit_cast(int, a); };
"""


def _snippet(any_hit: bool) -> str:
    flags = flags_of(any_hit=any_hit, one_instance=False)
    return f"{{{_INTRINSICS}{flags}constexpr int STACK_SIZE = {CUDA_STACK_SIZE};\n{_COMPRESSED}}}"


@wp.func_native(_snippet(any_hit=False))
def _closest(tlas: structs.Tlas, origin: wp.vec3, direction: wp.vec3, tmin: float, tmax: float) -> Packed: ...


@wp.func_native(_snippet(any_hit=True))
def _occluded(tlas: structs.Tlas, origin: wp.vec3, direction: wp.vec3, tmin: float, tmax: float) -> Packed: ...


@wp.kernel(enable_backward=False)
def _trace(
    tlas: structs.Tlas,
    any_hit: int,
    origins: wp.array(dtype=wp.vec3),
    directions: wp.array(dtype=wp.vec3),
    reach: wp.array(dtype=wp.float32),
    hits: wp.array(dtype=Packed),
):
    i = wp.tid()
    if any_hit != 0:
        hits[i] = _occluded(tlas, origins[i], directions[i], 0.0, reach[i])
    else:
        hits[i] = _closest(tlas, origins[i], directions[i], 0.0, reach[i])


def trace(device_scene, scene, origins, directions, *, reach=None, any_hit=False) -> np.ndarray:
    """(N, 5) int32 packed hits of rays in the compressed form of a scene that was synced to the CPU."""
    kept = []

    def address(values: np.ndarray) -> int:
        kept.append(wp.array(values.reshape(-1).view(np.uint32), dtype=wp.uint32, device="cpu"))
        return int(kept[-1].ptr)

    blases = []
    for prototype in scene.prototypes:
        blases.append(tuple(map(address, acceleration_structure.cuda_blas(prototype.points, prototype.triangles))))
    rows = device_scene.tables.tlas.instances.numpy().copy()
    for row, which in zip(rows, scene.instances.prototype, strict=True):
        row["nodes"], row["blocks"] = blases[which]
    placement = device_scene.placement
    placed = np.flatnonzero(placement.placed)
    nodes, order = np.zeros((len(placed), NODE_WORDS), np.uint32), np.zeros(len(placed), np.int32)
    acceleration_structure.TlasBuilder(placement.lower, placement.upper, nodes, order, "cuda").build(placed)
    tlas = structs.Tlas()
    tlas.nodes, tlas.instance_count = address(nodes), len(placed)
    tlas.order = wp.array(order, dtype=wp.int32, device="cpu")
    tlas.instances = wp.array(rows, dtype=structs.Instance, device="cpu")
    assert rows.dtype == records(structs.Instance, 0).dtype
    reach = np.full(len(origins), 1e30) if reach is None else reach
    rays = [
        wp.array(np.ascontiguousarray(each, np.float32), dtype=wp.vec3, device="cpu") for each in (origins, directions)
    ]
    hits = wp.zeros(len(origins), dtype=Packed, device="cpu")
    wp.launch(
        _trace,
        dim=len(origins),
        inputs=[tlas, int(any_hit), *rays, wp.array(reach, dtype=wp.float32, device="cpu"), hits],
        device="cpu",
    )
    return hits.numpy()
