"""Lenses that are no pinholes: from points of the picture to directions and back.

`usdsdg.stage.cameras.lenses` has the formulas in NumPy, and the meaning of the record's fields.
"""

import warp as wp

from usdsdg_render.kernels.cameras.lens_table import table_direction, table_place
from usdsdg_render.scene.structs import Lens

# Lens.kind
NONE = wp.constant(0)
FISHEYE = wp.constant(1)  # the curve tells a radius of an angle
F_THETA = wp.constant(2)  # the curve tells an angle of a radius
FLAT = wp.constant(3)  # the curve tells a radius of an angle's tangent
PANORAMA = wp.constant(4)
TABLE = wp.constant(5)  # texels tell directions; points of the plane are their places
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
    """Value and slope."""
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
def solved(lens: Lens, value: float):
    """The t in [0, limit] of a value: Newton's steps, kept inside of what is known."""
    low = float(0.0)
    high = float(lens.limit)
    t = float(0.0)
    for _step in range(NEWTON_STEPS):
        at = curve_at(lens, t)
        error = at[0] - value
        if error <= 0.0:
            low = t
        if error >= 0.0:
            high = t
        after = t - error / at[1]
        if not (after > low and after < high):
            after = 0.5 * (low + high)
        if wp.abs(after - t) <= 3.0e-8 * (wp.abs(t) + 1.0e-3):
            break
        t = after
    return t


@wp.func
def shift(lens: Lens, p: wp.vec2):
    """What tangential and thin prism distortion add to a point of the plane."""
    r2 = wp.dot(p, p)
    return wp.vec2(
        2.0 * lens.p1 * p[0] * p[1] + lens.p2 * (r2 + 2.0 * p[0] * p[0]) + r2 * (lens.s1 + lens.s2 * r2),
        lens.p1 * (r2 + 2.0 * p[1] * p[1]) + 2.0 * lens.p2 * p[0] * p[1] + r2 * (lens.s3 + lens.s4 * r2),
    )


@wp.func
def straightened(lens: Lens, plane: wp.vec2):
    """The point whose shift ends at `plane`, of a flat lens as tangents; 1 where there is one."""
    p = plane
    if lens.kind == FLAT:
        radius = wp.length(plane)
        if radius > 0.0:
            p = plane * (solved(lens, radius) / radius)
    size = 1.0 + wp.length(plane)
    miss = float(0.0)
    for step in range(SHIFT_STEPS):
        r2 = wp.dot(p, p)
        growth = float(1.0)
        outward = wp.mat22(0.0)
        if lens.kind == FLAT:
            t = wp.sqrt(r2)
            at = curve_at(lens, t)
            growth = at[1]
            if t > 1.0e-6:
                growth = at[0] / t
                outward = wp.outer(p, p) * ((at[1] - growth) / r2)
        error = growth * p + shift(lens, p) - plane
        miss = wp.length(error)
        if miss <= 1.0e-7 * size or step + 1 == SHIFT_STEPS:
            break
        s = 2.0 * (lens.s1 + 2.0 * lens.s2 * r2)
        v = 2.0 * (lens.s3 + 2.0 * lens.s4 * r2)
        mixed = 2.0 * (lens.p1 * p[0] + lens.p2 * p[1])
        a = outward[0, 0] + growth + 2.0 * lens.p1 * p[1] + 6.0 * lens.p2 * p[0] + p[0] * s
        b = outward[0, 1] + mixed + p[1] * s
        c = outward[1, 0] + mixed + p[0] * v
        d = outward[1, 1] + growth + 6.0 * lens.p1 * p[1] + 2.0 * lens.p2 * p[0] + p[1] * v
        determinant = a * d - b * c
        p = p - wp.vec2(d * error[0] - b * error[1], a * error[1] - c * error[0]) / determinant
    found = float(0.0)
    # A point that Newton's steps circle around is outside; so is one that is not a number.
    if miss <= 2.0e-6 * size:
        found = 1.0
    return wp.vec3(p[0], p[1], found)


@wp.func
def side_of(p: wp.vec2, radius: float):
    if radius > 0.0:
        return p / radius
    return wp.vec2(0.0)


@wp.func
def lens_direction(lens: Lens, plane: wp.vec2):
    """Unit direction of a point of the plane, y down, in the camera's frame; zero where no light comes through."""
    if lens.kind == TABLE:
        return table_direction(lens.table, lens.table_width, lens.table_height, plane)
    p = plane
    if lens.bends != 0:
        found = straightened(lens, plane)
        if found[2] == 0.0:
            return wp.vec3(0.0)
        p = wp.vec2(found[0], found[1])
    radius = wp.length(p)
    side = side_of(p, radius)
    if lens.kind == FLAT:
        t = radius
        if lens.bends == 0:
            if radius > lens.last:
                return wp.vec3(0.0)
            t = solved(lens, radius)
        if t > lens.limit:
            return wp.vec3(0.0)
        return wp.normalize(wp.vec3(t * side[0], -t * side[1], -1.0))
    angle = float(0.0)
    if lens.kind == F_THETA:
        if radius > lens.limit:
            return wp.vec3(0.0)
        angle = curve_at(lens, radius)[0]
    else:
        if radius > lens.last:
            return wp.vec3(0.0)
        angle = solved(lens, radius)
    sine = wp.sin(angle)
    return wp.vec3(sine * side[0], -sine * side[1], -wp.cos(angle))


@wp.func
def lens_plane(lens: Lens, p: wp.vec3):
    """Where the plane shows a direction, y down: (x, y, 1), or zero for what the lens does not see."""
    if lens.kind == TABLE:
        return table_place(lens.table, lens.table_width, lens.table_height, p)
    across = wp.sqrt(p[0] * p[0] + p[1] * p[1])
    side = side_of(wp.vec2(p[0], -p[1]), across)
    if lens.kind == FLAT:
        t = across / -p[2]
        if p[2] >= 0.0 or t > lens.limit:
            return wp.vec3(0.0)
        q = side * curve_at(lens, t)[0] + shift(lens, side * t)
        return wp.vec3(q[0], q[1], 1.0)
    angle = wp.atan2(across, -p[2])
    radius = float(0.0)
    if lens.kind == F_THETA:
        if angle > lens.last:
            return wp.vec3(0.0)
        radius = solved(lens, angle)
    else:
        if angle > lens.limit:
            return wp.vec3(0.0)
        radius = curve_at(lens, angle)[0]
    q = side * radius
    if lens.bends != 0:
        q = q + shift(lens, q)
    return wp.vec3(q[0], q[1], 1.0)


@wp.func
def panorama_direction(across: float, down: float):
    """Unit direction of a place in a panorama, as shares of its width and height."""
    longitude = (across - 0.5) * 2.0 * PI
    latitude = (0.5 - down) * PI
    level = wp.cos(latitude)
    return wp.vec3(level * wp.sin(longitude), wp.sin(latitude), -level * wp.cos(longitude))


@wp.func
def panorama_eye(eye: float, across: float):
    """Where the eye is that looks at a column, given as a share of the width."""
    longitude = (across - 0.5) * 2.0 * PI
    return wp.vec3(eye * wp.cos(longitude), 0.0, eye * wp.sin(longitude))


@wp.func
def panorama_place(eye: float, p: wp.vec3):
    """Where a point is seen, as shares of width and height: (across, down, 1), or zero inside of the eye's circle."""
    across = p[0] * p[0] + p[2] * p[2] - eye * eye
    if across < 0.0:
        return wp.vec3(0.0)
    reach = wp.sqrt(across)
    longitude = wp.atan2(p[0], -p[2]) - wp.atan2(eye, reach)
    if wp.abs(longitude) > PI:
        longitude -= wp.sign(longitude) * 2.0 * PI
    return wp.vec3(longitude / (2.0 * PI) + 0.5, 0.5 - wp.atan2(p[1], reach) / PI, 1.0)
