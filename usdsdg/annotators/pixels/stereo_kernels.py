"""Kernels of a stereo depth camera: matching of rows, isolated pixels, points.

Those that loop in C++ take contiguous arrays, as the encodings do.
"""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportAssignmentType=false, reportGeneralTypeIssues=false, reportIndexIssue=false

import warp as wp

from usdsdg.annotators.pixels.pixel_runs import begin_of, end_of


@wp.struct
class Pair:
    """What rows are matched with; pixels are those of the image."""

    disparity_times_depth: wp.float64
    baseline: wp.float64  # whose sign counts
    step: wp.float64  # of the disparity; 0 for neither steps nor noise
    sigma: wp.float64
    block: wp.float64  # side of blocks that share a deviation
    least: wp.float64  # distance
    most: wp.float64
    sensor_size: wp.float64
    most_disparity: wp.float64  # of the sensor


@wp.func_native("""
    const int width = depth.shape[1];
    const float* z_of = depth.data + y * width;
    const bool* is_confident = confident.data + y * width;
    double* noisy_of = disparity.data + y * width;
    double* read_of = distance.data + y * width;
    float* nearest_of = nearest.data + y * width;
    int* source_of = source.data + y * width;
    const double whole = 4503599627370496.0;  // above this, numbers have no fractions
    const double disparity_times_depth = pair.disparity_times_depth, step = pair.step, sigma = pair.sigma;
    const double least = pair.least, most = pair.most, sensor_size = pair.sensor_size;
    const double largest = pair.most_disparity * double(width);
    // A loop for each step, so that those without jumps become vector instructions.
    for (int x = 0; x < width; ++x) {
        const float z = z_of[x] > 0.0f ? z_of[x] : infinity;
        noisy_of[x] = disparity_times_depth / double(z);
        nearest_of[x] = infinity;
        source_of[x] = -1;
    }
    for (int x = 0; x < width; ++x) {
        const float z = z_of[x] > 0.0f ? z_of[x] : infinity;
        // Of several pixels that move to one, the nearest is seen.
        const double shift = pair.baseline < 0.0 ? -noisy_of[x] : noisy_of[x];
        const double column = double(x) + 0.5 - shift;
        if (column >= 0.0 && column < double(width)) {
            const int target = (int)column;
            if (z <= nearest_of[target]) {
                nearest_of[target] = z;
                source_of[target] = x;
            }
        }
    }
    if (step != 0.0) {
        const double* deviation_of = deviations.data + (int)(double(y) / pair.block) * deviations.shape[1];
        auto deviate = [&](auto index) {
            for (int x = 0; x < width; ++x) {
                const double deviation = deviation_of[index(x)] * sigma;
                const double steps = noisy_of[x] / step;
                // As `rint`, of a number that is not negative, without a call.
                const double rounded = steps < whole ? (steps + whole) - whole : steps;
                const double stepped = rounded * step;
                const double moved = stepped + deviation;
                noisy_of[x] = moved > 0.0 ? moved : 0.0;
            }
        };
        if (pair.block == 1.0) deviate([](int x) { return x; });
        else deviate([&](int x) { return (int)(double(x) / pair.block); });
    }
    for (int x = 0; x < width; ++x) {
        const double read = disparity_times_depth / noisy_of[x];
        const double of_sensor = noisy_of[x] * sensor_size;
        // No distance is infinite, so what is below infinity is finite.
        const bool seen = (z_of[x] > 0.0f) & (z_of[x] < infinity);
        const bool within = (read >= least) & (read <= most) & (read < (double)infinity);
        read_of[x] = (seen & within & is_confident[x] & (of_sensor <= largest)) ? read : -1.0;
    }
    // Points that cannot be measured still occlude others, so they are removed only now.
    for (int x = 0; x < width; ++x) {
        const int s = source_of[x];
        if (s >= 0) source_of[x] = read_of[s] >= 0.0 ? y * width + s : -1;
    }
""")
def match_row(
    pair: Pair,
    depth: wp.array2d(dtype=wp.float32),
    confident: wp.array2d(dtype=wp.bool),
    deviations: wp.array2d(dtype=wp.float64),
    infinity: float,
    y: int,
    disparity: wp.array2d(dtype=wp.float64),
    distance: wp.array2d(dtype=wp.float64),
    nearest: wp.array2d(dtype=wp.float32),
    source: wp.array2d(dtype=wp.int32),
):
    """Match a row."""


@wp.kernel(enable_backward=False, module="unique")
def match_rows(
    pair: Pair,
    depth: wp.array2d(dtype=wp.float32),
    confident: wp.array2d(dtype=wp.bool),
    deviations: wp.array2d(dtype=wp.float64),  # normal, of blocks
    first: int,
    # out
    disparity: wp.array2d(dtype=wp.float64),  # of the camera's pixels, with noise
    distance: wp.array2d(dtype=wp.float64),  # as it is measured from that; negative where it cannot be
    nearest: wp.array2d(dtype=wp.float32),  # scratch
    source: wp.array2d(dtype=wp.int32),  # the camera's pixel that each pixel of the second imager shows; -1 for none
):
    match_row(pair, depth, confident, deviations, float(wp.inf), wp.tid() + first, disparity, distance, nearest, source)


@wp.func_native("""
    const int* found = source.data;
    for (int i = begin; i < end; ++i) {
        int s = found[i];
        if (mends != 0) {
            const int y = i / width, x = i - y * width;
            if (s < 0 && x > 0 && x < width - 1) {
                const int before = found[i - 1], after = found[i + 1];
                if (before >= 0 && after >= 0) s = distance.data[before] >= distance.data[after] ? before : after;
            } else if (s >= 0) {
                // Most pixels have a neighbor in their row.
                const int left = x > 0 ? x - 1 : x, right = x < width - 1 ? x + 1 : x;
                bool alone = (left == x || found[i - 1] < 0) && (right == x || found[i + 1] < 0);
                for (int row = y - 1; alone && row <= y + 1; row += 2)
                    for (int column = left; row >= 0 && row < height && column <= right; ++column)
                        alone = alone && found[row * width + column] < 0;
                if (alone) s = -1;
            }
        }
        mended.data[i] = s;
        measured.data[i] = s >= 0 ? (float)distance.data[s] : 0.0f;
    }
""")
def write_distances(
    source: wp.array(dtype=wp.int32),
    distance: wp.array(dtype=wp.float64),
    mends: int,
    height: int,
    width: int,
    begin: int,
    end: int,
    mended: wp.array(dtype=wp.int32),
    measured: wp.array(dtype=wp.float32),
):
    """Write the source of each pixel, that of a neighbor where it is a gap of one column, or -1 where it is alone."""


@wp.kernel(enable_backward=False, module="unique")
def read_distances(
    source: wp.array(dtype=wp.int32),
    distance: wp.array(dtype=wp.float64),  # of the camera's pixels
    mends: int,  # whether isolated pixels are mended
    height: int,
    width: int,
    pixels: int,  # of a thread
    first: int,
    # out
    mended: wp.array(dtype=wp.int32),
    measured: wp.array(dtype=wp.float32),  # distance of each pixel of the second imager, 0 for none
):
    begin = begin_of(wp.tid() + first, pixels)
    end = end_of(begin, pixels, source.shape[0])
    write_distances(source, distance, mends, height, width, begin, end, mended, measured)


@wp.kernel(enable_backward=False, module="unique")
def move_colors(
    color: wp.array(dtype=wp.vec4ub),
    source: wp.array(dtype=wp.int32),
    first: int,
    # out
    moved: wp.array(dtype=wp.vec4ub),
):
    i = wp.tid()
    i += first
    nothing = wp.uint8(0)
    moved[i] = wp.vec4ub(nothing, nothing, nothing, nothing)
    if source[i] >= 0:
        moved[i] = color[source[i]]


# As linear algebra libraries add products, so that points are theirs.
@wp.func_native("""
#if defined(__CUDA_ARCH__)
return fma(a, b, c);
#else
return __builtin_fma(a, b, c);
#endif
""")
def multiply_add(a: wp.float64, b: wp.float64, c: wp.float64) -> wp.float64: ...


@wp.kernel(enable_backward=False, module="unique")
def place_points(
    source: wp.array(dtype=wp.int32),
    measured: wp.array(dtype=wp.float32),  # distance of each pixel of the second imager
    depth: wp.array(dtype=wp.float32),
    position: wp.array(dtype=wp.vec3),
    to_camera: wp.mat44d,  # for row vectors, to units of the stage
    meters_per_unit: wp.float64,
    first: int,
    # out
    points: wp.array(dtype=wp.vec4),
):
    i = wp.tid()
    i += first
    s = source[i]
    if s < 0:
        points[i] = wp.vec4(0.0)
        return
    scale = float(0.0)
    if depth[s] > 0.0:
        scale = measured[i] / depth[s]
    p = position[s]
    out = wp.vec4(0.0, 0.0, 0.0, 1.0)
    for k in range(3):
        along = multiply_add(wp.float64(p[1]), to_camera[1, k], wp.float64(p[0]) * to_camera[0, k])
        along = multiply_add(wp.float64(p[2]), to_camera[2, k], along) + to_camera[3, k]
        out[k] = float(along * meters_per_unit * wp.float64(scale))
    points[i] = out
