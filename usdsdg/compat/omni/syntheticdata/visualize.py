"""`omni.syntheticdata.visualize`: sensors as images of colors."""

import colorsys
from typing import Any

import numpy as np

from usdsdg.compat.omni.syntheticdata import sensors
from usdsdg.compat.omni.syntheticdata.sensors import RenderView

__all__ = [
    "colorize_bboxes", "colorize_bboxes_3d", "colorize_distance", "colorize_segmentation", "get_bbox2d_loose",
    "get_bbox2d_tight", "get_bbox3d", "get_depth", "get_distance", "get_instance_segmentation", "get_motion_vector",
    "get_normals", "get_semantic_segmentation", "random_colours",
]  # fmt: skip

# Pairs of corners, in the order of `helpers.get_bbox_3d_corners`, that differ along one axis.
_EDGES = [(a, a | bit) for bit in (1, 2, 4) for a in range(8) if not a & bit]


def random_colours(N: int, enable_random: bool = True, num_channels: int = 3) -> list[tuple[int, ...]]:
    """Return N colors, 0 to 255, of evenly spaced hues; the same ones every time."""
    hues = (index / max(N, 1) for index in range(N))
    colors = (colorsys.hsv_to_rgb(hue, 1.0, 1.0 if k % 2 else 0.7) for k, hue in enumerate(hues))
    return [(*(round(255 * each) for each in color), 255)[:num_channels] for color in colors]


def colorize_distance(image_data: np.ndarray) -> np.ndarray:
    """Return distances (H, W) as uint8 (H, W, 4): near is white, far and nothing are black, on a logarithmic scale."""
    distance = np.asarray(image_data, np.float64)
    hit = np.isfinite(distance) & (distance > 0)
    gray = np.zeros(distance.shape)
    if hit.any():
        logarithm = np.log(distance[hit])
        low, high = logarithm.min(), logarithm.max()
        gray[hit] = 1.0 - (logarithm - low) / max(high - low, 1e-12)
    image = np.full((*distance.shape, 4), 255, np.uint8)
    image[..., :3] = np.round(255 * gray)[..., None]
    return image


def colorize_segmentation(
    segmentation_image: np.ndarray,
    width: int = 0,
    height: int = 0,
    num_channels: int = 4,
    num_colors: int | None = None,
) -> np.ndarray:
    """Return ids (H, W) as uint8 (H, W, 4), one color per id that is there; 0 is black."""
    ids, index = np.unique(segmentation_image, return_inverse=True)
    palette = np.array([(*color, 255) for color in random_colours(len(ids))], np.uint8).reshape(-1, 4)
    palette[ids == 0] = (0, 0, 0, 255)
    return palette[index.reshape(np.shape(segmentation_image))]


def colorize_bboxes(bboxes_2d_data: np.ndarray, bboxes_2d_rgb: np.ndarray, num_channels: int = 3) -> np.ndarray:
    """Return the image (H, W, 3 or 4) with the 2D boxes drawn, one color per label."""
    from PIL import Image, ImageDraw

    image = Image.fromarray(np.ascontiguousarray(bboxes_2d_rgb))
    draw = ImageDraw.Draw(image)
    labels = sorted({int(box["semanticId"]) for box in bboxes_2d_data})
    color_of = dict(zip(labels, random_colours(len(labels)), strict=True))
    for box in bboxes_2d_data:
        corners = [int(box[name]) for name in ("x_min", "y_min", "x_max", "y_max")]
        draw.rectangle(corners, outline=color_of[int(box["semanticId"])], width=2)
    return np.asarray(image)


def colorize_bboxes_3d(bboxes_3d_corners: np.ndarray, rgb: np.ndarray) -> np.ndarray:
    """Return the image with the edges of 3D boxes, whose corners (N, 8, 2 or 3) are fractions of width and height."""
    from PIL import Image, ImageDraw

    image = Image.fromarray(np.ascontiguousarray(rgb))
    draw = ImageDraw.Draw(image)
    pixels = np.asarray(bboxes_3d_corners)[..., :2] * image.size
    for corners, color in zip(pixels, random_colours(len(pixels)), strict=True):
        for start, end in _EDGES:
            draw.line([*corners[start], *corners[end]], fill=color, width=2)
    return np.asarray(image)


def get_bbox2d_tight(viewport: RenderView) -> np.ndarray:
    return colorize_bboxes(sensors.get_bounding_box_2d_tight(viewport), sensors.get_rgb(viewport))


def get_bbox2d_loose(viewport: RenderView) -> np.ndarray:
    return colorize_bboxes(sensors.get_bounding_box_2d_loose(viewport), sensors.get_rgb(viewport))


def get_bbox3d(viewport: Any, mode: str = "parsed") -> np.ndarray:
    from usdsdg.compat.omni.syntheticdata import helpers

    boxes = sensors.get_bounding_box_3d(viewport, parsed=mode == "parsed", return_corners=True)
    points = helpers.world_to_image(boxes["corners"].reshape(-1, 3), viewport)
    return colorize_bboxes_3d(points.reshape(-1, 8, 3), sensors.get_rgb(viewport))


def get_normals(viewport: RenderView) -> np.ndarray:
    """Return normals as uint8 (H, W, 3), -1 to 1 as 0 to 255."""
    return np.round(255 * (sensors.get_normals(viewport) + 1) / 2).astype(np.uint8)


def get_motion_vector(viewport: RenderView) -> np.ndarray:
    """Return motion as uint8 (H, W, 4), minus to plus the largest motion as 0 to 255."""
    motion = sensors.get_motion_vector(viewport)
    largest = max(float(np.abs(motion).max(initial=0.0)), 1e-6)
    image = np.round(255 * (motion / largest + 1) / 2).astype(np.uint8)
    image[..., 3] = 255
    return image


def get_instance_segmentation(viewport: RenderView, mode: str | None = None) -> np.ndarray:
    return colorize_segmentation(sensors.get_instance_segmentation(viewport, parsed=mode == "parsed"))


def get_semantic_segmentation(viewport: RenderView, mode: str = "") -> np.ndarray:
    return colorize_segmentation(sensors.get_semantic_segmentation(viewport, parsed=mode == "parsed"))


def get_depth(viewport: RenderView, mode: str = "linear") -> np.ndarray:
    return colorize_distance(sensors.get_depth_linear(viewport))


def get_distance(viewport: RenderView, mode: str = "image_plane") -> np.ndarray:
    get = sensors.get_distance_to_camera if mode == "camera" else sensors.get_distance_to_image_plane
    return colorize_distance(get(viewport))
