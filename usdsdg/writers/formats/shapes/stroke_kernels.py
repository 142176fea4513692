"""The kernel of `drawing`: anti-aliased strokes, painted over an image one after the other.

The loop over pixels is C++, which Warp compiles with the kernel: its arrays would make it four times as slow. Sums and
products are statements of their own, so that no compiler contracts them and every CPU writes the same bytes.
"""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportIndexIssue=false, reportReturnType=false

import warp as wp

_DRAW = """
    const double y = row + 0.5;
    const int width = image.shape[1], channels = image.shape[2];
    uint8_t* const pixels = image.data + int64_t(row) * width * channels;
    auto clamped = [](double value, double low, double high) {
        return value > low ? value < high ? value : high : low;  // NaN is low
    };
    for (int k = 0; k < strokes.shape[0]; k++) {
        const double* const stroke = strokes.data + 9 * int64_t(k);
        const double ax = stroke[0], ay = stroke[1], radius = stroke[4], opacity = stroke[5];
        const double dx = stroke[2] - ax, dy = stroke[3] - ay;
        const double reach = radius + 0.5;
        // The part of the segment that is near enough to the row.
        double first = 0.0, last = 1.0;
        if (dy == 0.0) {
            if (y - ay > reach || ay - y > reach) continue;
        } else {
            const double a = (y - reach - ay) / dy, b = (y + reach - ay) / dy;
            first = clamped(a < b ? a : b, 0.0, 2.0);
            last = clamped(a < b ? b : a, -1.0, 1.0);
            if (first > last) continue;
        }
        const double to_first = first * dx, to_last = last * dx;
        const double a = ax + to_first, b = ax + to_last;
        const int left = static_cast<int>(clamped((a < b ? a : b) - reach - 1.0, 0.0, width));
        const int right = static_cast<int>(clamped((a < b ? b : a) + reach + 1.0, 0.0, width));
        const double xx = dx * dx, yy = dy * dy;
        const double squared = xx + yy;
        const double down = (y - ay) * dy;
        for (int column = left; column < right; column++) {
            const double x = column + 0.5;
            const double across = (x - ax) * dx;
            const double t = squared == 0.0 ? 0.0 : clamped((across + down) / squared, 0.0, 1.0);
            const double tx = t * dx, ty = t * dy;
            const double ox = x - ax - tx, oy = y - ay - ty;
            const double ox2 = ox * ox, oy2 = oy * oy;
            const double inside = reach - sqrt(ox2 + oy2);
            if (!(inside > 0.0)) continue;
            const double alpha = (inside < 1.0 ? inside : 1.0) * opacity;
            uint8_t* const pixel = pixels + int64_t(column) * channels;
            for (int channel = 0; channel < 3; channel++) {
                const double below = pixel[channel];
                const double change = alpha * (stroke[6 + channel] - below);
                pixel[channel] = uint8_t(below + change + 0.5);
            }
        }
    }
"""


@wp.func_native(_DRAW)
def draw_row(row: int, strokes: wp.array2d(dtype=wp.float64), image: wp.array3d(dtype=wp.uint8)):
    """Paint strokes (N, 9) over three channels of a row, in their order; edges are ramps, a pixel wide.

    A stroke is what is within a radius of a segment, in pixels whose centers are at .5: x and y of its start and of its
    end, radius, opacity, and the color.
    """


@wp.kernel(enable_backward=False)
def draw_strokes(strokes: wp.array2d(dtype=wp.float64), image: wp.array3d(dtype=wp.uint8)):
    draw_row(wp.tid(), strokes, image)
