"""The coverage pass on the host: which pixels each instance can reach at all, and the words of bits of each group.

A ray is not followed from surface to surface: faces of two instances that coincide lie at one distance, so that going
on behind the first would pass by the second. Each instance is asked on its own whether the ray meets it, by the same
test of the same triangles as when it is alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import warp as wp

from usdsdg.stage.outlines import STRIP, WORD, Outlines
from usdsdg_render import cones
from usdsdg_render.camera import camera_record
from usdsdg_render.device import DeviceScene, records
from usdsdg_render.fetch import fetch
from usdsdg_render.kernels.coverage import Strip, cover_strips, find_spans
from usdsdg_render.kernels.types import Camera
from usdsdg_render.parallel import launch_rows

if TYPE_CHECKING:
    from usdsdg.stage.cameras import CameraView

STRIPS_PER_BAND = 1024
BOXES_PER_BAND = 64
# Pixels around a projected box, for rounding.
MARGIN = 1


def render(
    device_scene: DeviceScene,
    view: CameraView,
    groups: Sequence[Sequence[int]],
    shown: np.ndarray,
    *,
    mode: int,
    threads: int | None,
) -> Outlines:
    """See `WarpRenderer.outlines`; `shown` is the instance AOV of the same view and mode."""
    members = np.array([each for group in groups for each in group], np.int64)
    tested = np.unique(members)
    rectangles = reachable(view, device_scene.lower[tested], device_scene.upper[tested])
    rectangles[~device_scene.placed[tested]] = 0
    in_view = (rectangles[:, 2] > rectangles[:, 0]) & (rectangles[:, 3] > rectangles[:, 1])
    tested, rectangles = tested[in_view], rectangles[in_view]
    if len(tested) == 0:
        return Outlines.nothing((view.height, view.width), len(groups))
    camera = camera_record(view, device_scene.device)
    strips = _strips(_spans(device_scene, view, camera, tested, rectangles, threads), tested)
    owners = np.repeat(np.arange(len(groups)), [len(group) for group in groups])
    by_instance = _cover(device_scene, camera, shown, strips, mode, threads)
    return Outlines((view.height, view.width), len(groups), _merged(by_instance, members, owners))


def reachable(view: CameraView, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """(I, 4) int32 pixel rectangles x0, y0, x1, y1 (exclusive) that hold all of each world box.

    A box that reaches the near plane or lies around the camera gets the whole picture; one out of sight an empty one.
    """
    if view.lens is not None:
        return cones.reachable(view, lower.astype(np.float64), upper.astype(np.float64))
    corner = np.stack(np.meshgrid(*[(0, 1)] * 3, indexing="ij"), -1).reshape(8, 3)
    points = np.where(corner, upper[:, None], lower[:, None]).astype(np.float64)
    pixels, depth = view.project(points.reshape(-1, 3))
    pixels, depth = pixels.reshape(-1, 8, 2), depth.reshape(-1, 8)
    near, far = view.clipping_range
    whole = depth.min(1) <= max(near * 0.5, 1e-12) if view.projection_type == "pinhole" else np.zeros(len(lower), bool)
    gone = (depth.max(1) < near * 0.999) | (depth.min(1) > far * 1.001)
    size = np.array([view.width, view.height])
    with np.errstate(invalid="ignore"):
        first = np.clip(np.floor(pixels.min(1)) - MARGIN, 0, size)
        last = np.clip(np.ceil(pixels.max(1)) + MARGIN, 0, size)
    first[whole], last[whole] = 0, size
    first[gone] = last[gone] = 0
    return np.concatenate([first, last], 1).astype(np.int32)


def _spans(
    device_scene: DeviceScene,
    view: CameraView,
    camera: Camera,
    tested: np.ndarray,
    rectangles: np.ndarray,
    threads: int | None,
) -> np.ndarray:
    """(I, H, 2) columns [first, last) of each row that each of the instances can reach."""
    device = device_scene.device
    in_camera = device_scene.corners(view.local_to_world[3, :3])[tested] @ view.world_to_camera[:3, :3]
    corners = wp.array(in_camera.astype(np.float32), dtype=wp.vec3, device=device)
    spans = wp.empty((len(tested), view.height), dtype=wp.vec2i, device=device)
    inputs = [camera, corners, wp.array(rectangles, dtype=wp.vec4i, device=device)]
    launch_rows(find_spans, spans.shape, inputs, [spans], device=device, threads=threads, band_rows=BOXES_PER_BAND)
    return fetch({"spans": spans})["spans"]


def _strips(spans: np.ndarray, tested: np.ndarray) -> np.ndarray:
    """What to test, ordered by instance, row and column, cut at the ends of words."""
    first, last = spans[..., 0], spans[..., 1]
    box, row = np.nonzero(last > first)
    first, last = first[box, row], last[box, row]
    words = (last - 1) // WORD - first // WORD + 1
    span = np.repeat(np.arange(len(box)), words)
    word = first[span] // WORD + np.arange(len(span)) - np.repeat(np.cumsum(words) - words, words)
    strips = records(Strip, len(span))
    strips["instance"], strips["row"] = tested[box[span]], row[span]
    strips["first"] = np.maximum(first[span], word * WORD)
    strips["last"] = np.minimum(last[span], (word + 1) * WORD)
    return strips


def _cover(
    device_scene: DeviceScene, camera: Camera, shown: np.ndarray, strips: np.ndarray, mode: int, threads: int | None
) -> np.ndarray:
    """STRIP rows of what is met, whose group is the instance."""
    device = device_scene.device
    covered, visible = (wp.empty(len(strips), dtype=wp.uint64, device=device) for _ in range(2))
    inputs = [
        device_scene.tables,
        camera,
        mode,
        wp.array(shown, dtype=wp.int32, device=device),
        wp.array(strips, dtype=Strip, device=device),
    ]
    launch_rows(
        cover_strips,
        strips.shape,
        inputs,
        [covered, visible],
        device=device,
        threads=threads,
        band_rows=STRIPS_PER_BAND,
    )
    covered, visible = fetch({"covered": covered, "visible": visible}).values()
    met = np.flatnonzero(covered)
    result = np.zeros(len(met), STRIP)
    result["group"], result["row"] = strips["instance"][met], strips["row"][met]
    result["word"] = strips["first"][met] // WORD
    result["covered"], result["visible"] = covered[met], visible[met]
    return result


def _merged(by_instance: np.ndarray, members: np.ndarray, owners: np.ndarray) -> np.ndarray:
    """STRIP rows of the groups `owners` from those of their instances `members`: a pixel counts once."""
    if len(members) == len(np.unique(owners)) and np.all(members[1:] > members[:-1]):
        # One instance a group, and in their order.
        by_instance["group"] = owners[np.searchsorted(members, by_instance["group"])]
        return by_instance
    begin = np.searchsorted(by_instance["group"], members)
    length = np.searchsorted(by_instance["group"], members, side="right") - begin
    rows = np.repeat(begin - (np.cumsum(length) - length), length) + np.arange(length.sum())
    strips = by_instance[rows]
    strips["group"] = np.repeat(owners, length)
    keys = [strips[name].astype(np.int64) for name in ("group", "row", "word")]
    key = (keys[0] << 42) + (keys[1] << 21) + keys[2]
    if np.all(key[1:] > key[:-1]):
        return strips
    order = np.argsort(key, kind="stable")
    _, first = np.unique(key[order], return_index=True)
    merged = strips[order[first]]
    for name in ("covered", "visible"):
        merged[name] = np.bitwise_or.reduceat(strips[name][order], first)
    return merged
