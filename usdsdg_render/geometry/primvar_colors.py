"""displayColor and displayOpacity that vary over a gprim, as a picture of their own.

Every triangle has a block of texels whose colors continue those of its corners over a square, so that the renderer's
bilinear look-up is the interpolation over the triangle. Beyond the far edge the continuation may leave [0, 1] and is
clipped, which shows the less the finer the block. The texture coordinates of the gprim point there; it has no other use
for them, since only gprims without textures are drawn so.
"""

from __future__ import annotations

import hashlib
from dataclasses import replace

import numpy as np
from pxr import Usd

from usdsdg_render.geometry.mesh_source import read_primvar
from usdsdg_render.images.textures import TextureUse, linear_to_srgb
from usdsdg_render.materials.shading import Input, Material
from usdsdg_render.scene.scene import WRAP_CLAMP, Prototype, Texture

# (most triangles, texels along a side of a block): the finest that fits counts.
SIDES = ((50_000, 8), (500_000, 4), (10**12, 2))
WIDTH = 4096  # texels in a row, at most


def block_uvs(count: int) -> np.ndarray:
    """(T, 3, 2) float32: the texels' centers for the corners of so many triangles."""
    side, columns, rows = _layout(count)
    block = np.arange(count)
    origin = side * np.stack([block % columns, block // columns], axis=-1)
    corner = np.array([[0, 0], [side - 1, 0], [0, side - 1]])
    texel = origin[:, None] + corner + 0.5
    return np.stack([texel[..., 0] / (columns * side), 1.0 - texel[..., 1] / (rows * side)], -1).astype(np.float32)


def picture(colors: np.ndarray) -> np.ndarray:
    """(H, W, 4) uint8 sRGB-coded texels of (T, 3, 4) linear colors and opacities; row 0 is the top."""
    side, columns, rows = _layout(len(colors))
    step = np.arange(side, dtype=np.float32) / (side - 1)
    first, along, down = colors[:, 0], colors[:, 1] - colors[:, 0], colors[:, 2] - colors[:, 0]
    block = first[:, None, None] + along[:, None, None] * step[:, None] + down[:, None, None] * step[:, None, None]
    block = np.clip(block, 0.0, 1.0)
    block[..., :3] = linear_to_srgb(block[..., :3])
    padded = np.zeros((rows * columns, side, side, 4), np.uint8)
    padded[: len(block)] = np.round(block * 255.0)
    blocks = padded.reshape(rows, columns, side, side, 4)
    return np.ascontiguousarray(blocks.transpose(0, 2, 1, 3, 4)).reshape(rows * side, columns * side, 4)


def _layout(count: int) -> tuple[int, int, int]:
    """Texels along a side of a block, blocks in a row, rows of blocks."""
    side = next(side for most, side in SIDES if count <= most)
    columns = min(count, WIDTH // side)
    return side, columns, -(-count // columns)


def of_elements(prim: Usd.Prim, time: Usd.TimeCode, elements: np.ndarray, interpolations: tuple[str, ...]):
    """(N, 4) float32 colors of elements of a gprim; None where both are of another interpolation or too few."""
    columns = []
    for name, width in (("displayColor", 3), ("displayOpacity", 1)):
        primvar = read_primvar(prim, f"primvars:{name}", time, (3,) if width == 3 else ())
        where = elements
        if primvar is None:
            columns.append(np.ones((len(elements), width), np.float32) * (1.0 if width == 1 else 0.5))
            continue
        if primvar.interpolation == "constant" or len(primvar.values) == 1:
            where = np.zeros_like(elements)
        elif primvar.interpolation not in interpolations:
            return None
        if len(primvar.indices) and primvar.interpolation != "constant":
            if where.max(initial=0) >= len(primvar.indices):
                return None
            where = primvar.indices[where]
        if where.max(initial=0) >= len(primvar.values) or where.min(initial=0) < 0:
            return None
        columns.append(primvar.values[where].reshape(-1, width))
    return np.nan_to_num(np.concatenate(columns, axis=1).astype(np.float32))


class ColorPictures:
    """The pictures of prototypes with colors, made when first asked for."""

    def __init__(self) -> None:
        self._made: dict[int, tuple[Prototype, TextureUse, Texture]] = {}

    def painted(self, material: Material, prototype: Prototype) -> Material:
        """The material with the prototype's colors, and its opacities where the material has none of its own."""
        assert prototype.corner_colors is not None
        _, use, _ = self._of(prototype)
        painted = replace(material, base_color=Input((1.0, 1.0, 1.0), texture=use), uv_primvar="")
        if material.name == "displayColor" and (prototype.corner_colors[..., 3] < 1.0).any():
            painted = replace(painted, opacity=Input((1.0,), texture=use, channel=3))
        return painted

    def textures(self) -> list[tuple[TextureUse, Texture]]:
        """All pictures made so far."""
        return [(use, texture) for _, use, texture in self._made.values()]

    def keep_only(self, prototypes: set[int]) -> None:
        """Forget those of other prototypes (by id)."""
        self._made = {key: made for key, made in self._made.items() if key in prototypes}

    def _of(self, prototype: Prototype) -> tuple[Prototype, TextureUse, Texture]:
        if id(prototype) not in self._made:
            texels = picture(prototype.corner_colors)
            name = (
                f"{prototype.name}.primvars:displayColor#{hashlib.blake2b(texels.tobytes(), digest_size=8).hexdigest()}"
            )
            use = TextureUse(name, color_space="sRGB", wrap_s=WRAP_CLAMP, wrap_t=WRAP_CLAMP)
            self._made[id(prototype)] = (prototype, use, Texture(name, texels, True, WRAP_CLAMP, WRAP_CLAMP))
        return self._made[id(prototype)]
