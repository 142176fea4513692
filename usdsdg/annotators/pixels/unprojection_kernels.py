"""Kernel that gives each pixel of a depth image its point."""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportAssignmentType=false, reportGeneralTypeIssues=false, reportIndexIssue=false

import warp as wp

from usdsdg.annotators.pixels.pixel_runs import ROOT, begin_of, end_of


@wp.func_native(
    ROOT
    + """
    const double cx = center[0], cy = center[1], fx = focal[0], fy = -focal[1];
    const double zero = 0.0;  // origin plus direction: what is added to zero is never -0
    const float none = (float)infinity;
    const float* depth_of = depth.data;
    float* out = reinterpret_cast<float*>(points.data);
    auto write = [=](int i, double z, double px, double py, double pz) {
        const bool is_hit = z - z == 0.0;  // it is finite
        out[3 * i] = is_hit ? (float)px : none;
        out[3 * i + 1] = is_hit ? (float)py : none;
        out[3 * i + 2] = is_hit ? (float)pz : none;
    };
    for (int row = begin, y = begin / width; row < end; ++y) {
        const double v = (double(y) + 0.5 - cy) / fy;
        const double vv = v * v;
        const double down = v * meters_per_unit;
        const int first = y * width, last = wp::min(first + width, end);
        if (orthographic != 0) {
            for (int i = row; i < last; ++i) {
                const double z = double(depth_of[i]), u = (double(i - first) + 0.5 - cx) / fx;
                const double right = u * meters_per_unit;
                write(i, z, right + zero, -(down + zero), z);
            }
        } else {
            // A unit direction times the distance along it, in double, as rays of all other lenses are given.
            for (int i = row; i < last; ++i) {
                const double z = double(depth_of[i]), u = (double(i - first) + 0.5 - cx) / fx;
                const double uu = u * u;
                const double sides = uu + vv;
                const double length = root(sides + 1.0);
                const double along = z / (1.0 / length);
                const double ax = along * (u / length), ay = along * (v / length);
                write(i, z, zero + ax, -(zero + ay), along * (1.0 / length));
            }
        }
        row = last;
    }
"""
)
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
