"""Object coordinates (NOCS): where in its object's box each pixel's point is. Beyond Replicator."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import LABEL_PARAMS, Annotation, define, predicate_of
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.pixels import encodings, look_ups
from usdsdg.annotators.pixels.launch import Pixels
from usdsdg.annotators.pixels.look_ups import PIXELS

Params = Mapping[str, Any]


@define(
    "object_coordinates", aovs=["instance", "local_position"], needs_poses=True,
    params={**LABEL_PARAMS, "colorize": False}, dtype=np.float32,
    info={"instanceIds": np.zeros(0, np.uint32), "primPaths": [], "boxes": np.zeros((0, 2, 3))},
)  # fmt: skip
def object_coordinates(frame: Frame, params: Params) -> Annotation:
    """Position of each pixel's point in the box of its labeled prim, float32 (H, W, 4): x, y, z from 0 to 1, and 1.

    The box is that of bounding_box_3d, in the prim's own frame; along an axis in which it is flat, the coordinate is
    0.5. All four are 0 where no labeled prim is. colorize: uint8 (H, W, 4), coordinates from 0 to 255. info:
    instanceIds uint32 (N,), primPaths and boxes float64 (N, 2, 3), minimum and maximum, of the prims in the picture.
    Parameters semanticTypes or semanticFilter select labels.
    """
    predicate = predicate_of(params)
    coordinates = frame.derive(("object_coordinates", predicate), lambda: _coordinates(frame, predicate))
    if params["colorize"]:
        coordinates = encodings.eight_bits(coordinates)
    selection, labeled = frame.selection(predicate), frame.labeled_prims
    shown = np.flatnonzero(frame.visible_pixels(predicate) > 0)
    info = {
        "instanceIds": selection.ids[shown].astype(np.uint32),
        "primPaths": [labeled.prim_paths[row] for row in selection.rows[shown]],
        "boxes": labeled.bounds[selection.rows[shown]],
    }
    return Annotation(coordinates, info)


def _coordinates(frame: Frame, predicate: str | None) -> Pixels:
    return look_ups.map_points(
        frame.image("instance"), frame.image("local_position"), *_box_from_gprim(frame, predicate)
    )


def _box_from_gprim(frame: Frame, predicate: str | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrix of each gprim from its own frame to the coordinates of its labeled prim's box.

    (G, 4, 4) float64 for row vectors, and (G,) bool: whether a selected prim owns the gprim, which is visible.
    """
    selection, labeled = frame.selection(predicate), frame.labeled_prims
    members = selection.member_of_gprim
    owned = (members >= 0) & (frame.sums[:, PIXELS] > 0)
    rows = selection.rows[members[owned]]
    low, size = labeled.bounds[rows, 0], labeled.bounds[rows, 1] - labeled.bounds[rows, 0]
    flat = size <= 0
    scale = np.where(flat, 0.0, 1.0 / np.where(flat, 1.0, size))
    box = np.zeros((len(rows), 4, 4))
    box[:, range(3), range(3)] = scale
    box[:, 3, :3] = np.where(flat, 0.5, -low * scale)
    box[:, 3, 3] = 1.0
    matrices = np.tile(np.eye(4), (len(members), 1, 1))
    owners = np.linalg.pinv(labeled.local_to_world[rows])
    matrices[owned] = frame.queries.gprim_to_world[owned] @ owners @ box
    return matrices, owned
