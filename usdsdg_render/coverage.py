"""The coverage pass on the host: which pixels each instance can reach at all, and sums over the strips tested."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import warp as wp

from usdsdg_render import cones
from usdsdg_render.camera import camera_record
from usdsdg_render.device import DeviceScene, records
from usdsdg_render.kernels.coverage import Strip, cover_strips
from usdsdg_render.parallel import launch_rows

if TYPE_CHECKING:
    from usdsdg.stage.cameras import CameraView

STRIP_PIXELS = 64
STRIPS_PER_BAND = 256
# Pixels around a projected box, for rounding.
MARGIN = 1


def render(
    device_scene: DeviceScene, view: CameraView, groups: Sequence[Sequence[int]], *, threads: int | None
) -> np.ndarray:
    """See `WarpRenderer.coverage`."""
    result = np.full((len(groups), 5), -1, np.int64)
    result[:, 0] = 0
    rectangles = reachable(view, device_scene.lower, device_scene.upper)
    rectangles[~device_scene.placed] = 0
    strips = _strips(rectangles, groups)
    if len(strips) == 0:
        return result
    covered = _launch(device_scene, view, groups, rectangles, strips, threads)
    hit = covered[:, 0] > 0
    for group in np.unique(strips["group"][hit]):
        mine = hit & (strips["group"] == group)
        counts, rows = covered[mine], strips["row"][mine]
        result[group] = (
            counts[:, 0].sum(),
            counts[:, 1].min(),
            rows.min(),
            counts[:, 2].max(),
            rows.max(),
        )
    return result


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


def _strips(rectangles: np.ndarray, groups: Sequence[Sequence[int]]) -> np.ndarray:
    """Strips of pixels that cover, for each group, the rows and columns that any of its instances can reach."""
    parts = []
    for index, group in enumerate(groups):
        mine = rectangles[np.asarray(group, int)].reshape(-1, 4)
        mine = mine[(mine[:, 2] > mine[:, 0]) & (mine[:, 3] > mine[:, 1])]
        if len(mine) == 0:
            continue
        (x0, y0), (x1, y1) = mine[:, :2].min(0), mine[:, 2:].max(0)
        rows, firsts = np.meshgrid(np.arange(y0, y1), np.arange(x0, x1, STRIP_PIXELS), indexing="ij")
        part = records(Strip, rows.size)
        part["group"], part["row"], part["first"] = index, rows.ravel(), firsts.ravel()
        part["last"] = np.minimum(part["first"] + STRIP_PIXELS, x1)
        parts.append(part)
    return np.concatenate(parts) if parts else records(Strip, 0)


def _launch(
    device_scene: DeviceScene,
    view: CameraView,
    groups: Sequence[Sequence[int]],
    rectangles: np.ndarray,
    strips: np.ndarray,
    threads: int | None,
) -> np.ndarray:
    device = device_scene.device
    members = np.full((len(groups), 1 + max(len(group) for group in groups)), -1, np.int32)
    for row, group in zip(members, groups, strict=True):
        row[: len(group)] = group
    inputs = [
        camera_record(view),
        wp.array(members, dtype=wp.int32, device=device),
        wp.array(rectangles, dtype=wp.vec4i, device=device),
    ]
    covered = wp.empty(len(strips), dtype=wp.vec3i, device=device)

    launch_rows(
        cover_strips,
        strips.shape,
        [device_scene.tables, *inputs, wp.array(strips, dtype=Strip, device=device)],
        [covered],
        device=device,
        threads=threads,
        band_rows=STRIPS_PER_BAND,
    )
    return covered.numpy()
