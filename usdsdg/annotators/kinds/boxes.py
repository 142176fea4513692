"""Bounding boxes: 2D of visible pixels (tight) and of amodal masks (loose), 3D in the prim's frame; and occlusion.

Pixel indices are inclusive: x_min and x_max are the first and last column whose pixel center is covered.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import LABEL_PARAMS, Annotation, define, predicate_of
from usdsdg.annotators.colors import UNLABELLED
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.pixels.look_ups import X_MIN

Params = Mapping[str, Any]

BOX_2D = np.dtype(
    [
        ("semanticId", "<u4"),
        ("x_min", "<i4"),
        ("y_min", "<i4"),
        ("x_max", "<i4"),
        ("y_max", "<i4"),
        ("occlusionRatio", "<f4"),
    ]
)
BOX_3D = np.dtype(
    [
        ("semanticId", "<u4"),
        ("x_min", "<f4"),
        ("y_min", "<f4"),
        ("z_min", "<f4"),
        ("x_max", "<f4"),
        ("y_max", "<f4"),
        ("z_max", "<f4"),
        ("transform", "<f4", (4, 4)),
        ("occlusionRatio", "<f4"),
    ]
)
OCCLUSION = np.dtype([("instanceId", "<u4"), ("semanticId", "<u4"), ("occlusionRatio", "<f4")])

# Info of boxes before the first frame.
NO_TABLES: Mapping[str, Any] = {"idToLabels": {}, "bboxIds": np.zeros(0, np.uint32), "primPaths": []}
_NEEDS: Mapping[str, Any] = {"aovs": ["instance"], "needs_amodal_masks": True, "params": LABEL_PARAMS}
_CORNERS_2D = ("x_min", "y_min", "x_max", "y_max")


@define("bounding_box_2d_tight", dtype=BOX_2D, info=NO_TABLES, **_NEEDS)
def bounding_box_2d_tight(frame: Frame, params: Params) -> Annotation:
    """Boxes of the visible pixels [pixels, inclusive]; fully occluded prims and prims out of view are left out.

    Structured (N,): semanticId uint32 (from 0), x_min, y_min, x_max, y_max int32, occlusionRatio float32; info:
    idToLabels, bboxIds uint32 (N,) and primPaths in the order of the rows. semanticTypes (list of types) or
    semanticFilter (predicate) select labels.
    """
    return _tight(frame, params, str)


@define("bounding_box_2d_tight_fast", dtype=BOX_2D, info=NO_TABLES, **_NEEDS)
def bounding_box_2d_tight_fast(frame: Frame, params: Params) -> Annotation:
    """As bounding_box_2d_tight; keys of idToLabels are integers."""
    return _tight(frame, params, int)


@define("bounding_box_2d_loose", dtype=BOX_2D, info=NO_TABLES, **_NEEDS)
def bounding_box_2d_loose(frame: Frame, params: Params) -> Annotation:
    """As bounding_box_2d_tight, of the amodal mask of each prim; prims out of view are left out."""
    return _loose(frame, params, str)


@define("bounding_box_2d_loose_fast", dtype=BOX_2D, info=NO_TABLES, **_NEEDS)
def bounding_box_2d_loose_fast(frame: Frame, params: Params) -> Annotation:
    """As bounding_box_2d_loose; keys of idToLabels are integers."""
    return _loose(frame, params, int)


@define("bounding_box_3d", dtype=BOX_3D, info=NO_TABLES, needs_poses=True, **_NEEDS)
def bounding_box_3d(frame: Frame, params: Params) -> Annotation:
    """Boxes in each prim's own frame [stage units] with its local-to-world transform; only of prims in view.

    Structured (N,): semanticId uint32 (from 0), x_min, y_min, z_min, x_max, y_max, z_max float32, transform float32
    (4, 4) for row vectors, occlusionRatio float32; info and parameters as bounding_box_2d_tight.
    """
    return _boxes_3d(frame, params, str, everywhere=False)


@define("bounding_box_3d_fast", dtype=BOX_3D, info=NO_TABLES, needs_poses=True, **_NEEDS)
def bounding_box_3d_fast(frame: Frame, params: Params) -> Annotation:
    """As bounding_box_3d; keys of idToLabels are integers."""
    return _boxes_3d(frame, params, int, everywhere=False)


@define("bounding_box_3d_360", dtype=BOX_3D, info=NO_TABLES, needs_poses=True, **_NEEDS)
def bounding_box_3d_360(frame: Frame, params: Params) -> Annotation:
    """As bounding_box_3d, of all labeled prims on the stage; occlusionRatio is nan out of view."""
    return _boxes_3d(frame, params, str, everywhere=True)


@define("occlusion", dtype=OCCLUSION, **_NEEDS)
def occlusion(frame: Frame, params: Params) -> Annotation:
    """Ids and occluded fraction of every labeled prim on the stage.

    Structured (N,): instanceId and semanticId uint32, those of the segmentations, and occlusionRatio float32 from 0
    (fully visible) to 1, nan out of view. If there are gprims without (selected) labels, the first row stands for all
    of them: both ids are 1, and the ratio is nan, because it is not measured.
    """
    selection = frame.selection(predicate_of(params))
    first = int((selection.member_of_gprim < 0).any())
    rows = np.zeros(first + len(selection), OCCLUSION)
    rows[:first] = (UNLABELLED, UNLABELLED, np.nan)
    rows["instanceId"][first:] = selection.ids
    rows["semanticId"][first:] = selection.class_ids
    rows["occlusionRatio"][first:] = frame.occlusion(predicate_of(params))
    return Annotation(rows)


def _tight(frame: Frame, params: Params, key: Callable) -> Annotation:
    predicate = predicate_of(params)
    listed = np.flatnonzero(frame.visible_pixels(predicate) > 0)
    return _boxes_2d(frame, params, key, listed, frame.visible(predicate)[:, X_MIN:])


def _loose(frame: Frame, params: Params, key: Callable) -> Annotation:
    corners = frame.coverage[frame.selection(predicate_of(params)).rows, X_MIN:]
    return _boxes_2d(frame, params, key, frame.in_view(predicate_of(params)), corners)


def _boxes_2d(frame: Frame, params: Params, key: Callable, listed: np.ndarray, corners: np.ndarray) -> Annotation:
    rows = np.zeros(len(listed), BOX_2D)
    fill_corners(rows, corners[listed])
    return with_tables(frame, params, key, listed, rows)


def fill_corners(rows: np.ndarray, corners: np.ndarray) -> None:
    """Fill in x_min, y_min, x_max, y_max from corners (N, 4)."""
    for column, name in enumerate(_CORNERS_2D):
        rows[name] = corners[:, column]


def _boxes_3d(frame: Frame, params: Params, key: Callable, *, everywhere: bool) -> Annotation:
    labeled_prims, selection = frame.labeled_prims, frame.selection(predicate_of(params))
    # A mesh of which labeled subsets have all faces is a gprim without any: its box is zeros.
    listed = labeled_prims.bounds[selection.rows].any(axis=(1, 2)).nonzero()[0]
    if not everywhere:
        listed = frame.in_view(predicate_of(params))
    bounds = labeled_prims.bounds[selection.rows[listed]]
    rows = np.zeros(len(listed), BOX_3D)
    for axis, name in enumerate("xyz"):
        rows[f"{name}_min"], rows[f"{name}_max"] = bounds[:, 0, axis], bounds[:, 1, axis]
    rows["transform"] = labeled_prims.local_to_world[selection.rows[listed]]
    return with_tables(frame, params, key, listed, rows)


def with_tables(frame: Frame, params: Params, key: Callable, listed: np.ndarray, rows: np.ndarray) -> Annotation:
    """Fill in ids and occlusion of `rows`, which belong to the selected prims `listed`, and add the tables."""
    predicate = predicate_of(params)
    selection = frame.selection(predicate)
    classes, class_of_prim = selection.keep("classes", lambda: np.unique(selection.class_ids, return_inverse=True))
    are_present = np.zeros(len(classes), bool)
    are_present[class_of_prim[listed]] = True
    # As in Isaac Sim, the ids of a list of boxes have no gaps.
    rows["semanticId"] = (np.cumsum(are_present) - 1)[class_of_prim[listed]]
    rows["occlusionRatio"] = frame.occlusion(predicate)[listed]
    present, paths = classes[are_present].tolist(), frame.labeled_prims.prim_paths
    info = {
        "idToLabels": {key(index): selection.class_labels[number] for index, number in enumerate(present)},
        "bboxIds": selection.ids[listed].astype(np.uint32),
        "primPaths": [paths[row] for row in selection.rows[listed].tolist()],
    }
    return Annotation(rows, info)
