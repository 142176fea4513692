"""Amodal annotators: masks that include occluded pixels, visibility, and which prims occlude which. Beyond Replicator.

They cover all labeled prims in view, also fully occluded ones, in the order and with the ids of
`instance_segmentation`; id 1 stands for all gprims without (selected) labels. Masks are sampled by the label rays, so
that visible and occluded pixels add up exactly.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import LABEL_PARAMS, Annotation, define, predicate_of
from usdsdg.annotators.colors import FIRST_LABELED, UNLABELLED
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.kinds.boxes import fill_corners
from usdsdg.annotators.pixels import masks
from usdsdg.annotators.pixels.look_ups import PIXELS, X_MIN
from usdsdg.errors import AnnotatorError

Params = Mapping[str, Any]

VISIBILITY = np.dtype(
    [
        ("instanceId", "<u4"),
        ("semanticId", "<u4"),
        ("visiblePixels", "<u4"),
        ("amodalPixels", "<u4"),
        ("x_min", "<i4"),
        ("y_min", "<i4"),
        ("x_max", "<i4"),
        ("y_max", "<i4"),
        ("visibleRatio", "<f4"),
    ]
)
OCCLUSION_PAIR = np.dtype([("occluderId", "<u4"), ("occludedId", "<u4"), ("pixels", "<u4")])

_NEEDS: Mapping[str, Any] = {"aovs": ["instance"], "needs_amodal_masks": True}
_ENCODINGS = ("stack", "rle")
# Counters that are faster to go through than the values are to sort.
MOST_COUNTERS = 1 << 20


@define(
    "amodal_instance_segmentation", dtype=np.bool_, params={**LABEL_PARAMS, "encoding": _ENCODINGS[0]},
    info={"instanceIds": np.zeros(0, np.uint32), "primPaths": [], "idToLabels": {}, "idToSemantics": {}}, **_NEEDS,
)  # fmt: skip
def amodal_instance_segmentation(frame: Frame, params: Params) -> Annotation:
    """Masks of the pixels that each labeled prim would cover alone, bool (N, H, W); prims out of view are left out.

    info: instanceIds uint32 (N,), primPaths in the order of the masks, idToLabels (prim paths) and idToSemantics by id.
    With encoding="rle" there is no array, and info has "masks": N times {"size": [H, W], "counts": run lengths} in
    COCO's uncompressed RLE, column-major, starting with pixels outside. semanticTypes or semanticFilter select labels.
    """
    encoding = params["encoding"]
    if encoding not in _ENCODINGS:
        raise AnnotatorError(f"encoding is {encoding!r}; it may be {' or '.join(map(repr, _ENCODINGS))}.")
    predicate = predicate_of(params)
    listed = frame.in_view(predicate)
    selection = frame.selection(predicate)
    rows, ids = selection.rows[listed], selection.ids[listed]
    info = {
        "instanceIds": ids.astype(np.uint32),
        "primPaths": [frame.labeled_prims.prim_paths[row] for row in rows],
        "idToLabels": _paths(frame, predicate, ids),
        "idToSemantics": {str(id_): selection.labels[member] for id_, member in zip(ids.tolist(), listed.tolist())},
    }
    if encoding == "rle":
        lengths = frame.derive("run lengths", lambda: masks.run_lengths(frame.amodal_masks))
        size = list(frame.shape)
        return Annotation(None, {**info, "masks": [{"size": size, "counts": lengths[row]} for row in rows.tolist()]})
    stack = np.zeros((len(rows), *frame.shape), bool)
    for mask, row in zip(stack, rows.tolist()):
        mask[:] = frame.amodal_masks.mask(row)
    return Annotation(stack, info)


@define(
    "visibility", dtype=VISIBILITY, params=LABEL_PARAMS, info={"primPaths": [], "hiddenBy": [], "idToLabels": {}},
    **_NEEDS,
)  # fmt: skip
def visibility(frame: Frame, params: Params) -> Annotation:
    """Visible and amodal pixel counts of every labeled prim in view, and its occluders.

    Structured (N,): instanceId and semanticId uint32, those of the segmentations, visiblePixels, amodalPixels uint32,
    x_min, y_min, x_max, y_max int32 of the amodal pixels [inclusive], visibleRatio float32 from 0 (occluded) to 1;
    info: primPaths and hiddenBy in the order of the rows, the latter {id of the occluder: pixels}, and idToLabels (prim
    paths) of all ids. Parameters as amodal_instance_segmentation.
    """
    predicate = predicate_of(params)
    selection, listed = frame.selection(predicate), frame.in_view(predicate)
    coverage = frame.coverage[selection.rows[listed]]
    rows = np.zeros(len(listed), VISIBILITY)
    rows["instanceId"] = selection.ids[listed]
    rows["semanticId"] = selection.class_ids[listed]
    rows["visiblePixels"] = frame.visible_pixels(predicate)[listed]
    rows["amodalPixels"] = coverage[:, PIXELS]
    fill_corners(rows, coverage[:, X_MIN:])
    rows["visibleRatio"] = rows["visiblePixels"] / np.maximum(rows["amodalPixels"], 1)
    pairs = _pairs(frame, predicate)
    hidden_by: dict[int, dict[str, int]] = {id_: {} for id_ in rows["instanceId"].tolist()}
    for occluder, occluded, pixels in pairs.tolist():
        hidden_by[occluded][str(occluder)] = pixels
    info = {
        "primPaths": [frame.labeled_prims.prim_paths[row] for row in selection.rows[listed]],
        "hiddenBy": list(hidden_by.values()),
        "idToLabels": _paths(frame, predicate, np.union1d(rows["instanceId"], pairs["occluderId"])),
    }
    return Annotation(rows, info)


@define("occlusion_graph", dtype=OCCLUSION_PAIR, params=LABEL_PARAMS, info={"idToLabels": {}}, **_NEEDS)
def occlusion_graph(frame: Frame, params: Params) -> Annotation:
    """Pairs of occluder and occluded prim, with the number of occluded pixels.

    Structured (P,): occluderId, occludedId uint32, those of instance_segmentation, pixels uint32; ordered by occluded,
    then occluder. The pixels of one occluded prim add up to its occluded pixels; the occluder is the first hit on the
    ray, so prims between the two are not counted. info: idToLabels (prim paths) of all ids. Parameters as
    amodal_instance_segmentation.
    """
    pairs = _pairs(frame, predicate_of(params))
    ids = np.union1d(pairs["occluderId"], pairs["occludedId"])
    return Annotation(pairs, {"idToLabels": _paths(frame, predicate_of(params), ids)})


def _pairs(frame: Frame, predicate: str | None) -> np.ndarray:
    """Return the OCCLUSION_PAIR rows of all selected prims."""
    return frame.derive(("occlusion_pairs", predicate), lambda: _count_pairs(frame, predicate))


def _count_pairs(frame: Frame, predicate: str | None) -> np.ndarray:
    selection = frame.selection(predicate)
    id_of_row = np.zeros(len(frame.labeled_prims), np.int64)
    id_of_row[selection.rows] = selection.ids
    hidden = frame.derive("hidden runs", lambda: masks.hidden_runs(frame.amodal_masks, frame.aov("instance")))
    # Gprims of no selected prim have member -1, as have pixels without a hit, and look up the appended id.
    occluder = np.append(selection.ids, UNLABELLED)[np.append(selection.member_of_gprim, -1)[hidden.hider]]
    base, occluded = selection.prim_count + FIRST_LABELED, id_of_row[hidden.group]
    keys = (occluded * base + occluder)[occluded > 0]
    keys, pixels = summed(keys, hidden.pixels[occluded > 0], base * base)
    pairs = np.zeros(len(keys), OCCLUSION_PAIR)
    pairs["occludedId"], pairs["occluderId"] = np.divmod(keys, base)
    pairs["pixels"] = pixels
    return pairs


def summed(keys: np.ndarray, numbers: np.ndarray, limit: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the different keys, ascending, all of them from 0 to below the limit, and the sum of each one's numbers.

    Numbers are positive.
    """
    if limit > MOST_COUNTERS:
        found, places = np.unique(keys, return_inverse=True)
        return found, np.bincount(places, numbers, len(found)).astype(np.int64)
    sums = np.bincount(keys, numbers, 1)  # exact: far below 2**53
    found = np.flatnonzero(sums)
    return found, sums[found].astype(np.int64)


def _paths(frame: Frame, predicate: str | None, ids: np.ndarray) -> dict[str, str]:
    """Return prim paths by id, as in instance_segmentation."""
    selection = frame.selection(predicate)
    paths = {id_: frame.labeled_prims.prim_paths[row] for id_, row in zip(selection.ids.tolist(), selection.rows)}
    return {str(id_): paths.get(id_, "UNLABELLED") for id_ in ids.tolist()}


def run_lengths(crop: np.ndarray, left: int, top: int, shape: tuple[int, int]) -> dict[str, list[int]]:
    """Encode a mask of a picture of `shape` in COCO's uncompressed RLE; all of it is in `crop`, from (left, top) on."""
    height, width = shape
    columns = np.zeros((crop.shape[1], crop.shape[0] + 2), np.int8)
    columns[:, 1:-1] = crop.T
    column, row = np.nonzero(np.diff(columns, axis=1))  # where runs begin and end, in turn
    edges = (left + column) * height + top + row
    # A run that goes on at the top of the next column is one.
    joined = np.flatnonzero(edges[1:-1:2] == edges[2::2])
    edges = np.delete(edges, np.concatenate([2 * joined + 1, 2 * joined + 2]))
    lengths = np.diff(edges, prepend=0, append=height * width)
    return {"size": [height, width], "counts": (lengths if lengths[-1] else lengths[:-1]).tolist()}
