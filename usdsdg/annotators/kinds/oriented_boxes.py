"""Oriented 2D boxes: the rectangle of least area around each object's pixels. Beyond Replicator."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import LABEL_PARAMS, Annotation, define, predicate_of
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.kinds.boxes import NO_TABLES, with_tables
from usdsdg.annotators.pixels.launch import MASKS, run
from usdsdg.annotators.pixels.look_ups import PIXELS

Params = Mapping[str, Any]

ORIENTED_BOX_2D = np.dtype(
    [
        ("semanticId", "<u4"),
        ("x", "<f4"),
        ("y", "<f4"),
        ("width", "<f4"),
        ("height", "<f4"),
        ("angle", "<f4"),
        ("corners", "<f4", (4, 2)),
        ("occlusionRatio", "<f4"),
    ]
)

_NEEDS: Mapping[str, Any] = {"aovs": ["instance"], "needs_amodal_masks": True, "params": LABEL_PARAMS}
# Columns of rectangles, as the kernel returns them.
_X, _Y, _DX, _DY, _WIDTH, _HEIGHT = range(6)


@define("oriented_bounding_box_2d", dtype=ORIENTED_BOX_2D, info=NO_TABLES, **_NEEDS)
def oriented_bounding_box_2d(frame: Frame, params: Params) -> Annotation:
    """Rectangles of least area around the visible pixels of each labeled prim, which they contain whole [pixels].

    Structured (N,): semanticId uint32 (from 0), center x, y, width, height float32, angle float32 [degrees] from 0 to
    below 90, from the picture's x axis to the side `width`, clockwise as rows count downwards; corners float32 (4, 2),
    column and row, clockwise from the topmost (of two, the left one); occlusionRatio float32. Positions count from the
    top left corner of the picture: pixel (u, v) is the square from (u, v) to (u + 1, v + 1). info and parameters as
    bounding_box_2d_tight.
    """
    return _boxes(frame, params, "visible")


@define("oriented_bounding_box_2d_amodal", dtype=ORIENTED_BOX_2D, info=NO_TABLES, **_NEEDS)
def oriented_bounding_box_2d_amodal(frame: Frame, params: Params) -> Annotation:
    """As oriented_bounding_box_2d, of the pixels in the picture that each prim would cover alone."""
    return _boxes(frame, params, "covered")


def _boxes(frame: Frame, params: Params, bits: str) -> Annotation:
    predicate = predicate_of(params)
    selection = frame.selection(predicate)
    pixels = frame.visible_pixels(predicate) if bits == "visible" else frame.coverage[selection.rows, PIXELS]
    listed = np.flatnonzero(pixels > 0)
    found = frame.derive(("least rectangles", bits), lambda: _rectangles(frame, bits))[selection.rows[listed]]
    rows = np.zeros(len(listed), ORIENTED_BOX_2D)
    for column, name in ((_X, "x"), (_Y, "y")):
        rows[name] = found[:, column]
    angle, width, height = _canonical(found)
    rows["angle"], rows["width"], rows["height"] = np.degrees(angle), width, height
    rows["corners"] = _corners(found[:, :2], angle, width, height)
    return with_tables(frame, params, str, listed, rows)


def _canonical(found: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return angles [radians] from 0 to below a quarter turn, with the sides that go with them."""
    angle = np.arctan2(found[:, _DY], found[:, _DX])
    turns = np.floor(angle / (np.pi / 2) + 1e-12)
    angle = np.maximum(angle - turns * (np.pi / 2), 0.0)
    swapped = turns.astype(np.int64) % 2 == 1
    width = np.where(swapped, found[:, _HEIGHT], found[:, _WIDTH])
    return angle, width, np.where(swapped, found[:, _WIDTH], found[:, _HEIGHT])


def _corners(center: np.ndarray, angle: np.ndarray, width: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Return (N, 4, 2) corners, clockwise in the picture from the one that is topmost."""
    along = np.stack([np.cos(angle), np.sin(angle)], axis=1) * (width / 2)[:, None]
    down = np.stack([-np.sin(angle), np.cos(angle)], axis=1) * (height / 2)[:, None]
    return np.stack(
        [center - along - down, center + along - down, center + along + down, center - along + down], axis=1
    )


def _rectangles(frame: Frame, bits: str) -> np.ndarray:
    """Return (rows of labeled prims, 6) rectangles: center, direction of the width, width and height."""
    from usdsdg.annotators.pixels.rectangle_kernels import least_rectangles  # imports Warp

    words = frame.amodal_masks.words
    words = words[words[bits] > 0]
    group, row = words["group"], words["row"]
    is_first = np.ones(len(words), bool)  # word of a row of a mask
    is_first[1:] = (group[1:] != group[:-1]) | (row[1:] != row[:-1])
    is_last = np.append(is_first[1:], True)[: len(words)]
    first, last = words[is_first], words[is_last]
    lefts = first["word"] * 64 + _lowest_bit(first[bits])
    rights = last["word"] * 64 + _highest_bit(last[bits]) + 1
    found = np.zeros((len(frame.labeled_prims), 6))
    starts = np.searchsorted(first["group"], np.arange(len(found) + 1)).astype(np.int32)
    scratch = [np.empty(2 * len(first)) for _ in range(4)]
    ints = [np.ascontiguousarray(each, np.int32) for each in (starts, first["row"], lefts, rights)]
    if len(first):
        run(least_rectangles, (len(found),), [*ints, *scratch], [found], band=MASKS)
    return found


def _lowest_bit(words: np.ndarray) -> np.ndarray:
    """Return the index of the lowest bit of each uint64, none of which is 0."""
    return np.log2((words & (~words + np.uint64(1))).astype(np.float64)).astype(np.int32)


def _highest_bit(words: np.ndarray) -> np.ndarray:
    """Return the index of the highest bit of each uint64, none of which is 0."""
    high = (words >> np.uint64(32)).astype(np.uint32)
    half = np.where(high > 0, high, words.astype(np.uint32))
    return np.log2(half.astype(np.float64)).astype(np.int32) + np.where(high > 0, 32, 0)
