"""Octagons around what each instance can cover in the picture of a camera without a lens.

The planes through the eye that touch an instance cut the picture in its tangents. Points of it reach
f(c) = max(aX + bY - cZ) beyond the line aX/Z + bY/Z = c; f falls with c, by no less than the least depth of the
instance and no more than the largest, and bends upwards. So a secant through two points before the tangent ends before
it, too, and what is left from there is at most f(c) over the least depth.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from usdsdg_render.device import DeviceScene

if TYPE_CHECKING:
    from usdsdg.stage.cameras import CameraView

# Weights of column and row: those of LINES have an upper bound each, and a lower one by their opposites.
LINES = np.array([(1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, -1.0)])
_SIDES = np.concatenate([LINES, -LINES])
# Pixels around what is found, for rounding.
MARGIN = 1.0
# Lines that are tried across a picture where there is no tangent.
ROUGHLY = 33


def octagons(device_scene: DeviceScene, view: CameraView, tested: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(I, 4) lower and upper bounds of each line over the pixels of instances `tested`, (I,).

    What is out of sight has bounds that cross; what lies around the camera may be anywhere.
    """
    to_world, eye = view.world_to_camera[:3, :3].T, view.local_to_world[3, :3]

    def reaches(directions: np.ndarray, some: np.ndarray | slice = slice(None)) -> np.ndarray:
        """(I, K) of (some of) the instances from the eye, along (I, K, 3) directions in the camera's frame."""
        return device_scene.reaches(tested[some], directions @ to_world, eye)

    axis = np.broadcast_to([(0.0, 0.0, -1.0), (0.0, 0.0, 1.0)], (len(tested), 2, 3))
    deepest, nearest = reaches(axis).T * ((1.0,), (-1.0,))
    near, far = view.clipping_range
    sideways = np.zeros((len(tested), 8, 3))
    sideways[..., :2] = _SIDES * (view.fx, -view.fy)
    anywhere = np.zeros(len(tested), bool)
    if view.projection_type == "orthographic":
        ends = reaches(sideways)
    else:
        anywhere = nearest <= max(near * 0.5, 1e-12)
        depths = np.where(anywhere, 1.0, nearest), np.where(anywhere, 1.0, np.maximum(deepest, nearest))
        ends = _tangents(reaches, sideways, *depths)
        ends[anywhere] = _beside(reaches, sideways, anywhere, view)
    ends += _SIDES @ (view.cx, view.cy) + MARGIN
    ends[(deepest < near * 0.999) | (nearest > far * 1.001)] = -np.inf
    return -ends[:, 4:], ends[:, :4]


def _beside(reaches, sideways: np.ndarray, some: np.ndarray, view: CameraView) -> np.ndarray:
    """As `_tangents`, roughly, of some instances that may reach behind the camera.

    Of lines across the picture it is the first that they are wholly on one side of, or infinity.
    """
    corners = np.array([(column, row) for column in (0, view.width) for row in (0, view.height)]) - (view.cx, view.cy)
    along = corners @ _SIDES.T
    places = np.linspace(along.min(0), along.max(0), ROUGHLY)
    ends = np.full((some.sum(), len(_SIDES)), np.inf)
    for place in places[::-1]:
        directions = sideways[some]
        directions[..., 2] = place
        ends = np.where(reaches(directions, some) <= 0.0, place, ends)
    return ends


def _tangents(reaches, sideways: np.ndarray, least: np.ndarray, most: np.ndarray) -> np.ndarray:
    """(I, 8) where the tangents lie, or a little beyond, of instances with these depths (I,)."""
    least, most = least[:, None], most[:, None]

    def beyond(c: np.ndarray) -> np.ndarray:
        directions = sideways.copy()
        directions[..., 2] = c  # depth is -z
        return reaches(directions)

    straight = beyond(np.zeros(sideways.shape[:2]))
    first = straight / np.where(straight > 0.0, most, least)
    left = beyond(first)
    second = first + left / most
    left_there = beyond(second)
    step = np.maximum(second - first, 1e-300)
    third = second + left_there / np.clip((left - left_there) / step, least, most)
    return third + np.maximum(beyond(third), 0.0) / least
