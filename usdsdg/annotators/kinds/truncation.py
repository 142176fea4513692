"""Boxes of whole objects, also where they reach out of the picture, and the share of them outside. Beyond Replicator.

What is outside is rendered: the label rays go on beyond the picture's edges, as far as the picture is wide and high.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import LABEL_PARAMS, Annotation, define, predicate_of
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.kinds.boxes import BOX_2D, NO_TABLES, fill_corners, with_tables
from usdsdg.annotators.pixels.look_ups import PIXELS, X_MIN

Params = Mapping[str, Any]

BOX_2D_AMODAL = np.dtype([*BOX_2D.descr, ("truncationRatio", "<f4")])
TRUNCATION = np.dtype([("instanceId", "<u4"), ("semanticId", "<u4"), ("truncationRatio", "<f4")])

_NEEDS: Mapping[str, Any] = {
    "aovs": ["instance"],
    "needs_amodal_masks": True,
    "needs_poses": True,
    "params": LABEL_PARAMS,
}
# The corners of a box by the index of their coordinates.
_CORNERS = np.array([[k >> 2 & 1, k >> 1 & 1, k & 1] for k in range(8)])


@define("bounding_box_2d_amodal", dtype=BOX_2D_AMODAL, info=NO_TABLES, **_NEEDS)
def bounding_box_2d_amodal(frame: Frame, params: Params) -> Annotation:
    """Boxes of the pixels that each labeled prim in view would cover alone, in the picture and around it [inclusive].

    As bounding_box_2d_loose, but columns and rows may be negative or beyond the picture: by up to its width and height,
    where boxes are cut off. truncationRatio float32: the share of these pixels that is outside of the picture.
    """
    predicate = predicate_of(params)
    listed, wide = frame.in_view(predicate), _wide(frame, predicate)
    rows = np.zeros(len(listed), BOX_2D_AMODAL)
    fill_corners(rows, wide[listed, X_MIN:])
    rows["truncationRatio"] = _ratios(frame, predicate)[listed]
    return with_tables(frame, params, str, listed, rows)


@define("truncation", dtype=TRUNCATION, **_NEEDS)
def truncation(frame: Frame, params: Params) -> Annotation:
    """Ids of every labeled prim in view, and the share of it outside of the picture, from 0 to 1.

    Structured (N,): instanceId and semanticId uint32, those of the segmentations, truncationRatio float32: of the
    pixels that the prim would cover alone in the picture and around it (by the picture's width and height on each
    side), those around it. It is 0 where a lens sees all directions.
    """
    predicate = predicate_of(params)
    selection, listed = frame.selection(predicate), frame.in_view(predicate)
    rows = np.zeros(len(listed), TRUNCATION)
    rows["instanceId"] = selection.ids[listed]
    rows["semanticId"] = selection.class_ids[listed]
    rows["truncationRatio"] = _ratios(frame, predicate)[listed]
    return Annotation(rows)


def _ratios(frame: Frame, predicate: str | None) -> np.ndarray:
    """Return (K,) the share of each selected prim outside of the picture."""
    inside = frame.coverage[frame.selection(predicate).rows, PIXELS]
    return 1 - inside / np.maximum(_wide(frame, predicate)[:, PIXELS], 1)


def _wide(frame: Frame, predicate: str | None) -> np.ndarray:
    """Return (K, 5) pixels and bounds of each selected prim in the picture and around it, as `Frame.coverage`."""
    return frame.derive(("whole coverage", predicate), lambda: _render_around(frame, predicate))


def _render_around(frame: Frame, predicate: str | None) -> np.ndarray:
    rows = frame.selection(predicate).rows
    found = frame.coverage[rows].copy()
    out = np.flatnonzero((found[:, PIXELS] > 0) & _may_reach_out(frame, rows))
    if len(out):
        outside = frame.queries.coverage_around([frame.labeled_prims.groups[row] for row in rows[out]])
        some = outside[:, PIXELS] > 0
        out, outside = out[some], outside[some]
        found[out, PIXELS] += outside[:, PIXELS]
        found[out, 1:3] = np.minimum(outside[:, 1:3], found[out, 1:3])
        found[out, 3:5] = np.maximum(outside[:, 3:5], found[out, 3:5])
    return found


def _may_reach_out(frame: Frame, rows: np.ndarray) -> np.ndarray:
    """Return (K,) bool: False where the prim's 3D box is in the picture, so that all of the prim is."""
    camera, labeled = frame.camera, frame.labeled_prims
    if camera.lens is not None:
        return np.ones(len(rows), bool)
    bounds, matrices = labeled.bounds[rows], labeled.local_to_world[rows]
    corners = np.stack([bounds[:, _CORNERS[:, axis], axis] for axis in range(3)], axis=-1)  # (K, 8, 3)
    world = np.einsum("kci,kij->kcj", corners, matrices[:, :3, :3]) + matrices[:, None, 3, :3]
    pixels, depths = camera.project(world.reshape(-1, 3))
    with np.errstate(invalid="ignore"):
        inside = ((pixels >= 1) & (pixels <= (camera.width - 1, camera.height - 1))).all(axis=1)
    inside &= depths > camera.clipping_range[0]
    is_known = (bounds[:, 1] > bounds[:, 0]).any(axis=1)  # without finite bounds the box is empty
    return np.logical_not(inside.reshape(-1, 8).all(axis=1) & is_known)
