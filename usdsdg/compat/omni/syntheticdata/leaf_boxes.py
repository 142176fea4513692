"""3D boxes of the gprims of labeled prims."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from pxr import UsdGeom

from usdsdg.annotators.bounds.hulls import read_hull
from usdsdg.annotators.point_instances import PointFrames, find_steps, prim_path
from usdsdg.compat.omni.syntheticdata.instance_mappings import gprim_ids
from usdsdg.compat.omni.syntheticdata.structured import BOX_3D, CORNER_NAMES
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import stage_time
from usdsdg.stage.geometry.skinning import Skinning


def leaf_boxes(mappings: Iterable[Mapping[str, Any]]) -> np.ndarray:
    """Return the box of each gprim that a row of `mappings` has, in the gprim's frame: structured (N,), `BOX_3D`.

    semanticId is that of the nearest labeled prim. Gprims without finite bounds are left out.
    """
    semantic_of: dict[int, int] = {}
    for row in mappings:  # inner prims come first, and count
        for number in row["instanceIds"]:
            semantic_of.setdefault(number, row["semanticId"])
    stage = current_stage()
    time = stage_time(stage)
    frames, skinning = PointFrames(stage, UsdGeom.XformCache(time)), Skinning()
    drawn = [(path, number) for path, number in gprim_ids().items() if number in semantic_of]
    rows = []
    for (path, number), steps in zip(drawn, find_steps(stage, [path for path, _ in drawn]), strict=True):
        hull = read_hull(stage.GetPrimAtPath(prim_path(path)), time, skinning)
        if hull is not None:
            bounds = dict(zip(CORNER_NAMES, hull(np.eye(4)).reshape(-1), strict=True))
            to_world = frames.to_world(prim_path(path), steps)
            rows.append((number, semantic_of[number], *bounds.values(), to_world))
    return np.array(rows, BOX_3D)
