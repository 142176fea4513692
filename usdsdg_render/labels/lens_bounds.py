"""Pixel bounds of world boxes in images of cameras with a lens model.

The projection of a box through a lens has no closed form. Therefore the image is divided into tiles, each with a
bounding cone of the rays of its pixels, and a box covers at most the tiles whose cones overlap its own bounding cone.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.stage.cameras.pixels import pixel_centers

if TYPE_CHECKING:
    from usdsdg.stage.cameras.camera_view import CameraView
    from usdsdg.stage.cameras.lens import Lens

TILE = 16  # pixels
# Margin of the half angles of cones [radians]: kernels compute in single precision.
_CONE_MARGIN = 1e-4
_BOXES_AT_ONCE = 256


def bound_through_lens(view: CameraView, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Bound world boxes (I, 3), (I, 3) by pixel rectangles (I, 4) int32: x0, y0, x1, y1 (exclusive)."""
    lens = view.lens
    assert lens is not None
    axes, angles = _tile_cones(lens)
    size = np.array([view.width, view.height])
    result = np.zeros((len(lower), 4), np.int32)
    with np.errstate(divide="ignore", invalid="ignore"):
        in_camera = (lower + upper) / 2 @ view.world_to_camera[:3, :3] + view.world_to_camera[3, :3]
        # The eyes of a stereo panorama lie on a circle: its radius is added to that of the box.
        radius = np.linalg.norm(upper - lower, axis=1) / 2 + abs(lens.eye_offset)
        distance = np.linalg.norm(in_camera, axis=1)
        half = np.where(distance > radius, np.arcsin(np.minimum(radius / distance, 1.0)), np.pi)
        toward = np.where(distance[:, None] > 0, in_camera / distance[:, None], 0.0)
    for first in range(0, len(lower), _BOXES_AT_ONCE):
        batch = slice(first, first + _BOXES_AT_ONCE)
        between = np.arccos(np.clip(np.einsum("ij,rcj->irc", toward[batch], axes), -1.0, 1.0))
        overlap = between <= half[batch, None, None] + angles
        for index, tiles in enumerate(overlap, first):
            rows, columns = np.flatnonzero(tiles.any(axis=1)), np.flatnonzero(tiles.any(axis=0))
            if len(rows):
                ends = np.minimum(((columns[-1] + 1) * TILE, (rows[-1] + 1) * TILE), size)
                result[index] = columns[0] * TILE, rows[0] * TILE, *ends
    return result


@lru_cache(maxsize=16)
def _tile_cones(lens: Lens) -> tuple[np.ndarray, np.ndarray]:
    """Return the bounding cone of the rays of each tile.

    Axes (rows, columns, 3) in the camera's frame, and half angles (rows, columns) [radians]; -4 for tiles without rays,
    which overlap no cone.
    """
    rows, columns = -(-lens.height // TILE), -(-lens.width // TILE)
    y, x = np.mgrid[: rows * TILE, : columns * TILE]
    # Pixels of the last tiles beyond the image repeat its last pixels.
    pixels = pixel_centers(np.minimum(x, lens.width - 1), np.minimum(y, lens.height - 1))
    rays = lens.to_directions(pixels.reshape(-1, 2)).reshape(rows, TILE, columns, TILE, 3)
    rays = rays.transpose(0, 2, 1, 3, 4).reshape(rows, columns, TILE * TILE, 3)
    valid = np.all(np.isfinite(rays), axis=-1)
    rays = np.where(valid[..., None], rays, 0.0)
    middle = rays.sum(axis=2)
    length = np.linalg.norm(middle, axis=-1, keepdims=True)
    # If the mean direction vanishes, any axis will do: the cone holds all directions.
    axes = np.where(length > 1e-9, middle / np.maximum(length, 1e-9), (0.0, 0.0, -1.0))
    cosines = np.where(valid, (rays * axes[:, :, None]).sum(axis=-1), 1.0)
    angles = np.arccos(np.clip(cosines.min(axis=2), -1.0, 1.0)) + _CONE_MARGIN
    return axes, np.where(valid.any(axis=2), angles, -4.0)
