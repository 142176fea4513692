"""Kernel that gives each pixel of a depth image its point."""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportAssignmentType=false, reportGeneralTypeIssues=false, reportIndexIssue=false

import warp as wp


@wp.kernel(enable_backward=False, module="unique")
def unproject(
    depth: wp.array2d(dtype=wp.float32),
    center: wp.vec2d,  # principal point [pixels]
    focal: wp.vec2d,  # [pixels], or pixels per unit of length of an orthographic camera
    orthographic: int,
    meters_per_unit: wp.float64,
    first: int,
    # out: x right, y down, z ahead [m]
    points: wp.array2d(dtype=wp.vec3),
):
    y, x = wp.tid()
    y += first
    z = wp.float64(depth[y, x])
    if not wp.isfinite(z):
        points[y, x] = wp.vec3(wp.inf, wp.inf, wp.inf)
        return
    one, zero = wp.float64(1.0), wp.float64(0.0)  # origin plus direction: what is added to zero is never -0
    u = (wp.float64(x) + wp.float64(0.5) - center[0]) / focal[0]
    v = (wp.float64(y) + wp.float64(0.5) - center[1]) / -focal[1]
    if orthographic != 0:
        points[y, x] = wp.vec3(float(u * meters_per_unit + zero), float((v * meters_per_unit + zero) * -one), float(z))
        return
    # A unit direction times the distance along it, in float64, as rays of all other lenses are given.
    length = wp.sqrt(u * u + v * v + one)
    along = z / (one / length)
    points[y, x] = wp.vec3(
        float(zero + along * (u / length)), float((zero + along * (v / length)) * -one), float(along * (one / length))
    )
