"""Kernels that write AOVs in the types of images: four channels of float16, float32 or uint8.

AOVs are read as floats, so that one kernel of each type takes numbers, pairs and vectors. A thread writes the pixels
from `begin` to `end`, one on a GPU and thousands on a CPU, whose compiler makes vector instructions of a loop in C++
where it would make a call for each pixel of a kernel. Sums and products are statements of their own, so that no
compiler contracts them and both devices round as Python would.
"""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false

import warp as wp

from usdsdg.annotators.pixels.pixel_runs import begin_of, end_of


def _for_channels(loop: str) -> str:
    """Return C++ with a loop for each number of channels that images have, so that the compiler knows it.

    In the loop, `channel(of, i, c)` is channel c of pixel i: those of numbers are all equal, missing ones of pairs and
    vectors are 0.
    """
    channel = "auto channel = [](const float* of, int i, int c) { return %s; };"
    read = {n: f"c < {n} ? of[i * {n} + c] : 0.0f" for n in (2, 3, 4)} | {1: "of[i]"}
    return "".join(f"if (channels == {n}) {{ {channel % read[n]} {loop} }}\n" for n in read)


@wp.func_native(
    """
    const float* added = plus.shape[0] > 0 ? plus.data : nullptr;
    const int* shown = instance.shape[0] > 0 ? instance.data : nullptr;
    wp::half* out = reinterpret_cast<wp::half*>(result.data);
    auto half_of = [&](float x) { return wp::half(x > limit ? limit : x); };
    // One loop for each case: with the cases in the loop, it is three times slower.
    auto write = [&](auto value) {
        for (int i = begin; i < end; ++i) {
            const float x = value(i, 0), y = value(i, 1), z = value(i, 2);
            out[4 * i] = half_of(x);
            out[4 * i + 1] = half_of(y);
            out[4 * i + 2] = half_of(z);
            out[4 * i + 3] = wp::half(1.0f);
        }
    };
    """
    + _for_channels("""
    if (added) write([&](int i, int c) { return channel(image.data, i, c) + channel(added, i, c); });
    else write([&](int i, int c) { return channel(image.data, i, c); });
    """)
    + """
    for (int i = begin; shown && i < end; ++i)
        if (shown[i] < 0) out[4 * i + 3] = wp::half(0.0f);
    """
)
def write_halves(
    image: wp.array(dtype=wp.float32),
    channels: int,
    plus: wp.array(dtype=wp.float32),
    instance: wp.array(dtype=wp.int32),
    limit: float,
    begin: int,
    end: int,
    result: wp.array(dtype=wp.vec4h),
):
    """Write numbers or vectors and those of `plus`, `limit` at most, with 1 in the fourth channel."""


@wp.func_native(
    _for_channels("""
    for (int i = begin; i < end; ++i) {
        const float x = channel(image.data, i, 0), y = channel(image.data, i, 1), z = channel(image.data, i, 2);
        result.data[i] = wp::vec_t<4, float>(x, y, z, fourth);
    }
    """)
)
def write_floats(
    image: wp.array(dtype=wp.float32),
    channels: int,
    fourth: float,
    begin: int,
    end: int,
    result: wp.array(dtype=wp.vec4),
):
    """Write vectors with a value in the fourth channel."""


@wp.func_native(
    """
    auto byte_of = [](float x) {
        const float scaled = wp::clamp(x, 0.0f, 1.0f) * 255.0f;
        return (unsigned char)(scaled + 0.5f);
    };
    """
    + _for_channels("""
    for (int i = begin; i < end; ++i) {
        const unsigned char x = byte_of(channel(image.data, i, 0)), y = byte_of(channel(image.data, i, 1));
        const unsigned char z = byte_of(channel(image.data, i, 2));
        const unsigned char fourth = channels == 4 ? byte_of(image.data[4 * i + 3]) : 255;
        result.data[i] = wp::vec_t<4, wp::uint8>(x, y, z, fourth);
    }
    """)
)
def write_eight_bits(
    image: wp.array(dtype=wp.float32),
    channels: int,
    begin: int,
    end: int,
    result: wp.array(dtype=wp.vec4ub),
):
    """Write values from 0 to 1 as bytes; a missing fourth channel is 255."""


@wp.func_native("""
    for (int i = begin; i < end; ++i)
        result.data[i] = wp::vec_t<3, wp::uint8>(image.data[i][0], image.data[i][1], image.data[i][2]);
""")
def write_three(image: wp.array(dtype=wp.vec4ub), begin: int, end: int, result: wp.array(dtype=wp.vec3ub)):
    """Write the first three channels."""


@wp.func_native("""
    // Pixels of four halves, all bits of which are 0 where the halves are.
    const unsigned long long* from = reinterpret_cast<const unsigned long long*>(color.data);
    unsigned long long* out = reinterpret_cast<unsigned long long*>(result.data);
    for (int i = begin; i < end; ++i) out[i] = instance.data[i] < 0 ? from[i] : 0;
""")
def write_background(
    color: wp.array(dtype=wp.vec4h),
    instance: wp.array(dtype=wp.int32),
    begin: int,
    end: int,
    result: wp.array(dtype=wp.vec4h),
):
    """Write the color where nothing is hit, and 0 elsewhere."""


@wp.kernel(enable_backward=False, module="unique")
def halves(
    image: wp.array(dtype=wp.float32),
    channels: int,
    plus: wp.array(dtype=wp.float32),  # of as many channels; empty for none
    instance: wp.array(dtype=wp.int32),  # the fourth channel is 1 where it is not -1; empty: everywhere
    limit: float,
    pixels: int,  # of a thread
    first: int,
    # out
    result: wp.array(dtype=wp.vec4h),
):
    """Write an image of `channels` numbers a pixel as half floats; see `write_halves`."""
    begin = begin_of(wp.tid() + first, pixels)
    end = end_of(begin, pixels, result.shape[0])
    write_halves(image, channels, plus, instance, limit, begin, end, result)


@wp.kernel(enable_backward=False, module="unique")
def floats(
    image: wp.array(dtype=wp.float32),
    channels: int,
    fourth: float,
    pixels: int,  # of a thread
    first: int,
    # out
    result: wp.array(dtype=wp.vec4),
):
    """Write an image of `channels` numbers a pixel as floats, with a `fourth` channel; see `write_floats`."""
    begin = begin_of(wp.tid() + first, pixels)
    write_floats(image, channels, fourth, begin, end_of(begin, pixels, result.shape[0]), result)


@wp.kernel(enable_backward=False, module="unique")
def eight_bits(
    image: wp.array(dtype=wp.float32),
    channels: int,
    pixels: int,  # of a thread
    first: int,
    # out
    result: wp.array(dtype=wp.vec4ub),
):
    """Write an image of `channels` numbers a pixel as bytes; see `write_eight_bits`."""
    begin = begin_of(wp.tid() + first, pixels)
    write_eight_bits(image, channels, begin, end_of(begin, pixels, result.shape[0]), result)


@wp.kernel(enable_backward=False, module="unique")
def without_alpha(
    image: wp.array(dtype=wp.vec4ub),
    pixels: int,  # of a thread
    first: int,
    # out
    result: wp.array(dtype=wp.vec3ub),
):
    """Write the first three channels of an image."""
    begin = begin_of(wp.tid() + first, pixels)
    write_three(image, begin, end_of(begin, pixels, result.shape[0]), result)


@wp.kernel(enable_backward=False, module="unique")
def behind_everything(
    color: wp.array(dtype=wp.vec4h),
    instance: wp.array(dtype=wp.int32),
    pixels: int,  # of a thread
    first: int,
    # out
    result: wp.array(dtype=wp.vec4h),
):
    """Write the color where nothing is hit, and 0 elsewhere."""
    begin = begin_of(wp.tid() + first, pixels)
    write_background(color, instance, begin, end_of(begin, pixels, result.shape[0]), result)
