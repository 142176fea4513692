"""Kernel that gives each pixel of a depth image its point."""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportAssignmentType=false, reportGeneralTypeIssues=false, reportIndexIssue=false

import warp as wp

from usdsdg.annotators.pixels.pixel_runs import begin_of, end_of


@wp.func_native("""
#if defined(__CUDA_ARCH__)
    auto root = [](double x) { return wp::sqrt(x); };
#else
    auto root = [](double x) { return __builtin_elementwise_sqrt(x); };  // no call, which would also set errno
#endif
    const double cx = center[0], cy = center[1], fx = focal[0], fy = -focal[1];
    const double zero = 0.0;  // origin plus direction: what is added to zero is never -0
    const float none = (float)infinity;
    for (int i = begin, y = begin / width; i < end; ++y) {
        const double v = (double(y) + 0.5 - cy) / fy;
        const double vv = v * v;
        const double down = v * meters_per_unit;
        for (int x = i - y * width; i < end && x < width; ++x, ++i) {
            const double z = double(depth.data[i]), u = (double(x) + 0.5 - cx) / fx;
            const double right = u * meters_per_unit;
            double px = right + zero, py = -(down + zero), pz = z;
            if (orthographic == 0) {
                // A unit direction times the distance along it, in double, as rays of all other lenses are given.
                const double uu = u * u;
                const double sides = uu + vv;
                const double length = root(sides + 1.0);
                const double along = z / (1.0 / length);
                const double ax = along * (u / length), ay = along * (v / length);
                px = zero + ax;
                py = -(zero + ay);
                pz = along * (1.0 / length);
            }
            const bool is_hit = wp::isfinite(z);
            points.data[i] = is_hit ? wp::vec_t<3, float>((float)px, (float)py, (float)pz) : wp::vec_t<3, float>(none);
        }
    }
""")
def write_points(
    depth: wp.array(dtype=wp.float32),
    width: int,
    center: wp.vec2d,
    focal: wp.vec2d,
    orthographic: int,
    meters_per_unit: wp.float64,
    infinity: wp.float64,
    begin: int,
    end: int,
    points: wp.array(dtype=wp.vec3),
):
    """Write the point of each pixel."""


@wp.kernel(enable_backward=False, module="unique")
def unproject(
    depth: wp.array(dtype=wp.float32),
    width: int,
    center: wp.vec2d,  # principal point [pixels]
    focal: wp.vec2d,  # [pixels], or pixels per unit of length of an orthographic camera
    orthographic: int,
    meters_per_unit: wp.float64,
    pixels: int,  # of a thread
    first: int,
    # out: x right, y down, z ahead [m]
    points: wp.array(dtype=wp.vec3),
):
    begin = begin_of(wp.tid() + first, pixels)
    end = end_of(begin, pixels, points.shape[0])
    infinity = wp.float64(wp.inf)
    write_points(depth, width, center, focal, orthographic, meters_per_unit, infinity, begin, end, points)
