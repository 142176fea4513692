"""Pictures with boxes: lines are where the recorded boxes have them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.formats.drawn import NAME
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.truth import Thing, Truth
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.verify.checks.compare import of_pixels
from usdsdg.verify.checks.poses import keypoints
from usdsdg.writers.formats.shapes.clipping import clip_to_rectangle

_KINDS = {"bounding_box_2d_tight_fast": "tight", "bounding_box_2d_loose_fast": "loose", "bounding_box_3d_fast": "3d"}
_LINE_COLOR = "green"
_CORNERS = [f"{x}{y}{z}" for x in "LR" for y in "DU" for z in "BF"]
_FEW = 4  # pixels of lines through a lens that may be elsewhere
_POINTS = 2000  # along an edge that a lens bends


def check(seen: Seen) -> Faults:
    """Compare drawn boxes with the recorded ones."""
    if seen.format != NAME or seen.truth is None:
        return
    for annotator, kind in _KINDS.items():
        if annotator not in seen.extra:
            continue
        file, image = seen.extra[annotator]
        style = seen.truth.record.parameters.get(f"{annotator.removesuffix('_fast')}_params") or {}
        things = seen.truth.things(seen.truth.filter_of(annotator))
        if image.shape[:2] != seen.truth.product.shape:
            yield Fault(file, seen.name, "has another size", str(seen.truth.product.shape), str(image.shape[:2]))
        elif kind == "3d":
            yield from _solids(seen, file, image, style, [each for each in things if each.amodal], seen.truth)
        else:
            boxes = [each.box if kind == "tight" else each.amodal_box for each in things]
            yield from _rectangles(seen, file, image, style, [box for box in boxes if box is not None])


def _rectangles(seen: Seen, file: str, image: np.ndarray, style: Mapping[str, Any], boxes: list[Any]) -> Faults:
    empty = Image.new("RGBA", (image.shape[1], image.shape[0]))
    draw, fill = ImageDraw.Draw(empty), style.get("fill")
    color = _color(style.get("outline", _LINE_COLOR))
    for box in boxes:
        draw.rectangle(list(box), fill=_color(fill), outline=color, width=style.get("width", 1))
    expected = np.array(empty)
    drawn = expected[..., 3] > 0
    wrong = drawn & (image[..., :3] != expected[..., :3]).any(axis=2)
    if style.get("background") is None and image.shape[2] == 4:
        wrong |= drawn != (image[..., 3] > 0)
    if wrong.any():
        yield Fault(file, seen.name, f"lines are not on the edges of the boxes in {of_pixels(wrong)}")


def _solids(
    seen: Seen, file: str, image: np.ndarray, style: Mapping[str, Any], things: list[Thing], truth: Truth
) -> Faults:
    """Every edge that is in view is drawn, and nothing else is."""
    if truth.camera is None or style.get("background") is not None or image.shape[2] != 4:
        return
    height, width = image.shape[:2]
    reach = 1 + int(style.get("width", 1)) // 2
    near = np.zeros((height, width), bool)
    drawn = image[..., 3] > 0
    missing = total = 0
    for thing in things if style.get("width", 1) else ():
        corners = keypoints(thing.bounds, _CORNERS) @ thing.local_to_world[:3, :3] + thing.local_to_world[3, :3]
        ends = [(a, b) for a in range(8) for b in (a ^ 1, a ^ 2, a ^ 4) if a < b]
        pixels = np.concatenate([_edge(corners[a], corners[b], truth.camera) for a, b in ends])
        for x, y in np.unique(np.floor(pixels).astype(int), axis=0).tolist():
            # Ends of a line that is drawn are rounded, also those out of view.
            near[max(y - reach - 1, 0) : max(y + reach + 2, 0), max(x - reach - 1, 0) : max(x + reach + 2, 0)] = True
            # A line may be drawn a pixel beside, so along the border of the image out of it.
            if reach <= x < width - reach and reach <= y < height - reach:
                around = drawn[max(y - reach, 0) : y + reach + 1, max(x - reach, 0) : x + reach + 1]
                missing, total = missing + (not around.any()), total + 1
    stray = drawn & ~near
    # A few pixels are no fault, as at the ends of edges, and where a panorama bends them most.
    few = 0 if truth.camera.lens is None else _FEW
    if missing > 0.02 * total or stray.sum() > few + 0.005 * max(drawn.sum(), 1):
        yield Fault(
            file,
            seen.name,
            "edges of 3D boxes are drawn where they project",
            f"{total} pixels",
            f"{missing} are missing, {int(stray.sum())} elsewhere",
        )


def _edge(start: np.ndarray, end: np.ndarray, camera: CameraView) -> np.ndarray:
    """Return pixels (N, 2) along the part of an edge that is in front of the camera and near the image."""
    depths = -(np.stack([start, end]) @ camera.world_to_camera[:3, 2] + camera.world_to_camera[3, 2])
    near = max(camera.clipping_range[0], 1e-6)
    if camera.projection_type == "pinhole" and (depths < near).any():
        if (depths < near).all():
            return np.zeros((0, 2))
        crossing = start + (end - start) * (near - depths[0]) / (depths[1] - depths[0])
        start, end = (crossing, end) if depths[0] < near else (start, crossing)
    if camera.lens is None:
        # Straight in the image: clipped there, and as dense as its pixels.
        part = clip_to_rectangle(_ends(start, end, camera), -2.0, -2.0, camera.width + 2.0, camera.height + 2.0)
        if part is None:
            return np.zeros((0, 2))
        count = 2 + int(2 * np.abs(part[1] - part[0]).max())
        return part[0] + np.linspace(0, 1, count)[:, None] * (part[1] - part[0])
    pixels, _ = camera.project(start + np.linspace(0, 1, _POINTS)[:, None] * (end - start))
    return pixels[np.isfinite(pixels).all(axis=1)]


def _ends(start: np.ndarray, end: np.ndarray, camera: CameraView) -> np.ndarray:
    """Return the pixels of two points; on the near plane or beyond it."""
    points = np.stack([start, end]) @ camera.world_to_camera[:3, :3] + camera.world_to_camera[3, :3]
    divisor = np.maximum(-points[:, 2:], 1e-9) if camera.projection_type == "pinhole" else 1.0
    return points[:, :2] * (camera.fx, -camera.fy) / divisor + (camera.cx, camera.cy)


def _color(color: Any) -> Any:
    """Return a color for Pillow, which takes no lists, as records have them."""
    return tuple(color) if isinstance(color, list) else color
