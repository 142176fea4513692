"""Lens models other than the pinhole: image points to directions and back.

`usdsdg.stage.cameras.lens` has the formulas in NumPy, and the meaning of the record's fields.
"""

import warp as wp

from usdsdg_render.kernels.cameras.lens_table import project_table, table_direction
from usdsdg_render.scene.structs import Lens

# Lens.kind
NONE = wp.constant(0)
FISHEYE = wp.constant(1)  # the curve maps angle to radius
F_THETA = wp.constant(2)  # the curve maps radius to angle
FLAT = wp.constant(3)  # the curve maps the tangent of the angle to radius
PANORAMA = wp.constant(4)
TABLE = wp.constant(5)  # texels hold directions; points of the plane are texel coordinates
# Lens.curve
ODD = wp.constant(0)
POWER = wp.constant(1)
RATIONAL = wp.constant(2)
SINE = wp.constant(3)
HALF_SINE = wp.constant(4)

NEWTON_STEPS = wp.constant(24)
SHIFT_STEPS = wp.constant(12)
PI = wp.constant(3.14159265358979)


@wp.func
def curve_at(lens: Lens, t: float):
    """Evaluate the curve: value and derivative."""
    if lens.curve == SINE:
        return wp.vec2(wp.sin(t), wp.cos(t))
    if lens.curve == HALF_SINE:
        return wp.vec2(2.0 * wp.sin(0.5 * t), wp.cos(0.5 * t))
    if lens.curve == POWER:
        value = lens.k0 + t * (lens.k1 + t * (lens.k2 + t * (lens.k3 + t * (lens.k4 + t * lens.k5))))
        slope = lens.k1 + t * (2.0 * lens.k2 + t * (3.0 * lens.k3 + t * (4.0 * lens.k4 + t * 5.0 * lens.k5)))
        return wp.vec2(value, slope)
    u = t * t
    if lens.curve == RATIONAL:
        above = 1.0 + u * (lens.k0 + u * (lens.k1 + u * lens.k2))
        below = 1.0 + u * (lens.k3 + u * (lens.k4 + u * lens.k5))
        ratio = above / below
        above_slope = 1.0 + u * (3.0 * lens.k0 + u * (5.0 * lens.k1 + u * 7.0 * lens.k2))
        below_slope = 2.0 * u * (lens.k3 + u * (2.0 * lens.k4 + u * 3.0 * lens.k5))
        return wp.vec2(t * ratio, (above_slope - ratio * below_slope) / below)
    tail = lens.k2 + u * (lens.k3 + u * (lens.k4 + u * lens.k5))
    tail_slope = 7.0 * lens.k2 + u * (9.0 * lens.k3 + u * (11.0 * lens.k4 + u * 13.0 * lens.k5))
    value = t * (1.0 + u * (lens.k0 + u * (lens.k1 + u * tail)))
    return wp.vec2(value, 1.0 + u * (3.0 * lens.k0 + u * (5.0 * lens.k1 + u * tail_slope)))


@wp.func
def invert_curve(lens: Lens, value: float):
    """Invert the curve on [0, limit] by Newton's method, safeguarded by bisection."""
    low = float(0.0)
    high = float(lens.limit)
    t = float(0.0)
    for _step in range(NEWTON_STEPS):
        value_slope = curve_at(lens, t)
        error = value_slope[0] - value
        if error <= 0.0:
            low = t
        if error >= 0.0:
            high = t
        next_t = t - error / value_slope[1]
        if not (next_t > low and next_t < high):
            next_t = 0.5 * (low + high)
        if wp.abs(next_t - t) <= 3.0e-8 * (wp.abs(t) + 1.0e-3):
            break
        t = next_t
    return t


@wp.func
def tangential_distortion(lens: Lens, p: wp.vec2):
    """Return the offset by tangential and thin prism distortion at a point of the plane."""
    r2 = wp.dot(p, p)
    return wp.vec2(
        2.0 * lens.p1 * p[0] * p[1] + lens.p2 * (r2 + 2.0 * p[0] * p[0]) + r2 * (lens.s1 + lens.s2 * r2),
        lens.p1 * (r2 + 2.0 * p[1] * p[1]) + 2.0 * lens.p2 * p[0] * p[1] + r2 * (lens.s3 + lens.s4 * r2),
    )


@wp.func
def undistorted(lens: Lens, plane: wp.vec2):
    """Undo the distortion of a point by Newton's method: (x, y, 1), or z = 0 if it does not converge.

    For a flat lens the result is in tangents of the angle.
    """
    p = plane
    if lens.kind == FLAT:
        radius = wp.length(plane)
        if radius > 0.0:
            p = plane * (invert_curve(lens, radius) / radius)
    size = 1.0 + wp.length(plane)
    residual = float(0.0)
    for step in range(SHIFT_STEPS):
        r2 = wp.dot(p, p)
        radial_scale = float(1.0)
        radial = wp.mat22(0.0)
        if lens.kind == FLAT:
            t = wp.sqrt(r2)
            value_slope = curve_at(lens, t)
            radial_scale = value_slope[1]
            if t > 1.0e-6:
                radial_scale = value_slope[0] / t
                radial = wp.outer(p, p) * ((value_slope[1] - radial_scale) / r2)
        error = radial_scale * p + tangential_distortion(lens, p) - plane
        residual = wp.length(error)
        if residual <= 1.0e-7 * size or step + 1 == SHIFT_STEPS:
            break
        s = 2.0 * (lens.s1 + 2.0 * lens.s2 * r2)
        v = 2.0 * (lens.s3 + 2.0 * lens.s4 * r2)
        mixed = 2.0 * (lens.p1 * p[0] + lens.p2 * p[1])
        a = radial[0, 0] + radial_scale + 2.0 * lens.p1 * p[1] + 6.0 * lens.p2 * p[0] + p[0] * s
        b = radial[0, 1] + mixed + p[1] * s
        c = radial[1, 0] + mixed + p[0] * v
        d = radial[1, 1] + radial_scale + 6.0 * lens.p1 * p[1] + 2.0 * lens.p2 * p[0] + p[1] * v
        determinant = a * d - b * c
        p = p - wp.vec2(d * error[0] - b * error[1], a * error[1] - c * error[0]) / determinant
    converged = float(0.0)
    # No convergence (or NaN) means that the point is outside of the image of the lens.
    if residual <= 2.0e-6 * size:
        converged = 1.0
    return wp.vec3(p[0], p[1], converged)


@wp.func
def radial_direction(p: wp.vec2, radius: float):
    """Return the unit vector toward a point; zero at the center."""
    if radius > 0.0:
        return p / radius
    return wp.vec2(0.0)


@wp.func
def lens_direction(lens: Lens, plane: wp.vec2):
    """Return the unit direction of a point of the plane (y down) in the camera's frame; zero outside of the lens."""
    if lens.kind == TABLE:
        return table_direction(lens.table, lens.table_width, lens.table_height, plane)
    p = plane
    if lens.is_asymmetric != 0:
        found = undistorted(lens, plane)
        if found[2] == 0.0:
            return wp.vec3(0.0)
        p = wp.vec2(found[0], found[1])
    radius = wp.length(p)
    side = radial_direction(p, radius)
    if lens.kind == FLAT:
        t = radius
        if lens.is_asymmetric == 0:
            if radius > lens.limit_value:
                return wp.vec3(0.0)
            t = invert_curve(lens, radius)
        if t > lens.limit:
            return wp.vec3(0.0)
        return wp.normalize(wp.vec3(t * side[0], -t * side[1], -1.0))
    angle = float(0.0)
    if lens.kind == F_THETA:
        if radius > lens.limit:
            return wp.vec3(0.0)
        angle = curve_at(lens, radius)[0]
    else:
        if radius > lens.limit_value:
            return wp.vec3(0.0)
        angle = invert_curve(lens, radius)
    sine = wp.sin(angle)
    return wp.vec3(sine * side[0], -sine * side[1], -wp.cos(angle))


@wp.func
def project_lens(lens: Lens, p: wp.vec3):
    """Project a direction to the plane (y down): (x, y, 1), or zero outside of the field of view."""
    if lens.kind == TABLE:
        return project_table(lens.table, lens.table_width, lens.table_height, p)
    across = wp.sqrt(p[0] * p[0] + p[1] * p[1])
    side = radial_direction(wp.vec2(p[0], -p[1]), across)
    if lens.kind == FLAT:
        t = across / -p[2]
        if p[2] >= 0.0 or t > lens.limit:
            return wp.vec3(0.0)
        q = side * curve_at(lens, t)[0] + tangential_distortion(lens, side * t)
        return wp.vec3(q[0], q[1], 1.0)
    angle = wp.atan2(across, -p[2])
    radius = float(0.0)
    if lens.kind == F_THETA:
        if angle > lens.limit_value:
            return wp.vec3(0.0)
        radius = invert_curve(lens, angle)
    else:
        if angle > lens.limit:
            return wp.vec3(0.0)
        radius = curve_at(lens, angle)[0]
    q = side * radius
    if lens.is_asymmetric != 0:
        q = q + tangential_distortion(lens, q)
    return wp.vec3(q[0], q[1], 1.0)


@wp.func
def panorama_direction(across: float, down: float):
    """Return the unit direction of a panorama position, given as fractions of width and height."""
    longitude = (across - 0.5) * 2.0 * PI
    latitude = (0.5 - down) * PI
    level = wp.cos(latitude)
    return wp.vec3(level * wp.sin(longitude), wp.sin(latitude), -level * wp.cos(longitude))


@wp.func
def panorama_origin(eye: float, across: float):
    """Return the ray origin of a panorama column, given as a fraction of the width."""
    longitude = (across - 0.5) * 2.0 * PI
    return wp.vec3(eye * wp.cos(longitude), 0.0, eye * wp.sin(longitude))


@wp.func
def project_panorama(eye: float, p: wp.vec3):
    """Project a point to a panorama: fractions (across, down, 1), or zero inside of the circle of eye positions."""
    across = p[0] * p[0] + p[2] * p[2] - eye * eye
    if across < 0.0:
        return wp.vec3(0.0)
    axial_distance = wp.sqrt(across)
    longitude = wp.atan2(p[0], -p[2]) - wp.atan2(eye, axial_distance)
    if wp.abs(longitude) > PI:
        longitude -= wp.sign(longitude) * 2.0 * PI
    return wp.vec3(longitude / (2.0 * PI) + 0.5, 0.5 - wp.atan2(p[1], axial_distance) / PI, 1.0)
