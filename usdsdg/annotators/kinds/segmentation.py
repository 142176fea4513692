"""Segmentation: the id of every pixel, and tables from ids to labels and prims.

Ids: 0 is background, 1 is a gprim without (selected) labels. Labeled prims and gprims count from 2 in stage order, then
the points of point instancers, classes have the ids of the class table (`class_table.py`). They stay the same for all
frames of a stage, whatever is hidden, removed or added; the tables list 0, 1 and the ids that are present in the image,
as Isaac Sim's do.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from usdsdg.annotators.base import LABEL_PARAMS, Annotation, define, predicate_of
from usdsdg.annotators.colors import BACKGROUND, FIRST_LABELED, UNLABELLED, colors_of_ids
from usdsdg.annotators.frame import Frame
from usdsdg.errors import AnnotatorError, warn_once

Params = Mapping[str, Any]
_COLORIZE: Params = {"colorize": False, "mapping": None}
_NEEDS: Mapping[str, Any] = {"aovs": ["instance"], "params": {**LABEL_PARAMS, **_COLORIZE}, "dtype": np.uint32}
# Info before the first frame.
_NO_LABELS: Mapping[str, Any] = {"idToLabels": {}}
_NO_PRIMS: Mapping[str, Any] = {"idToLabels": {}, "idToSemantics": {}}
_NONE, _NO_COLORS = np.zeros(0, np.int64), np.zeros((0, 4), np.uint8)
_BACKGROUND_LABEL, _UNLABELLED_LABEL = {"class": "BACKGROUND"}, {"class": "UNLABELLED"}


class Shown(NamedTuple):
    """The ids of a segmentation after a mapping, and what they stand for."""

    ids: np.ndarray  # (G + 1,) uint32: of each gprim, and of pixels without a hit
    tables: Mapping[str, Sequence[Any]]  # of annotators' info, by the id before the mapping
    listed: np.ndarray = _NONE  # (N,): ids that the tables list
    meanings: np.ndarray = _NONE  # (N,): the id of each before the mapping
    listed_colors: np.ndarray = _NO_COLORS  # (N, 4) uint8

    @property
    def colors(self) -> np.ndarray:
        """The color of each gprim in the picture, and of pixels without a hit, (G + 1, 4) uint8."""
        palette = np.zeros((int(self.ids.max()) + 1, 4), np.uint8)
        known = self.listed < len(palette)
        palette[self.listed[known]] = self.listed_colors[known]
        return palette[self.ids]


@define("semantic_segmentation", info=_NO_LABELS, **_NEEDS)
def semantic_segmentation(frame: Frame, params: Params) -> Annotation:
    """Id of the label of each pixel, uint32 (H, W), or its color, uint8 (H, W, 4).

    Prims with equal labels share an id. `mapping` {"type:label": RGBA or id}, or a JSON file of it, overrides ids and
    colors.
    """
    return _annotation(frame, shown_classes(frame, params), params, str)


def shown_classes(frame: Frame, params: Params) -> Shown:
    """Return the ids that semantic_segmentation shows."""
    return _once(frame, params, _classes)


def _classes(frame: Frame, params: Params) -> Shown:
    selection = frame.selection(predicate_of(params))
    ids = _labeled_prim_ids(frame, predicate_of(params), selection.class_ids)
    described = [_BACKGROUND_LABEL, _UNLABELLED_LABEL]
    described += [
        selection.class_labels.get(id_, {}) for id_ in range(FIRST_LABELED, max(selection.class_labels, default=0) + 1)
    ]
    shown = Shown(ids, {"idToLabels": described})
    return _mapped(
        frame, shown, params["mapping"], lambda: [_keys(own) for own in described], colors=selection.class_colors
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
    return _once(frame, params, _prims)


def _prims(frame: Frame, params: Params) -> Shown:
    predicate = predicate_of(params)
    selection = frame.selection(predicate)
    paths = ["BACKGROUND", "UNLABELLED", *[""] * selection.prim_count]
    labels = [_BACKGROUND_LABEL, _UNLABELLED_LABEL, *[{}] * selection.prim_count]
    for row, number, own in zip(selection.rows, selection.ids, selection.labels):
        paths[number], labels[number] = frame.labeled_prims.prim_paths[row], own
    ids = _labeled_prim_ids(frame, predicate, selection.ids)
    shown = Shown(ids, {"idToLabels": paths, "idToSemantics": labels})
    return _mapped(frame, shown, params["mapping"], lambda: [[path, *_keys(own)] for path, own in zip(paths, labels)])


def _gprims(frame: Frame, params: Params, key: Callable) -> Annotation:
    return _annotation(frame, shown_gprims(frame, params), params, key)


def shown_gprims(frame: Frame, params: Params) -> Shown:
    """Return the ids that instance_id_segmentation shows."""
    return _once(frame, params, _every_gprim)


def _every_gprim(frame: Frame, params: Params) -> Shown:
    numbers = frame.labeled_prims.gprim_numbers
    own = (np.arange(len(frame.gprims)) if numbers is None else numbers) + FIRST_LABELED
    names = ["INVALID", "UNLABELLED", *[""] * (int(own.max(initial=FIRST_LABELED - 1)) + 1 - FIRST_LABELED)]
    for number, gprim in zip(own.tolist(), frame.gprims):
        names[number] = gprim

    def keys() -> list[list[str]]:
        described = [_BACKGROUND_LABEL, _UNLABELLED_LABEL, *[{}] * (len(names) - FIRST_LABELED)]
        selection = frame.selection(predicate_of(params))
        for number, member in zip(own.tolist(), selection.member_of_gprim.tolist()):
            described[number] = selection.labels[member] if member >= 0 else {}
        return [["BACKGROUND"] if name == "INVALID" else [name, *_keys(own)] for name, own in zip(names, described)]

    ids = np.append(own, BACKGROUND).astype(np.uint32)
    return _mapped(frame, Shown(ids, {"idToLabels": names}), params["mapping"], keys, always=(BACKGROUND,))


def _once(frame: Frame, params: Params, find: Callable[[Frame, Params], Shown]) -> Shown:
    """Return what a function finds, which annotators that differ in what they make of it share."""
    key = (find, predicate_of(params), json.dumps(params["mapping"], sort_keys=True, default=str))
    return frame.derive(key, lambda: find(frame, params))


def _labeled_prim_ids(frame: Frame, predicate: str | None, id_of_member: np.ndarray) -> np.ndarray:
    """Return the table (G + 1,) uint32 of ids by gprim, with a last entry for pixels without a hit."""
    members = frame.selection(predicate).member_of_gprim
    id_of_gprim = np.append(id_of_member, UNLABELLED)[members]  # member -1 looks up the appended id
    return np.append(id_of_gprim, BACKGROUND).astype(np.uint32)


def _annotation(frame: Frame, shown: Shown, params: Params, key: Callable[[Any], Any]) -> Annotation:
    """Build the annotation of ids with its tables of meanings, keyed by id or, if colorized, by color."""
    if not params["colorize"]:
        listed = list(zip(shown.listed.tolist(), shown.meanings.tolist()))
        info = {name: {key(id_): table[old] for id_, old in listed} for name, table in shown.tables.items()}
        return Annotation(frame.look_up(shown.ids), info)
    keys = [tuple(color) for color in shown.listed_colors.tolist()]
    if len(set(keys)) < len(keys):
        warn_once("Two segmentation ids got the same color; use colorize=False to tell them apart.")
    # Ordered by color, as in Replicator's files.
    rows = sorted(zip(keys, shown.meanings.tolist()))
    info = {name: {key(color): table[old] for color, old in rows} for name, table in shown.tables.items()}
    return Annotation(frame.look_up(shown.colors), info)


def _identity(value: Any) -> Any:
    return value


# Ids and colors chosen by the user


def _read_mapping(mapping: Any) -> Mapping[str, Any]:
    if isinstance(mapping, str):
        try:
            text = mapping if mapping.lstrip().startswith("{") else Path(mapping).read_text(encoding="utf-8")
            mapping = json.loads(text)
        except (OSError, ValueError) as error:
            raise AnnotatorError(f"mapping is {mapping!r}, which cannot be read as JSON: {error}.") from error
    if not isinstance(mapping, Mapping):
        raise AnnotatorError(
            f"mapping must be {{'type:label': RGBA or id}}, a JSON text or file of it, not {mapping!r}."
        )
    return mapping


def _keys(labels: Mapping[str, str]) -> list[str]:
    return [f"{kind}:{label}" for kind, label in labels.items()]


def _mapped(
    frame: Frame,
    shown: Shown,
    mapping: Any,
    keys: Callable[[], Sequence[Sequence[str]]],
    *,
    always: Sequence[int] = (BACKGROUND, UNLABELLED),
    colors: Mapping[int, tuple[int, ...]] | None = None,
) -> Shown:
    """Apply `mapping` to ids, and list those that are in the picture.

    keys: for each id the keys to look up in `mapping`; the first that it contains applies.
    always: ids that are listed whether or not they are in the image.
    colors: RGBA of some ids, before the mapping.
    """
    in_picture = np.append(frame.shown_gprims, [-1] if frame.shows_background else []).astype(np.int64)
    present = np.unique(shown.ids[in_picture]).astype(np.int64)
    if not mapping:
        listed = np.union1d(present, np.array(always, np.int64))
        return shown._replace(listed=listed, meanings=listed, listed_colors=_colored(listed, colors))
    chosen_by_key = _read_mapping(mapping)
    known = keys()
    new_id = np.arange(len(known), dtype=np.uint32)
    chosen: dict[int, tuple[int, ...]] = {}
    for index, names in enumerate(known):
        value = next((chosen_by_key[name] for name in names if name in chosen_by_key), None)
        if isinstance(value, int):
            new_id[index] = value
        elif value is not None:
            chosen[index] = tuple(int(channel) for channel in value)
    # Of several old ids with the same new id, the first that is visible represents all.
    old_id: dict[int, int] = {}
    for old in (*present.tolist(), *always):
        old_id.setdefault(int(new_id[old]), old)
    ids = np.array(sorted(old_id), np.int64)
    meanings = np.array([old_id[i] for i in ids.tolist()], np.int64)
    found = np.where((ids == meanings)[:, None], _colored(ids, colors), colors_of_ids(ids))
    for index, color in chosen.items():
        found[ids == new_id[index]] = (*color[:3], color[3] if len(color) > 3 else 255)
    return Shown(new_id[shown.ids], shown.tables, ids, meanings, found)


def _colored(ids: np.ndarray, own: Mapping[int, tuple[int, ...]] | None) -> np.ndarray:
    """Return the colors of ids (N, 4) uint8, with those of `own` in place of the usual ones."""
    colors = colors_of_ids(ids)
    for id_, color in (own or {}).items():
        colors[ids == id_] = color
    return colors
