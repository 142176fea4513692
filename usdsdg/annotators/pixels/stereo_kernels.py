"""Kernels of a stereo depth camera: texture of a picture, matching of rows, isolated pixels, points."""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportAssignmentType=false, reportGeneralTypeIssues=false, reportIndexIssue=false

import warp as wp


@wp.func
def smooth(before: float, here: float, after: float):
    return float(wp.float64(here) * wp.float64(2.0) + (wp.float64(before) + wp.float64(after)))


@wp.kernel(enable_backward=False, module="unique")
def weigh_colors(
    color: wp.array(dtype=wp.uint8),
    channels: int,
    weights: wp.vec3,
    first: int,
    # out
    gray: wp.array(dtype=wp.float32),
):
    i = wp.tid()
    i += first
    # Products of a byte and a float are exact in float64, so that each step is rounded once.
    total = float(0.0)
    for c in range(3):
        total = float(wp.float64(color[i * channels + c]) * wp.float64(weights[c]) + wp.float64(total))
    gray[i] = total


@wp.kernel(enable_backward=False, module="unique")
def find_texture(
    gray: wp.array2d(dtype=wp.float32),
    least: float,
    first: int,
    # out: the length of Sobel's gradient, at most 1; beyond the edges pixels go on as they are there
    texture: wp.array2d(dtype=wp.float32),  # empty for none
    is_textured: wp.array2d(dtype=wp.bool),  # whether it is at least that
):
    y = wp.tid() + first
    last = gray.shape[1] - 1
    above = wp.max(y - 1, 0)
    below = wp.min(y + 1, gray.shape[0] - 1)
    before = gray[below, 0] - gray[above, 0]
    here = before
    for x in range(last + 1):
        left = wp.max(x - 1, 0)
        right = wp.min(x + 1, last)
        after = gray[below, right] - gray[above, right]
        sy = wp.float64(smooth(before, here, after))
        across = smooth(
            gray[above, right] - gray[above, left],
            gray[y, right] - gray[y, left],
            gray[below, right] - gray[below, left],
        )
        sx = wp.float64(across)
        length = wp.min(float(wp.sqrt(sy * sy + sx * sx)), 1.0)
        is_textured[y, x] = length >= least
        if texture.shape[0] > 0:
            texture[y, x] = length
        before = here
        here = after


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


@wp.func
def rounded(x: wp.float64):
    """Return `wp.rint` of a number that is not negative, without a call: above this, numbers have no fractions."""
    whole = wp.float64(4503599627370496.0)
    if x < whole:
        return (x + whole) - whole
    return x


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
    y = wp.tid() + first
    width = depth.shape[1]
    row_of_block = int(wp.float64(y) / pair.block)
    for x in range(width):
        nearest[y, x] = wp.inf
        source[y, x] = -1
    for x in range(width):
        z = depth[y, x]
        if not (z > 0.0):
            z = wp.inf
        exact = pair.disparity_times_depth / wp.float64(z)
        # Of several pixels that move to one, the nearest is seen.
        shift = wp.where(pair.baseline < wp.float64(0.0), -exact, exact)
        column = wp.float64(x) + wp.float64(0.5) - shift
        if column >= wp.float64(0.0) and column < wp.float64(width):
            target = int(column)
            if z <= nearest[y, target]:
                nearest[y, target] = z
                source[y, target] = x
        noisy = exact
        if pair.step != wp.float64(0.0):
            column_of_block = x
            if pair.block != wp.float64(1.0):
                column_of_block = int(wp.float64(x) / pair.block)
            deviation = deviations[row_of_block, column_of_block] * pair.sigma
            noisy = wp.max(rounded(exact / pair.step) * pair.step + deviation, wp.float64(0.0))
        disparity[y, x] = noisy
        read = pair.disparity_times_depth / noisy
        within = read >= pair.least and read <= pair.most and wp.isfinite(read) and wp.isfinite(z)
        within = within and confident[y, x] and noisy * pair.sensor_size <= pair.most_disparity * wp.float64(width)
        distance[y, x] = wp.where(within, read, wp.float64(-1.0))
    # Points that cannot be measured still occlude others, so they are removed only now.
    for x in range(width):
        s = source[y, x]
        if s >= 0:
            source[y, x] = wp.where(distance[y, s] >= wp.float64(0.0), y * width + s, -1)


@wp.func
def mended_source(source: wp.array2d(dtype=wp.int32), distance: wp.array(dtype=wp.float64), y: int, x: int):
    """Return a pixel's source, that of a neighbor where it is a gap of one column, or -1 where it is alone."""
    height = source.shape[0]
    width = source.shape[1]
    s = source[y, x]
    if s < 0:
        if x > 0 and x < width - 1:
            before = source[y, x - 1]
            after = source[y, x + 1]
            if before >= 0 and after >= 0:
                return wp.where(distance[before] >= distance[after], before, after)
        return s
    # Most pixels have a neighbor in their row.
    for column in range(wp.max(x - 1, 0), wp.min(x + 2, width)):
        if column != x and source[y, column] >= 0:
            return s
    for row in range(wp.max(y - 1, 0), wp.min(y + 2, height)):
        if row != y:
            for column in range(wp.max(x - 1, 0), wp.min(x + 2, width)):
                if source[row, column] >= 0:
                    return s
    return int(-1)


@wp.kernel(enable_backward=False, module="unique")
def read_distances(
    source: wp.array2d(dtype=wp.int32),
    distance: wp.array(dtype=wp.float64),  # of the camera's pixels
    mends: int,  # whether isolated pixels are mended
    first: int,
    # out
    mended: wp.array2d(dtype=wp.int32),
    measured: wp.array2d(dtype=wp.float32),  # distance of each pixel of the second imager, 0 for none
):
    y, x = wp.tid()
    y += first
    s = source[y, x]
    if mends != 0:
        s = mended_source(source, distance, y, x)
    mended[y, x] = s
    read = float(0.0)
    if s >= 0:
        read = float(distance[s])
    measured[y, x] = read


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
