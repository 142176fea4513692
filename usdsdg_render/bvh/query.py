"""Ray queries: one ray against a `Tlas`, compiled for CPU or CUDA; both give the same hits.

Results are packed in five words: t, u, v (bit patterns of floats), instance or -1, triangle. The parameter t is in
lengths of `direction`; only hits with tmin < t < tmax count, so a query repeated with tmin = t continues behind a hit.
"""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportInvalidTypeForm=false

from pathlib import Path

import warp as wp

from usdsdg_render.scene.structs import Hit, Tlas

# Depth limits of BLAS and TLAS, checked while building: each level leaves at most seven entries on the stack.
MAX_TLAS_DEPTH = 12
MAX_BLAS_DEPTH = 20
STACK_SIZE = 256
assert 7 * (MAX_TLAS_DEPTH + MAX_BLAS_DEPTH) + 8 <= STACK_SIZE
# On CUDA a group holds the remaining nodes of a level; entering an instance pushes two groups.
CUDA_STACK_SIZE = 40
assert MAX_TLAS_DEPTH + MAX_BLAS_DEPTH + 2 <= CUDA_STACK_SIZE

Packed = wp.types.vector(length=5, dtype=wp.int32)

_TRAVERSE = Path(__file__).with_name("traverse.cpp").read_text()
_COMPRESSED = Path(__file__).with_name("compressed.cpp").read_text()
# A ray with NaN or infinity would pass every box test; it hits nothing.
_ONLY_FINITE = """
{
    float zero = 0.0f;
    for (int k = 0; k < 3; ++k) zero += 0.0f * origin[k] + 0.0f * direction[k];
    if (!(zero == 0.0f)) {
        wp::vec_t<5, int> nothing;
        nothing[3] = -1;
        return nothing;
    }
}
"""


def flags_of(*, any_hit: bool, one_instance: bool, one_part: bool = False) -> str:
    """Return what the two bodies expect to be defined before them."""
    in_part = "parts.data[first_triangle + triangle] == only_part" if one_part else "true"
    flags = f"constexpr bool ANY_HIT = {str(any_hit).lower()}, ONE_INSTANCE = {str(one_instance).lower()};\n"
    flags += f"auto is_in_part = [&](int triangle) {{ return {in_part}; }};\n"
    return flags if one_instance else flags + "constexpr int only_instance = 0;\n"


def _snippet(**kind: bool) -> str:
    flags = flags_of(**kind)
    cuda = f"constexpr int STACK_SIZE = {CUDA_STACK_SIZE};\n{_COMPRESSED}"
    cpu = f"constexpr int STACK_SIZE = {STACK_SIZE};\n{_TRAVERSE}"
    return f"{_ONLY_FINITE}{flags}#if defined(__CUDA_ARCH__)\n{cuda}\n#else\n{cpu}\n#endif\n"


@wp.func_native(_snippet(any_hit=False, one_instance=False))
def wide_closest(tlas: Tlas, origin: wp.vec3, direction: wp.vec3, tmin: float, tmax: float) -> Packed: ...


@wp.func_native(_snippet(any_hit=True, one_instance=False))
def wide_occluded(tlas: Tlas, origin: wp.vec3, direction: wp.vec3, tmin: float, tmax: float) -> Packed: ...


@wp.func_native(_snippet(any_hit=False, one_instance=True))
def wide_closest_in_instance(
    tlas: Tlas, origin: wp.vec3, direction: wp.vec3, tmin: float, tmax: float, only_instance: int
) -> Packed: ...


@wp.func_native(_snippet(any_hit=True, one_instance=True))
def wide_any_hit_in_instance(
    tlas: Tlas, origin: wp.vec3, direction: wp.vec3, tmin: float, tmax: float, only_instance: int
) -> Packed: ...


@wp.func_native(_snippet(any_hit=False, one_instance=True, one_part=True))
def wide_closest_in_part(
    tlas: Tlas,
    origin: wp.vec3,
    direction: wp.vec3,
    tmin: float,
    tmax: float,
    only_instance: int,
    parts: wp.array(dtype=wp.int32),  # of triangles; those of the instance begin at
    first_triangle: int,
    only_part: int,
) -> Packed: ...


@wp.func
def unpack(packed: Packed):
    return Hit(
        t=wp.cast(packed[0], wp.float32),
        u=wp.cast(packed[1], wp.float32),
        v=wp.cast(packed[2], wp.float32),
        instance=packed[3],
        triangle=packed[4],
    )
