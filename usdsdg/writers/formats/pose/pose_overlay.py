"""The debug image of poses: boxes, keypoints and axes drawn over the color image."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from usdsdg.writers.formats.shapes import cuboid
from usdsdg.writers.formats.shapes.camera_projection import edge_pixels, in_front, project
from usdsdg.writers.formats.shapes.drawing import Canvas, Color

RED, GREEN, BLUE = (255, 0, 0), (0, 128, 0), (0, 0, 255)
# Of the keypoints, in the order of the file.
KEYPOINT_COLORS: tuple[Color, ...] = (
    (255, 255, 255),
    RED,
    GREEN,
    BLUE,
    (255, 255, 0),
    (0, 255, 255),
    (255, 0, 255),
    (255, 165, 0),
    (128, 0, 128),
)
_EDGE_COLORS = {"front": RED, "back": BLUE, "connecting": GREEN}
_AXIS_COLORS = (RED, GREEN, BLUE)
_POINT_RADIUS, _LINE_WIDTH = 4.0, 2.0
# Of the world's axes: length at distance one, and their distance from the corner in shorter sides of the image.
_WORLD_AXIS_LENGTH, _WORLD_AXES_MARGIN = 0.03, 0.03
_SHADOW: Color = (0, 0, 0)


@dataclass(frozen=True)
class PosedBox:
    """The drawn geometry of one object, in the camera's frame."""

    keypoints: Mapping[str, np.ndarray]  # name → (3,), in the order of the file
    axes: np.ndarray  # (3, 2, 3) segments from the box center along the object's own axes


def draw_overlay(image: np.ndarray, boxes: Sequence[PosedBox], params: Mapping[str, Any]) -> np.ndarray:
    """Draw `boxes`, far ones first, and the world's axes over `image` (H, W, 4)."""
    canvas = Canvas(image)
    boxes = sorted(boxes, key=lambda b: b.keypoints[cuboid.CENTER][2])
    # Of all boxes at once, since a call costs more than what it computes.
    edges = [_edges(box) for box in boxes]
    pixels = iter(edge_pixels(np.array([edge for each in edges for edge, _ in each]).reshape(-1, 2, 3), params))
    points = np.array([list(box.keypoints.values()) for box in boxes]).reshape(-1, 3)
    centers = zip(in_front(np.stack([points, points], axis=1), params), project(points, params))
    for each in edges:
        for _, color in each:
            _draw_edge(canvas, next(pixels), color)
        for color, (is_seen, center) in zip(KEYPOINT_COLORS, centers):
            if is_seen:  # keypoints behind the camera have no pixel
                canvas.disc(center, _SHADOW, radius=_POINT_RADIUS + 1, opacity=0.5)
                canvas.disc(center, color, radius=_POINT_RADIUS)
    _draw_world_axes(canvas, params)
    return canvas.image()


def _edges(box: PosedBox) -> list[tuple[np.ndarray, Color]]:
    """Return the edges (2, 3) of a box, far ones first, and its axes, each with its color."""
    edges = [
        (np.array([box.keypoints[a], box.keypoints[b]]), _EDGE_COLORS[face])
        for face, pairs in cuboid.EDGES.items()
        for a, b in pairs
    ]
    return sorted(edges, key=lambda edge: edge[0][:, 2].sum()) + list(zip(box.axes, _AXIS_COLORS))


def _draw_edge(canvas: Canvas, pixels: np.ndarray, color: Color) -> None:
    """Draw the line segments (N, 2, 2) of an edge."""
    # A thin dark border separates the line from a background of the same color.
    for start, end in pixels:
        canvas.line(start, end, _SHADOW, width=_LINE_WIDTH + 1.5, opacity=0.35)
    for start, end in pixels:
        canvas.line(start, end, color, width=_LINE_WIDTH)


def _draw_world_axes(canvas: Canvas, params: Mapping[str, Any]) -> None:
    """Draw the world's axes in the camera's orientation in the bottom left corner."""
    view = np.asarray(params["cameraViewTransform"], np.float64).reshape(4, 4)
    # Beyond the near plane; the size in the image does not depend on it.
    away = max(1.0, 2 * float(params["cameraNearFar"][0]))
    origin = np.array([0.0, 0.0, -1.0])
    points = project(
        np.stack([origin, *(origin + _WORLD_AXIS_LENGTH * view[axis, :3] for axis in range(3))]) * away, params
    )
    gap = _WORLD_AXES_MARGIN * min(canvas.width, canvas.height)
    points += np.array([gap - points[:, 0].min(), canvas.height - gap - points[:, 1].max()])
    # Axes that point away from the viewer are drawn first.
    for axis in np.argsort(view[:3, 2]):
        canvas.line(points[0], points[axis + 1], _SHADOW, width=_LINE_WIDTH + 1.5, opacity=0.35)
        canvas.line(points[0], points[axis + 1], _AXIS_COLORS[axis], width=_LINE_WIDTH)
