"""Labels drawn over a picture: masks, boxes in two and three dimensions, points, and the names of labels."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from usdsdg.annotators.base import Annotation
from usdsdg.annotators.colors import FIRST_LABELED, colors_of_ids
from usdsdg.writers.formats.class_names import shown_labels
from usdsdg.writers.formats.shapes import cuboid
from usdsdg.writers.formats.shapes.camera_projection import edge_pixels
from usdsdg.writers.formats.shapes.drawing import Canvas

LINE, NAME_SIZE, MASK_OPACITY = 1.5, 11, 0.45
_VISIBLE = 2

# Draws an annotation on a picture, uint8 (H, W, 3), and returns it. camera: the annotation of camera_params.
Draw = Callable[[np.ndarray, Annotation, Mapping[str, Any]], np.ndarray]


def masks(picture: np.ndarray, annotation: Annotation, camera: Mapping[str, Any]) -> np.ndarray:
    """Blend the color of each labeled pixel's id into the picture."""
    ids = _array(annotation)
    present, place = np.unique(ids, return_inverse=True)
    colors = colors_of_ids(present).astype(np.float32)[place.reshape(ids.shape)]
    weight = np.where(ids >= FIRST_LABELED, MASK_OPACITY, 0.0)[..., None]
    return np.rint(picture + weight * (colors[..., :3] - picture)).astype(np.uint8)


def rectangles(picture: np.ndarray, annotation: Annotation, camera: Mapping[str, Any]) -> np.ndarray:
    """Draw 2D boxes with the names of their labels."""
    canvas, rows = Canvas(picture), _array(annotation)
    colors = _colors(annotation)
    for row, color in zip(rows, colors):
        # Bounds are inclusive pixels: the box ends at the far edge of the last one.
        left, top, right, bottom = row["x_min"], row["y_min"], row["x_max"] + 1, row["y_max"] + 1
        corners = np.array([(left, top), (right, top), (right, bottom), (left, bottom)], np.float64)
        for start, end in zip(corners, np.roll(corners, -1, axis=0)):
            canvas.line(start, end, color, width=LINE)
    return written_names(canvas.image(), [(row["x_min"], row["y_min"]) for row in rows], names(annotation), colors)


def cuboids(picture: np.ndarray, annotation: Annotation, camera: Mapping[str, Any]) -> np.ndarray:
    """Draw the edges of 3D boxes, as the lens shows them, with the names of their labels."""
    canvas, rows = Canvas(picture), _array(annotation)
    colors, places = _colors(annotation), []
    view = np.asarray(camera["cameraViewTransform"], np.float64).reshape(4, 4)
    for row, color in zip(rows, colors):
        low, high = ([row[f"{axis}_{end}"] for axis in "xyz"] for end in ("min", "max"))
        corners = cuboid.keypoints(np.array(low), np.array(high))
        to_camera = np.asarray(row["transform"], np.float64).reshape(4, 4) @ view
        edges = cuboid.edge_segments(corners) @ to_camera[:3, :3] + to_camera[3, :3]
        drawn = np.concatenate(edge_pixels(edges, camera))
        for a, b in drawn:
            canvas.line(a, b, color, width=LINE)
        ends = drawn.reshape(-1, 2)
        places.append(tuple(ends.min(axis=0)) if len(ends) else None)
    return written_names(canvas.image(), places, names(annotation), colors)


def points(picture: np.ndarray, annotation: Annotation, camera: Mapping[str, Any]) -> np.ndarray:
    """Draw keypoints: filled where they are visible, faint where they are hidden."""
    canvas = Canvas(picture)
    rows = _array(annotation)
    rows = rows[np.isfinite(rows["x"])]
    for row, color in zip(rows, colors_of_ids(rows["keypointId"] + FIRST_LABELED)[:, :3].tolist()):
        opacity = 1.0 if row["visibility"] == _VISIBLE else 0.35
        canvas.disc(np.array([row["x"], row["y"]]), tuple(color), radius=3.0, opacity=opacity)
    return canvas.image()


# What `rep.preview` can draw, and what a notebook draws of an annotator.
OVERLAYS: dict[str, Draw] = {
    **dict.fromkeys(("semantic_segmentation", "instance_segmentation", "instance_id_segmentation"), masks),
    **dict.fromkeys(("bounding_box_2d_tight", "bounding_box_2d_loose", "bounding_box_2d_amodal"), rectangles),
    **dict.fromkeys(("bounding_box_3d", "bounding_box_3d_360"), cuboids),
    "keypoints": points,
}


def names(annotation: Annotation) -> list[str]:
    """Return the labels of each row of boxes, as "cup" or "cup, fragile"."""
    labels = {int(key): shown_labels(value) for key, value in annotation.info.get("idToLabels", {}).items()}
    return [labels.get(int(row["semanticId"]), "") for row in _array(annotation)]


def _array(annotation: Annotation) -> np.ndarray:
    assert annotation.data is not None
    return np.asarray(annotation.data)


def _colors(annotation: Annotation) -> list[tuple[int, int, int]]:
    """Return a color for each row of boxes: that of its instance in instance_segmentation."""
    ids = annotation.info.get("bboxIds")
    ids = np.arange(len(_array(annotation))) + FIRST_LABELED if ids is None else ids
    return [tuple(color) for color in colors_of_ids(ids)[:, :3].tolist()]


def written_names(
    picture: np.ndarray,
    places: Sequence[tuple[float, float] | None],
    texts: list[str],
    colors: list[tuple[int, int, int]],
) -> np.ndarray:
    """Write a name at the upper left of each place (x, y), on a ground of its color; None is left out."""
    drawn = Image.fromarray(picture)
    draw, font = ImageDraw.Draw(drawn), ImageFont.load_default(NAME_SIZE)
    for place, text, color in zip(places, texts, colors):
        if place is None or not text:
            continue
        _, _, width, height = draw.textbbox((0, 0), text, font=font)
        left = float(np.clip(place[0], 0, max(drawn.width - width - 4, 0)))
        top = float(np.clip(place[1] - height - 3, 0, max(drawn.height - height - 3, 0)))
        draw.rectangle((left, top, left + width + 4, top + height + 3), fill=color)
        is_bright = np.dot(color, (0.299, 0.587, 0.114)) > 140
        draw.text((left + 2, top + 1), text, font=font, fill=(0, 0, 0) if is_bright else (255, 255, 255))
    return np.asarray(drawn)
