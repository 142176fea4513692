"""Pictures with boxes: lines are where the recorded boxes have them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from PIL import Image, ImageColor, ImageDraw

from usdsdg.verify.checks.compare import of_pixels
from usdsdg.verify.checks.poses import keypoints
from usdsdg.verify.faults import Fault, Faults
from usdsdg.verify.formats.drawn import NAME
from usdsdg.verify.seen import Seen
from usdsdg.verify.truth import Thing, Truth

_KINDS = {"bounding_box_2d_tight_fast": "tight", "bounding_box_2d_loose_fast": "loose", "bounding_box_3d_fast": "3d"}
_LINE_COLOR = "green"
_CORNERS = [f"{x}{y}{z}" for x in "LR" for y in "DU" for z in "BF"]
_POINTS = 200  # along an edge


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
        draw.rectangle(
            list(box), fill=None if fill is None else _color(fill), outline=color, width=style.get("width", 1)
        )
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
    for thing in things:
        corners = keypoints(thing.bounds, _CORNERS) @ thing.local_to_world[:3, :3] + thing.local_to_world[3, :3]
        ends = [(a, b) for a in range(8) for b in (a ^ 1, a ^ 2, a ^ 4) if a < b]
        fraction = np.linspace(0, 1, _POINTS)[:, None]
        points = np.concatenate([corners[a] + fraction * (corners[b] - corners[a]) for a, b in ends])
        pixels, depth = truth.camera.project(points)
        seen_points = np.isfinite(pixels).all(axis=1) & (depth > truth.camera.clipping_range[0])
        column, row = np.floor(pixels[seen_points]).astype(int).T
        inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
        for y, x in {(int(y), int(x)) for y, x in zip(row[inside], column[inside])}:
            around = np.s_[max(y - reach, 0) : y + reach + 1, max(x - reach, 0) : x + reach + 1]
            near[around] = True
            missing, total = missing + (not drawn[around].any()), total + 1
    # Points are dense enough for a line in most cases; a few pixels between them are no fault.
    stray = drawn & ~near
    if missing > 0.02 * total or stray.sum() > 0.02 * max(drawn.sum(), 1):
        yield Fault(
            file,
            seen.name,
            "edges of 3D boxes are drawn where they project",
            f"{total} pixels",
            f"{missing} are missing, {int(stray.sum())} elsewhere",
        )


def _color(color: Any) -> tuple[int, ...]:
    if isinstance(color, str):
        return ImageColor.getrgb(color)
    return tuple(color)
