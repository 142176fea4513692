"""The depth and label pictures of YCB-Video, and boxes as text."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.errors import warn_once

_FARTHEST = 0xFFFF  # steps of a depth picture
_FAINT = 1e-5  # what Isaac Sim has in place of the inverse of an infinite depth


def inverse_depth(meters: np.ndarray) -> np.ndarray:
    """Return Isaac Sim's picture of a depth, uint8 (H, W): white is the nearest, black the farthest of the picture."""
    inverse = np.asarray(meters, np.float32) * np.float32(100.0)
    if inverse.max(initial=0.0) > 0:
        with np.errstate(divide="ignore"):
            inverse = np.reciprocal(inverse)
    inverse = np.clip(np.where(inverse == 0.0, np.float32(_FAINT), inverse), 0, 255)
    inverse -= inverse.min(initial=255.0)
    if inverse.max(initial=0.0) > 0:
        inverse /= inverse.max()
    return (inverse * 255.0).astype(np.uint8)


def depth_steps(meters: np.ndarray, factor: int) -> np.ndarray:
    """Return YCB-Video's picture of a depth, uint16 (H, W): meters times `factor`, 0 where nothing is, or too far."""
    steps = np.round(np.where(np.isfinite(meters), meters, 0.0) * float(factor))
    if steps.max(initial=0.0) > _FARTHEST:
        warn_once(
            f"YCBVideoWriter: what is beyond {_FARTHEST / factor:.3g} m has the depth 0; a smaller factor_depth "
            "reaches further."
        )
    return np.where((steps >= 0.0) & (steps <= _FARTHEST), steps, 0.0).astype(np.uint16)


def label_picture(segmentation: Mapping[str, Any], indices: Mapping[str, int]) -> np.ndarray:
    """Return the index of the class of each pixel, uint8 (H, W); 0 for everything else.

    segmentation: an annotation `semantic_segmentation` of ids. indices: by class, in lower case.
    """
    ids, table = segmentation["data"], segmentation["idToLabels"]
    index_of = np.zeros(max((int(key) for key in table), default=0) + 1, np.uint8)
    for key, labels in table.items():
        index_of[int(key)] = indices.get(class_of(labels, indices), 0)
    return index_of[ids]


def box_lines(boxes: Mapping[str, Any], indices: Mapping[str, int]) -> str:
    """Return a line for each box: its class, first and last column and row, as `class x1 y1 x2 y2`."""
    lines = []
    for row in boxes["data"]:
        corners = " ".join(str(int(row[side])) for side in ("x_min", "y_min", "x_max", "y_max"))
        lines.append(f"{_without_blanks(class_of(boxes['idToLabels'][str(row['semanticId'])], indices))} {corners}\n")
    return "".join(lines)


def _without_blanks(name: str) -> str:
    """Return the name of a class for a line of fields that blanks separate."""
    short = "_".join(name.split())
    if short != name:
        warn_once(f"YCBVideoWriter: the class {name!r} is called {short!r} in boxes, whose names have no blanks.")
    return short


def class_of(labels: Mapping[str, str], indices: Mapping[str, int]) -> str:
    """Return the class of an object: where it has several, all of them if these have an index, else the outermost."""
    whole = str(labels.get("class") or ",".join(labels.values()))
    return whole if whole in indices else whole.split(",")[0]
