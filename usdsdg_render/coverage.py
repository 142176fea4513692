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
from usdsdg_render.kernels.coverage import Strip, cover_strips
from usdsdg_render.kernels.types import Camera
from usdsdg_render.parallel import launch_rows
from usdsdg_render.tangents import octagons

if TYPE_CHECKING:
    from usdsdg.stage.cameras import CameraView

STRIPS_PER_BAND = 1024


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
    tested = tested[device_scene.placed[tested]]
    strips = _strips(*_spans(view, *_bounds(device_scene, view, tested)), tested)
    if len(strips) == 0:
        return Outlines.nothing((view.height, view.width), len(groups))
    camera = camera_record(view, device_scene.device)
    owners = np.repeat(np.arange(len(groups)), [len(group) for group in groups])
    by_instance = _cover(device_scene, camera, shown, strips, mode, threads)
    return Outlines((view.height, view.width), len(groups), _merged(by_instance, members, owners))


def _bounds(device_scene: DeviceScene, view: CameraView, tested: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(I, 4) lower and upper bounds over the pixels that instances can reach, of each of `tangents.LINES`."""
    if view.lens is None:
        return octagons(device_scene, view, tested)
    lower, upper = np.full((len(tested), 4), -np.inf), np.full((len(tested), 4), np.inf)
    world = (each[tested].astype(np.float64) for each in (device_scene.lower, device_scene.upper))
    boxes = cones.reachable(view, *world)
    lower[:, :2], upper[:, :2] = boxes[:, :2], boxes[:, 2:]
    return lower, upper


def _spans(view: CameraView, lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, ...]:
    """Box, row, first column and the one after the last, (S,) each, of the pixels whose centres are within bounds."""
    top = _first_centre(lower[:, 1], view.height)
    rows = np.maximum(_first_centre(upper[:, 1], view.height) - top, 0)
    box = np.repeat(np.arange(len(rows)), rows)
    row = top[box] + np.arange(len(box)) - np.repeat(np.cumsum(rows) - rows, rows)
    middle = row + 0.5
    low, high = lower[box], upper[box]
    # Columns where column, column + row and column - row are all within their bounds.
    first = np.maximum(np.maximum(low[:, 0], low[:, 2] - middle), low[:, 3] + middle)
    last = np.minimum(np.minimum(high[:, 0], high[:, 2] - middle), high[:, 3] + middle)
    first, last = _first_centre(first, view.width), _first_centre(last, view.width)
    some = last > first
    return box[some], row[some], first[some], last[some]


def _first_centre(places: np.ndarray, size: int) -> np.ndarray:
    """The first pixel of a row of `size` whose centre is not before each of these places; `size` if none is."""
    return np.clip(np.ceil(places - 0.5), 0, size).astype(np.int64)


def _strips(box: np.ndarray, row: np.ndarray, first: np.ndarray, last: np.ndarray, tested: np.ndarray) -> np.ndarray:
    """What to test, ordered by instance, row and column, cut at the ends of words."""
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
