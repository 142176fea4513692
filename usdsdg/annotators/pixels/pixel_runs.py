"""Warp functions of kernels whose threads take a number of pixels after each other."""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false

import warp as wp

# C++ that makes `entry_of(i)` the entry of a table for what pixel i shows: -1, no hit, has the last of `entries`.
ENTRY = "auto entry_of = [&](int i) { return instance.data[i] < 0 ? entries - 1 : instance.data[i]; };"

# C++ that makes `root(x)` the square root of a double; on a CPU without a call, which would also set errno.
ROOT = """
#if defined(__CUDA_ARCH__)
    auto root = [](double x) { return wp::sqrt(x); };
#else
    auto root = [](double x) { return __builtin_elementwise_sqrt(x); };
#endif
"""


@wp.func
def begin_of(thread: int, pixels: int):
    """Return the first pixel of a thread that takes so many."""
    return thread * pixels


@wp.func
def end_of(begin: int, pixels: int, count: int):
    """Return the pixel after the last one of a thread, of an image with `count`."""
    return wp.min(begin + pixels, count)
