"""Texture atlas of displayColor and displayOpacity that vary over a gprim: one square block of texels per triangle.

The texels of a block extrapolate the colors of the triangle's vertices linearly, so that the renderer's bilinear
look-up gives the interpolation over the triangle. In the half of the block outside of the triangle the extrapolation
may leave [0, 1] and is clamped, which shows less the finer the block. The gprim's texture coordinates refer to the
atlas; they are free, since only gprims without textures get one.
"""

import numpy as np

from usdsdg.stage.colors import linear_to_srgb

# (most triangles, texels along a side of a block): the first row that fits counts.
BLOCK_SIZES = ((50_000, 8), (500_000, 4), (10**12, 2))
MAX_WIDTH = 4096  # texels


def atlas_uvs(count: int) -> np.ndarray:
    """(T, 3, 2) float32 texture coordinates of `count` triangles: centers of the texels at their vertices."""
    side, columns, rows = _layout(count)
    block = np.arange(count)
    origin = side * np.stack([block % columns, block // columns], axis=-1)
    corner = np.array([[0, 0], [side - 1, 0], [0, side - 1]])
    texel = origin[:, None] + corner + 0.5
    return np.stack([texel[..., 0] / (columns * side), 1.0 - texel[..., 1] / (rows * side)], -1).astype(np.float32)


def color_atlas(colors: np.ndarray) -> np.ndarray:
    """(H, W, 4) uint8 sRGB-coded texels, row 0 at the top, of (T, 3, 4) linear colors and opacities."""
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
    side = next(side for most, side in BLOCK_SIZES if count <= most)
    columns = min(count, MAX_WIDTH // side)
    return side, columns, -(-count // columns)
