"""Lenses described by a texture of directions: `usdsdg.stage.cameras.lens_tables` for kernels.

A table is its texels, row by row, and then an octahedral map of start positions for the inverse search.
"""

import warp as wp

from usdsdg.stage.cameras.lens_tables import DARK_TOLERANCE, EXTRAPOLATED_RINGS, START_SIZE

START_MAP_SIZE = wp.constant(START_SIZE)
DARK_FRACTION = wp.constant(DARK_TOLERANCE)
BORDER = wp.constant(float(EXTRAPOLATED_RINGS))
NEWTON_STEPS = wp.constant(20)  # more than Warp unrolls
CONVERGED = wp.constant(2.0e-4)  # texels


@wp.func
def is_lit(width: int, height: int, position: wp.vec2, light: float):
    """Whether light enters at a texel position; `light` is the interpolated fourth channel."""
    across = position[0] > -0.5 - DARK_FRACTION and position[0] < float(width) - 0.5 + DARK_FRACTION
    down = position[1] > -0.5 - DARK_FRACTION and position[1] < float(height) - 0.5 + DARK_FRACTION
    return across and down and wp.abs(light - 1.0) < DARK_FRACTION


@wp.func
def table_direction(table: wp.uint64, width: int, height: int, position: wp.vec2):
    """Return the unit direction at a texel position; zero where no light enters."""
    texels = wp.array(ptr=table, shape=(width * height,), dtype=wp.vec4)
    x = wp.clamp(int(wp.floor(position[0])), 0, width - 2)
    y = wp.clamp(int(wp.floor(position[1])), 0, height - 2)
    first = y * width + x
    across = position[0] - float(x)
    above = wp.lerp(texels[first], texels[first + 1], across)
    below = wp.lerp(texels[first + width], texels[first + width + 1], across)
    seen = wp.lerp(above, below, position[1] - float(y))
    if not is_lit(width, height, position, seen[3]):
        return wp.vec3(0.0)
    return wp.normalize(wp.vec3(seen[0], seen[1], seen[2]))


@wp.func
def project_table(table: wp.uint64, width: int, height: int, p: wp.vec3):
    """Find the texel position of a direction by Newton's method: (x, y, 1), or zero outside of the field of view."""
    target = wp.normalize(p)
    position = start_position(table, width * height, target)
    # Two axes perpendicular to the target, along which the residual is measured.
    helper = wp.vec3(0.0, 0.0, 1.0)
    if wp.abs(target[2]) >= 0.9:
        helper = wp.vec3(1.0, 0.0, 0.0)
    first = wp.normalize(wp.cross(target, helper))
    second = wp.cross(target, first)
    texels = wp.array(ptr=table, shape=(width * height,), dtype=wp.vec4)
    for _step in range(NEWTON_STEPS):
        x = wp.clamp(int(wp.floor(position[0])), 0, width - 2)
        y = wp.clamp(int(wp.floor(position[1])), 0, height - 2)
        corner = y * width + x
        below = corner + width
        fraction = position[1] - float(y)
        left = wp.lerp(texels[corner], texels[below], fraction)
        across = wp.lerp(texels[corner + 1], texels[below + 1], fraction) - left
        fraction = position[0] - float(x)
        down = wp.lerp(texels[below] - texels[corner], texels[below + 1] - texels[corner + 1], fraction)
        seen = left + across * fraction
        residual = wp.vec2(dot_xyz(first, seen), dot_xyz(second, seen))
        a = dot_xyz(first, across)
        b = dot_xyz(first, down)
        c = dot_xyz(second, across)
        d = dot_xyz(second, down)
        step = wp.vec2(d * residual[0] - b * residual[1], a * residual[1] - c * residual[0]) / (a * d - b * c)
        # The first comparison is false for NaN.
        if wp.length(step) < CONVERGED and is_lit(width, height, position, seen[3]) and dot_xyz(target, seen) > 0.0:
            return wp.vec3(position[0] - step[0], position[1] - step[1], 1.0)
        position = wp.vec2(
            wp.clamp(position[0] - step[0], -BORDER, float(width) - 1.0 + BORDER),
            wp.clamp(position[1] - step[1], -BORDER, float(height) - 1.0 + BORDER),
        )
    return wp.vec3(0.0)


@wp.func
def start_position(table: wp.uint64, texels: int, target: wp.vec3):
    """Look up where the search for a direction starts, in the octahedral map."""
    rows = wp.array(ptr=table, shape=(texels + START_MAP_SIZE * START_MAP_SIZE,), dtype=wp.vec4)
    size = wp.abs(target[0]) + wp.abs(target[1]) + wp.abs(target[2])
    x = target[0] / size
    y = target[1] / size
    if target[2] > 0.0:
        across = 1.0 - wp.abs(y)
        down = 1.0 - wp.abs(x)
        x = wp.where(x >= 0.0, across, -across)
        y = wp.where(y >= 0.0, down, -down)
    column = wp.clamp(int((x * 0.5 + 0.5) * float(START_MAP_SIZE)), 0, START_MAP_SIZE - 1)
    row = wp.clamp(int((y * 0.5 + 0.5) * float(START_MAP_SIZE)), 0, START_MAP_SIZE - 1)
    start = rows[texels + row * START_MAP_SIZE + column]
    return wp.vec2(start[0], start[1])


@wp.func
def dot_xyz(axis: wp.vec3, seen: wp.vec4):
    return axis[0] * seen[0] + axis[1] * seen[1] + axis[2] * seen[2]
