"""Lenses that a picture of directions describes: `usdsdg.stage.cameras.lens_tables` for kernels.

A table is its texels, row by row, and then an octahedral map of places where the search for a direction begins.
"""

import warp as wp

from usdsdg.stage.cameras.lens_tables import DARK, RINGS, START_SIZE

SIDE = wp.constant(START_SIZE)
SHARE_OF_DARK = wp.constant(DARK)
AROUND = wp.constant(float(RINGS))
STEPS = wp.constant(20)  # more than Warp unrolls
STILL = wp.constant(2.0e-4)  # texels


@wp.func
def is_lit(width: int, height: int, place: wp.vec2, light: float):
    across = place[0] > -0.5 - SHARE_OF_DARK and place[0] < float(width) - 0.5 + SHARE_OF_DARK
    down = place[1] > -0.5 - SHARE_OF_DARK and place[1] < float(height) - 0.5 + SHARE_OF_DARK
    return across and down and wp.abs(light - 1.0) < SHARE_OF_DARK


@wp.func
def table_direction(table: wp.uint64, width: int, height: int, place: wp.vec2):
    """Unit direction at a place; zero where no light comes in."""
    texels = wp.array(ptr=table, shape=(width * height,), dtype=wp.vec4)
    x = wp.clamp(int(wp.floor(place[0])), 0, width - 2)
    y = wp.clamp(int(wp.floor(place[1])), 0, height - 2)
    first = y * width + x
    across = place[0] - float(x)
    above = wp.lerp(texels[first], texels[first + 1], across)
    below = wp.lerp(texels[first + width], texels[first + width + 1], across)
    seen = wp.lerp(above, below, place[1] - float(y))
    if not is_lit(width, height, place, seen[3]):
        return wp.vec3(0.0)
    return wp.normalize(wp.vec3(seen[0], seen[1], seen[2]))


@wp.func
def table_place(table: wp.uint64, width: int, height: int, p: wp.vec3):
    """Where a direction is: (x, y, 1), or zero for what the lens does not see."""
    target = wp.normalize(p)
    place = start_of(table, width * height, target)
    # Two axes across the target, along which the miss is measured.
    other = wp.vec3(0.0, 0.0, 1.0)
    if wp.abs(target[2]) >= 0.9:
        other = wp.vec3(1.0, 0.0, 0.0)
    first = wp.normalize(wp.cross(target, other))
    second = wp.cross(target, first)
    texels = wp.array(ptr=table, shape=(width * height,), dtype=wp.vec4)
    for _step in range(STEPS):
        x = wp.clamp(int(wp.floor(place[0])), 0, width - 2)
        y = wp.clamp(int(wp.floor(place[1])), 0, height - 2)
        corner = y * width + x
        below = corner + width
        share = place[1] - float(y)
        left = wp.lerp(texels[corner], texels[below], share)
        across = wp.lerp(texels[corner + 1], texels[below + 1], share) - left
        share = place[0] - float(x)
        down = wp.lerp(texels[below] - texels[corner], texels[below + 1] - texels[corner + 1], share)
        seen = left + across * share
        miss = wp.vec2(along(first, seen), along(second, seen))
        a = along(first, across)
        b = along(first, down)
        c = along(second, across)
        d = along(second, down)
        step = wp.vec2(d * miss[0] - b * miss[1], a * miss[1] - c * miss[0]) / (a * d - b * c)
        # The first comparison fails for what is not a number.
        if wp.length(step) < STILL and is_lit(width, height, place, seen[3]) and along(target, seen) > 0.0:
            return wp.vec3(place[0] - step[0], place[1] - step[1], 1.0)
        place = wp.vec2(
            wp.clamp(place[0] - step[0], -AROUND, float(width) - 1.0 + AROUND),
            wp.clamp(place[1] - step[1], -AROUND, float(height) - 1.0 + AROUND),
        )
    return wp.vec3(0.0)


@wp.func
def start_of(table: wp.uint64, texels: int, target: wp.vec3):
    rows = wp.array(ptr=table, shape=(texels + SIDE * SIDE,), dtype=wp.vec4)
    size = wp.abs(target[0]) + wp.abs(target[1]) + wp.abs(target[2])
    x = target[0] / size
    y = target[1] / size
    if target[2] > 0.0:
        across = 1.0 - wp.abs(y)
        down = 1.0 - wp.abs(x)
        x = wp.where(x >= 0.0, across, -across)
        y = wp.where(y >= 0.0, down, -down)
    column = wp.clamp(int((x * 0.5 + 0.5) * float(SIDE)), 0, SIDE - 1)
    row = wp.clamp(int((y * 0.5 + 0.5) * float(SIDE)), 0, SIDE - 1)
    start = rows[texels + row * SIDE + column]
    return wp.vec2(start[0], start[1])


@wp.func
def along(axis: wp.vec3, seen: wp.vec4):
    return axis[0] * seen[0] + axis[1] * seen[1] + axis[2] * seen[2]
