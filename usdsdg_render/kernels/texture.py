"""Looking up textures and the sky: bilinear, with USD's wrap modes."""

import warp as wp

from usdsdg_render import scene
from usdsdg_render.kernels.types import Dome, SceneTables, Texture

WRAP_REPEAT = wp.constant(scene.WRAP_REPEAT)
WRAP_MIRROR = wp.constant(scene.WRAP_MIRROR)
WRAP_BLACK = wp.constant(scene.WRAP_BLACK)
PI = wp.constant(wp.pi)


@wp.func_native("return ((const wp::uint32*)address)[index];")
def word_at(address: wp.uint64, index: int) -> wp.uint32: ...


@wp.func
def fold(u: float, mode: int):
    """Bring a coordinate into the image, [0, 1]; black keeps a margin of one image that reads as black."""
    if mode == WRAP_REPEAT:
        return u - wp.floor(u)
    if mode == WRAP_MIRROR:
        return 1.0 - wp.abs(1.0 - (u - 2.0 * wp.floor(0.5 * u)))
    if mode == WRAP_BLACK:
        return wp.clamp(u, -1.0, 2.0)
    return wp.clamp(u, 0.0, 1.0)


@wp.func
def neighbour(i: int, n: int, mode: int):
    """Texel index inside the image; -1 reads as black."""
    if i >= 0 and i < n:
        return i
    if mode == WRAP_BLACK:
        return -1
    if mode == WRAP_REPEAT:
        if i < 0:
            return n - 1
        return 0
    return wp.clamp(i, 0, n - 1)


@wp.func
def texel(tables: SceneTables, texture: Texture, x: int, y: int):
    """RGBA of one texel, linear, in [0, 1]."""
    if x < 0 or y < 0:
        return wp.vec4(0.0)
    word = word_at(texture.texels, y * texture.width + x)
    r = int(word & wp.uint32(255))
    g = int((word >> wp.uint32(8)) & wp.uint32(255))
    b = int((word >> wp.uint32(16)) & wp.uint32(255))
    a = float(word >> wp.uint32(24)) / 255.0
    if texture.srgb != 0:
        return wp.vec4(tables.srgb_to_linear[r], tables.srgb_to_linear[g], tables.srgb_to_linear[b], a)
    return wp.vec4(float(r) / 255.0, float(g) / 255.0, float(b) / 255.0, a)


@wp.func
def lookup(tables: SceneTables, index: int, uv: wp.vec2):
    """RGBA of a texture at uv; v = 1 is the top row."""
    texture = tables.textures[index]
    x = fold(uv[0], texture.wrap_s) * float(texture.width) - 0.5
    y = (1.0 - fold(uv[1], texture.wrap_t)) * float(texture.height) - 0.5
    x_floor = wp.floor(x)
    y_floor = wp.floor(y)
    fx = x - x_floor
    fy = y - y_floor
    x0 = neighbour(int(x_floor), texture.width, texture.wrap_s)
    x1 = neighbour(int(x_floor) + 1, texture.width, texture.wrap_s)
    y0 = neighbour(int(y_floor), texture.height, texture.wrap_t)
    y1 = neighbour(int(y_floor) + 1, texture.height, texture.wrap_t)
    top = texel(tables, texture, x0, y0) * (1.0 - fx) + texel(tables, texture, x1, y0) * fx
    bottom = texel(tables, texture, x0, y1) * (1.0 - fx) + texel(tables, texture, x1, y1) * fx
    return top * (1.0 - fy) + bottom * fy


@wp.func
def channel(rgba: wp.vec4, index: int):
    return rgba[wp.clamp(index, 0, 3)]


@wp.func
def sky_coordinates(dome: Dome, direction: wp.vec3):
    """Where a world direction lies in the sky: (u around, v from the pole), both in [0, 1]."""
    d = dome.dome_from_world * direction
    u = wp.atan2(d[1], d[0]) / (2.0 * PI)
    if u < 0.0:
        u += 1.0
    return wp.vec2(u, wp.acos(wp.clamp(d[2], -1.0, 1.0)) / PI)


@wp.func
def sky_radiance(dome: Dome, uv: wp.vec2):
    """Bilinear radiance of the sky [nits]: around it repeats, at the poles it stops."""
    x = uv[0] * float(dome.width) - 0.5
    y = uv[1] * float(dome.height) - 0.5
    x_floor = wp.floor(x)
    y_floor = wp.floor(y)
    fx = x - x_floor
    fy = y - y_floor
    x0 = neighbour(int(x_floor), dome.width, WRAP_REPEAT)
    x1 = neighbour(int(x_floor) + 1, dome.width, WRAP_REPEAT)
    y0 = wp.clamp(int(y_floor), 0, dome.height - 1) * dome.width
    y1 = wp.clamp(int(y_floor) + 1, 0, dome.height - 1) * dome.width
    top = dome.radiance[y0 + x0] * (1.0 - fx) + dome.radiance[y0 + x1] * fx
    bottom = dome.radiance[y1 + x0] * (1.0 - fx) + dome.radiance[y1 + x1] * fx
    return top * (1.0 - fy) + bottom * fy
