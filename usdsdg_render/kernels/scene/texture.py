"""Look-up of textures (bilinear, USD's wrap modes, UV transform) and of the environment map."""

from pathlib import Path

import warp as wp

from usdsdg_render.kernels.trig import acos_over_pi, azimuth_turns
from usdsdg_render.scene.structs import Dome, SceneTables, Texture

# Shared-exponent format: three mantissas of nine bits and an exponent of five (see `environment.packed`).
_UNPACKED = """
    const wp::uint32 word = words.data[index], bits = ((word >> 27) + 127u) << 23;
    float power;
    memcpy(&power, &bits, 4);
    return wp::vec_t<3, wp::float32>(
        (word & 511u) * (power * unit[0]), ((word >> 9) & 511u) * (power * unit[1]),
        ((word >> 18) & 511u) * (power * unit[2]));
"""


@wp.func_native(_UNPACKED)
def unpacked(words: wp.array(dtype=wp.uint32), unit: wp.vec3, index: int) -> wp.vec3: ...


# Not inlined: copies in every caller would push the path tracer out of the instruction cache.
_LOOKUP = Path(__file__).with_name("lookup.cpp").read_text()


@wp.func_native(_LOOKUP)
def lookup_texture(
    textures: wp.array(dtype=Texture), texel_values: wp.array(dtype=wp.float32), index: int, u: float, v: float
) -> wp.vec4: ...


@wp.func
def lookup(tables: SceneTables, index: int, uv: wp.vec2):
    """Look up the RGBA of a texture at a surface's uv, linear, not negative; v = 1 is the top row."""
    return lookup_texture(tables.textures, tables.texel_values, index, uv[0], uv[1])


@wp.func
def channel(rgba: wp.vec4, index: int):
    return rgba[wp.clamp(index, 0, 3)]


@wp.func
def environment_uv(dome: Dome, direction: wp.vec3):
    """Map a world direction to environment coordinates: (u around, v from the pole), both in [0, 1]."""
    d = dome.dome_from_world * direction
    return wp.vec2(azimuth_turns(d[0], d[1]), acos_over_pi(d[2]))


@wp.func
def environment_cell(dome: Dome, uv: wp.vec2):
    """Return the index of the grid cell at environment coordinates."""
    x = wp.clamp(int(uv[0] * float(dome.grid_width)), 0, dome.grid_width - 1)
    y = wp.clamp(int(uv[1] * float(dome.grid_height)), 0, dome.grid_height - 1)
    return y * dome.grid_width + x


@wp.func
def cell_radiance(dome: Dome, cell: int):
    """Return the mean radiance of a grid cell [nits]."""
    return unpacked(dome.cells, dome.unit, 2 * cell)


@wp.func
def cell_pdf(dome: Dome, cell: int):
    """Return the pdf of `sample_environment` for directions in a cell [1/sr]."""
    return wp.cast(dome.cells[2 * cell + 1], wp.float32)


@wp.func
def environment_radiance(dome: Dome, uv: wp.vec2):
    """Look up radiance bilinearly [nits]: u wraps around, v is clamped at the poles."""
    x = uv[0] * float(dome.width) - 0.5
    y = uv[1] * float(dome.height) - 0.5
    x_floor = wp.floor(x)
    y_floor = wp.floor(y)
    fx = x - x_floor
    fy = y - y_floor
    x0 = int(x_floor)
    x1 = x0 + 1
    if x0 < 0:
        x0 = dome.width - 1
    if x1 >= dome.width:
        x1 = 0
    y0 = wp.clamp(int(y_floor), 0, dome.height - 1) * dome.width
    y1 = wp.clamp(int(y_floor) + 1, 0, dome.height - 1) * dome.width
    top = unpacked(dome.texels, dome.unit, y0 + x0) * (1.0 - fx) + unpacked(dome.texels, dome.unit, y0 + x1) * fx
    bottom = unpacked(dome.texels, dome.unit, y1 + x0) * (1.0 - fx) + unpacked(dome.texels, dome.unit, y1 + x1) * fx
    return top * (1.0 - fy) + bottom * fy


@wp.func
def environment_background(dome: Dome, uv: wp.vec2):
    """Look up the radiance that camera rays see [nits].

    Images often magnify texels, where bilinear interpolation gives stair-stepped edges. This is a Catmull-Rom spline,
    clamped to the four nearest texels so that bright texels get no dark ring.
    """
    x = uv[0] * float(dome.width) - 0.5
    y = uv[1] * float(dome.height) - 0.5
    x_floor = wp.floor(x)
    y_floor = wp.floor(y)
    total = wp.vec3(0.0)
    lowest = wp.vec3(1.0e30)
    highest = wp.vec3(0.0)
    for j in range(4):
        row = wp.clamp(int(y_floor) + j - 1, 0, dome.height - 1) * dome.width
        along = wp.vec3(0.0)
        for i in range(4):
            column = (int(x_floor) + i - 1 + dome.width) % dome.width
            texel = unpacked(dome.texels, dome.unit, row + column)
            along += texel * catmull_rom(x - x_floor - float(i - 1))
            if (i == 1 or i == 2) and (j == 1 or j == 2):
                lowest = wp.min(lowest, texel)
                highest = wp.max(highest, texel)
        total += along * catmull_rom(y - y_floor - float(j - 1))
    return wp.min(wp.max(total, lowest), highest)


@wp.func
def catmull_rom(distance: float):
    """Return the weight of a texel at a distance [texels]."""
    d = wp.abs(distance)
    near = (1.5 * d - 2.5) * d * d + 1.0
    far = ((-0.5 * d + 2.5) * d - 4.0) * d + 2.0
    return wp.where(d < 1.0, near, wp.where(d < 2.0, far, 0.0))
