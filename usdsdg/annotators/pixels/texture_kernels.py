"""Kernels that find how much texture a picture has."""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportAssignmentType=false, reportGeneralTypeIssues=false, reportIndexIssue=false

import warp as wp

from usdsdg.annotators.pixels.pixel_runs import ROOT, begin_of, end_of


# Loops in C++ over the pixels of a thread, as those of the encodings; arrays are contiguous.
@wp.func_native("""
    // The number of channels is a constant in each loop. Products of a byte and a float are exact in double, so that
    // each step is rounded once.
    auto write = [&](auto stride) {
        for (int i = begin; i < end; ++i) {
            float total = 0.0f;
            for (int c = 0; c < 3; ++c) {
                const double product = double(color.data[i * stride() + c]) * double(weights[c]);
                total = (float)(product + double(total));
            }
            gray.data[i] = total;
        }
    };
    if (channels == 4) write([] { return 4; });
    else write([] { return 3; });
""")
def write_gray(
    color: wp.array(dtype=wp.uint8),
    channels: int,
    weights: wp.vec3,
    begin: int,
    end: int,
    gray: wp.array(dtype=wp.float32),
):
    """Write the luminance of each pixel."""


@wp.kernel(enable_backward=False, module="unique")
def weigh_colors(
    color: wp.array(dtype=wp.uint8),
    channels: int,
    weights: wp.vec3,
    pixels: int,  # of a thread
    first: int,
    # out
    gray: wp.array(dtype=wp.float32),
):
    begin = begin_of(wp.tid() + first, pixels)
    write_gray(color, channels, weights, begin, end_of(begin, pixels, gray.shape[0]), gray)


@wp.func_native(
    ROOT
    + """
    const int width = gray.shape[1], last = width - 1;
    const float* here = gray.data + y * width;
    const float* above = y > 0 ? here - width : here;
    const float* below = y + 1 < gray.shape[0] ? here + width : here;
    float* lengths = texture.shape[0] > 0 ? texture.data + y * width : nullptr;
    bool* found = is_textured.data + y * width;
    auto smooth = [](float before, float middle, float after) {
        const double ends = double(before) + double(after);
        return (float)(double(middle) * 2.0 + ends);  // twice a float is exact
    };
    auto length_at = [&](int left, int x, int right) {
        const double sy = smooth(below[left] - above[left], below[x] - above[x], below[right] - above[right]);
        const double sx = smooth(above[right] - above[left], here[right] - here[left], below[right] - below[left]);
        const double square_y = sy * sy, square_x = sx * sx;
        return wp::min((float)root(square_y + square_x), 1.0f);
    };
    if (lengths) {
        for (int x = 0; x < width; ++x) lengths[x] = length_at(x > 0 ? x - 1 : 0, x, x < last ? x + 1 : last);
        for (int x = 0; x < width; ++x) found[x] = lengths[x] >= least;
        return;
    }
    // The ends of the row are for themselves, so that the loop has neighbors without conditions.
    found[0] = length_at(0, 0, last > 0 ? 1 : 0) >= least;
    for (int x = 1; x < last; ++x) found[x] = length_at(x - 1, x, x + 1) >= least;
    if (last > 0) found[last] = length_at(last - 1, last, last) >= least;
"""
)
def write_texture(
    gray: wp.array2d(dtype=wp.float32),
    least: float,
    y: int,
    texture: wp.array2d(dtype=wp.float32),
    is_textured: wp.array2d(dtype=wp.bool),
):
    """Write a row."""


@wp.kernel(enable_backward=False, module="unique")
def find_texture(
    gray: wp.array2d(dtype=wp.float32),
    least: float,
    first: int,
    # out: the length of Sobel's gradient, at most 1; beyond the edges pixels go on as they are there
    texture: wp.array2d(dtype=wp.float32),  # empty for none
    is_textured: wp.array2d(dtype=wp.bool),  # whether it is at least that
):
    write_texture(gray, least, wp.tid() + first, texture, is_textured)
