"""3D boxes enclose the points of their prims: those that depth and ids give."""

from __future__ import annotations

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Boxes, Seen

_SOLID = ("x_min", "y_min", "z_min", "x_max", "y_max", "z_max")
# Relative to the size of the box and to the distance from the camera: float32 depth, and edges of tessellations.
_OF_SIZE, _OF_DISTANCE = 1e-3, 2e-5


def check(seen: Seen) -> Faults:
    """Compare 3D boxes with the recorded depth."""
    if seen.truth is None or seen.truth.grid_points is None:
        return
    for boxes in seen.boxes:
        if boxes.kind == "3d" and boxes.paths is not None and len(boxes.paths) == len(boxes.rows):
            yield from _enclose(seen, boxes)


def _enclose(seen: Seen, boxes: Boxes) -> Faults:
    assert seen.truth is not None
    assert seen.truth.grid_points is not None
    assert boxes.paths is not None
    members = seen.truth.members(boxes.filter)
    if members is None:
        return
    rows, columns = seen.truth.grid
    shown, points = members[rows, columns].ravel(), seen.truth.grid_points.reshape(-1, 3)
    things = [each.path for each in seen.truth.things(boxes.filter)]
    for path, row in zip(boxes.paths, boxes.rows):
        if things.count(path) != 1 or boxes.paths.count(path) != 1:
            continue
        corners = np.array([row[side] for side in _SOLID], np.float64).reshape(2, 3)
        mine = points[(shown == things.index(path)) & np.isfinite(points).all(axis=1)]
        if len(mine) and corners.any():
            yield from _inside(seen, boxes, path, corners, np.array(row["transform"], np.float64), mine)


def _inside(
    seen: Seen, boxes: Boxes, path: str, corners: np.ndarray, to_world: np.ndarray, points: np.ndarray
) -> Faults:
    assert seen.truth is not None
    assert seen.truth.camera is not None
    try:
        to_local = np.linalg.inv(to_world)
    except np.linalg.LinAlgError:
        yield Fault(boxes.file, seen.name, f"the transform of {path} has no inverse")
        return
    local = points @ to_local[:3, :3] + to_local[3, :3]
    far = np.linalg.norm(points - seen.truth.camera.local_to_world[3, :3], axis=1).max()
    # A point is as accurate as its distance allows, in units of the prim's frame.
    margin = _OF_SIZE * (corners[1] - corners[0]).max() + _OF_DISTANCE * far * np.linalg.norm(to_local[:3, :3], axis=0)
    outside = ((local < corners[0] - margin) | (local > corners[1] + margin)).any(axis=1)
    if outside.any():
        yield Fault(
            boxes.file, seen.name, f"the 3D box of {path} encloses its points", f"all {len(points)}",
            f"{int((~outside).sum())}",
        )  # fmt: skip
