"""Which pixels a box can reach through a lens that is no pinhole.

The outline of a box has no short formula there. So the picture is cut into tiles, each with a cone around the rays of
its pixels, and a tile is reached where its cone and the one around the box overlap.
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
# Radians added to every cone: kernels compute in single precision.
_ROUNDING = 1e-4
_BOXES_AT_ONCE = 256


def reachable(view: CameraView, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """(I, 4) int32 pixel rectangles x0, y0, x1, y1 (exclusive) that hold all of each world box (I, 3), (I, 3)."""
    lens = view.lens
    assert lens is not None
    axes, angles = _cones(lens)
    size = np.array([view.width, view.height])
    result = np.zeros((len(lower), 4), np.int32)
    with np.errstate(divide="ignore", invalid="ignore"):
        in_camera = (lower + upper) / 2 @ view.world_to_camera[:3, :3] + view.world_to_camera[3, :3]
        # Seen from the circle that an eye goes round, a box is where one larger by its radius is from the middle.
        radius = np.linalg.norm(upper - lower, axis=1) / 2 + abs(lens.eye_offset)
        away = np.linalg.norm(in_camera, axis=1)
        half = np.where(away > radius, np.arcsin(np.minimum(radius / away, 1.0)), np.pi)
        towards = np.where(away[:, None] > 0, in_camera / away[:, None], 0.0)
    for first in range(0, len(lower), _BOXES_AT_ONCE):
        some = slice(first, first + _BOXES_AT_ONCE)
        between = np.arccos(np.clip(np.einsum("ij,rcj->irc", towards[some], axes), -1.0, 1.0))
        reached = between <= half[some, None, None] + angles
        for index, tiles in enumerate(reached, first):
            rows, columns = np.flatnonzero(tiles.any(axis=1)), np.flatnonzero(tiles.any(axis=0))
            if len(rows):
                ends = np.minimum(((columns[-1] + 1) * TILE, (rows[-1] + 1) * TILE), size)
                result[index] = columns[0] * TILE, rows[0] * TILE, *ends
    return result


@lru_cache(maxsize=16)
def _cones(lens: Lens) -> tuple[np.ndarray, np.ndarray]:
    """Per tile the axis (rows, columns, 3), in the camera's frame, and the half angle of a cone around its rays; -4 for
    a tile without rays, which nothing reaches.
    """
    rows, columns = -(-lens.height // TILE), -(-lens.width // TILE)
    y, x = np.mgrid[: rows * TILE, : columns * TILE]
    # The last tiles' missing pixels repeat the last there are.
    pixels = pixel_centers(np.minimum(x, lens.width - 1), np.minimum(y, lens.height - 1))
    rays = lens.to_directions(pixels.reshape(-1, 2)).reshape(rows, TILE, columns, TILE, 3)
    rays = rays.transpose(0, 2, 1, 3, 4).reshape(rows, columns, TILE * TILE, 3)
    there = np.isfinite(rays).all(axis=-1)
    rays = np.where(there[..., None], rays, 0.0)
    middle = rays.sum(axis=2)
    length = np.linalg.norm(middle, axis=-1, keepdims=True)
    # Rays all around have no middle: any axis will do, with a cone of everything.
    axes = np.where(length > 1e-9, middle / np.maximum(length, 1e-9), (0.0, 0.0, -1.0))
    cosines = np.where(there, (rays * axes[:, :, None]).sum(axis=-1), 1.0)
    angles = np.arccos(np.clip(cosines.min(axis=2), -1.0, 1.0)) + _ROUNDING
    return axes, np.where(there.any(axis=2), angles, -4.0)
