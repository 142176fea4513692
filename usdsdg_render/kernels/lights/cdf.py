"""Inversion of cumulative distribution functions (CDFs)."""

import warp as wp

# The last cell in [start, start + count) whose CDF value is at most `number`: bisection down to 32 cells, which a CPU
# then compares at once.
_INVERT_CDF = """
    const float* sums = cdf.data + start;
    int first = 0, left = count;
#if !defined(__CUDA_ARCH__)
    typedef float float8 __attribute__((ext_vector_type(8), aligned(4)));
    typedef int int8 __attribute__((ext_vector_type(8)));
    while (left > 32) {
        const int half = left / 2;
        first = sums[first + half] <= number ? first + half : first;
        left -= half;
    }
    if (left == 32) {
        const float* p = sums + first;
        const int8 below = (*(const float8*)p <= number) + (*(const float8*)(p + 8) <= number)
            + (*(const float8*)(p + 16) <= number) + (*(const float8*)(p + 24) <= number);
        return start + first - __builtin_reduce_add(below) - 1;
    }
#endif
    while (left > 1) {
        const int half = left / 2;
        first = sums[first + half] <= number ? first + half : first;
        left -= half;
    }
    return start + first;
"""


@wp.func_native(_INVERT_CDF)
def invert_cdf(cdf: wp.array(dtype=wp.float32), start: int, count: int, number: float) -> int: ...
