"""Segmentation: the id of every pixel, and tables from ids to labels and prims.

Ids: 0 is background, 1 is a gprim without (selected) labels. Labeled prims and gprims count from 2 in stage order, then
the points of point instancers, classes have the ids of the class table (`class_table.py`). They stay the same for all
frames of a stage, whatever is hidden, removed or added; the tables list 0, 1 and the ids that are present in the image,
as Isaac Sim's do.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import LABEL_PARAMS, Annotation, define
from usdsdg.annotators.colors import BACKGROUND, FIRST_LABELED, UNLABELLED
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.kinds.id_mapping import check_mapping
from usdsdg.annotators.kinds.segment_ids import Ids, Shown, shown_ids
from usdsdg.annotators.selection import Selection
from usdsdg.errors import warn_once

Params = Mapping[str, Any]
_COLORIZE: Params = {"colorize": False, "mapping": None}
_NEEDS: Mapping[str, Any] = {
    "aovs": ["instance"], "params": {**LABEL_PARAMS, **_COLORIZE}, "dtype": np.uint32, "check": check_mapping,
}  # fmt: skip
# Info before the first frame.
_NO_LABELS: Mapping[str, Any] = {"idToLabels": {}}
_NO_PRIMS: Mapping[str, Any] = {"idToLabels": {}, "idToSemantics": {}}
_BACKGROUND_LABEL, _UNLABELLED_LABEL = {"class": "BACKGROUND"}, {"class": "UNLABELLED"}


@define("semantic_segmentation", info=_NO_LABELS, **_NEEDS)
def semantic_segmentation(frame: Frame, params: Params) -> Annotation:
    """Id of the label of each pixel, uint32 (H, W), or its color, uint8 (H, W, 4).

    Prims with equal labels share an id. `mapping` {"type:label": RGBA or id}, or a JSON file of it, overrides ids and
    colors. Labels may be in upper case; those without a type have the type "class".
    """
    return _annotation(frame, shown_classes(frame, params), params, str)


def shown_classes(frame: Frame, params: Params) -> Shown:
    """Return the ids that semantic_segmentation shows."""
    return shown_ids(frame, params, _classes)


def _classes(frame: Frame, selection: Selection) -> Ids:
    described = [_BACKGROUND_LABEL, _UNLABELLED_LABEL]
    described += [
        selection.class_labels.get(id_, {}) for id_ in range(FIRST_LABELED, max(selection.class_labels, default=0) + 1)
    ]
    return Ids(
        _ids_of_entries(selection, selection.class_ids),
        {"idToLabels": described},
        lambda: [[*_keys(own), *_grounds(own)] for own in described],
        own_colors=selection.class_colors,
    )


@define("instance_segmentation", info=_NO_PRIMS, **_NEEDS)
def instance_segmentation(frame: Frame, params: Params) -> Annotation:
    """Id of the labeled prim (nearest labeled ancestor) of each pixel, uint32 (H, W), or its color, uint8 (H, W, 4).

    Keys of the tables are strings. `mapping` as for semantic_segmentation, also with prim paths as keys; prims that it
    maps to the same id or color share an entry in the tables.
    """
    return _instances(frame, params, str)


@define("instance_segmentation_fast", info=_NO_PRIMS, **_NEEDS)
def instance_segmentation_fast(frame: Frame, params: Params) -> Annotation:
    """As instance_segmentation; keys of the tables are integers, or RGBA tuples."""
    return _instances(frame, params, _identity)


@define("instance_id_segmentation", info=_NO_LABELS, **_NEEDS)
def instance_id_segmentation(frame: Frame, params: Params) -> Annotation:
    """Id of the gprim of each pixel, labeled or not, uint32 (H, W), or its color, uint8 (H, W, 4).

    Keys of the table are strings. `mapping` as for instance_segmentation.
    """
    return _gprims(frame, params, str)


@define("instance_id_segmentation_fast", info=_NO_LABELS, **_NEEDS)
def instance_id_segmentation_fast(frame: Frame, params: Params) -> Annotation:
    """As instance_id_segmentation; keys of the table are integers, or RGBA tuples."""
    return _gprims(frame, params, _identity)


def _instances(frame: Frame, params: Params, key: Callable) -> Annotation:
    return _annotation(frame, shown_prims(frame, params), params, key)


def shown_prims(frame: Frame, params: Params) -> Shown:
    """Return the ids that instance_segmentation shows."""
    return shown_ids(frame, params, _prims)


def _prims(frame: Frame, selection: Selection) -> Ids:
    paths = ["BACKGROUND", "UNLABELLED", *[""] * selection.prim_count]
    labels = [_BACKGROUND_LABEL, _UNLABELLED_LABEL, *[{}] * selection.prim_count]
    for row, number, own in zip(selection.rows, selection.ids, selection.labels):
        paths[number], labels[number] = frame.labeled_prims.prim_paths[row], own
    return Ids(
        _ids_of_entries(selection, selection.ids),
        {"idToLabels": paths, "idToSemantics": labels},
        lambda: [[path, *_keys(own)] for path, own in zip(paths, labels)],
    )


def _gprims(frame: Frame, params: Params, key: Callable) -> Annotation:
    return _annotation(frame, shown_gprims(frame, params), params, key)


def shown_gprims(frame: Frame, params: Params) -> Shown:
    """Return the ids that instance_id_segmentation shows."""
    return shown_ids(frame, params, _every_gprim)


def _every_gprim(frame: Frame, selection: Selection) -> Ids:
    numbers = frame.labeled_prims.gprim_numbers
    own = (np.arange(len(frame.gprims)) if numbers is None else numbers) + FIRST_LABELED
    names = ["INVALID", "UNLABELLED", *[""] * (int(own.max(initial=FIRST_LABELED - 1)) + 1 - FIRST_LABELED)]
    for number, gprim in zip(own.tolist(), frame.gprims):
        names[number] = gprim

    def keys() -> list[list[str]]:
        described = [_BACKGROUND_LABEL, _UNLABELLED_LABEL, *[{}] * (len(names) - FIRST_LABELED)]
        for number, member in zip(own.tolist(), selection.member_of_gprim.tolist()):
            described[number] = selection.labels[member] if member >= 0 else {}
        return [["BACKGROUND"] if name == "INVALID" else [name, *_keys(own)] for name, own in zip(names, described)]

    return Ids(np.append(own, BACKGROUND).astype(np.uint32), {"idToLabels": names}, keys, always=(BACKGROUND,))


def _ids_of_entries(selection: Selection, id_of_member: np.ndarray) -> np.ndarray:
    """Return the table (G + 1,) uint32 of ids by gprim, with a last entry for pixels without a hit."""
    id_of_gprim = np.append(id_of_member, UNLABELLED)[selection.member_of_gprim]  # member -1 looks up the appended id
    return np.append(id_of_gprim, BACKGROUND).astype(np.uint32)


def _annotation(frame: Frame, shown: Shown, params: Params, key: Callable[[Any], Any]) -> Annotation:
    """Build the annotation of ids with its tables of meanings, keyed by id or, if colorized, by color."""
    if not params["colorize"]:
        listed = list(zip(shown.listed.tolist(), shown.meanings.tolist()))
        info = {name: {key(id_): table[old] for id_, old in listed} for name, table in shown.tables.items()}
        return Annotation(frame.look_up(shown.table), info)
    keys = [tuple(color) for color in shown.listed_colors.tolist()]
    if len(set(keys)) < len(keys):
        warn_once("Two segmentation ids got the same color; use colorize=False to tell them apart.")
    # Ordered by color, as in Replicator's files.
    rows = sorted(zip(keys, shown.meanings.tolist()))
    info = {name: {key(color): table[old] for color, old in rows} for name, table in shown.tables.items()}
    return Annotation(frame.look_up(shown.colors), info)


def _identity(value: Any) -> Any:
    return value


def _grounds(labels: Mapping[str, str]) -> list[str]:
    """Return what pixels without a label are called, which mappings may have without a type."""
    return [label for label in labels.values() if labels in (_BACKGROUND_LABEL, _UNLABELLED_LABEL)]


def _keys(labels: Mapping[str, str]) -> list[str]:
    return [f"{kind}:{label}" for kind, label in labels.items()]
