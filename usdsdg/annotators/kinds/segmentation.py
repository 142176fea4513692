"""Segmentation: the id of every pixel, and tables from ids to labels and prims.

Ids: 0 is background, 1 is a gprim without (selected) labels, labeled prims count from 2 in stage order. They depend on
the stage only, not on what is in view or on earlier frames; the tables list the ids that are present in the image.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from usdsdg.annotators.base import LABEL_PARAMS, Annotation, define, predicate_of
from usdsdg.annotators.colors import BACKGROUND, FIRST_LABELED, UNLABELLED, colors_of_ids
from usdsdg.annotators.frame import Frame
from usdsdg.errors import AnnotatorError, warn_once

Params = Mapping[str, Any]
_COLORIZE: Params = {"colorize": False, "mapping": None}
_BACKGROUND_LABEL, _UNLABELLED_LABEL = {"class": "BACKGROUND"}, {"class": "UNLABELLED"}


@define("semantic_segmentation", aovs=["instance"], params={**LABEL_PARAMS, **_COLORIZE}, dtype=np.uint32)
def semantic_segmentation(frame: Frame, params: Params) -> Annotation:
    """Id of the label of each pixel, uint32 (H, W), or its color, uint8 (H, W, 4).

    Prims with equal labels share an id. `mapping` {"type:label": RGBA or id}, or a JSON file of it, overrides ids and
    colors.
    """
    selection = frame.selection(predicate_of(params))
    labels, id_of_member = unique_labels(selection.labels)
    ids = _labeled_prim_ids(frame, predicate_of(params), id_of_member + FIRST_LABELED)
    described = [_BACKGROUND_LABEL, _UNLABELLED_LABEL, *labels]
    ids, old, color_of = _mapped(ids, params["mapping"], lambda: [_keys(own) for own in described])
    return _annotation(ids, params, {"idToLabels": lambda i: described[old(i)]}, str, color_of)


@define("instance_segmentation", aovs=["instance"], params={**LABEL_PARAMS, **_COLORIZE}, dtype=np.uint32)
def instance_segmentation(frame: Frame, params: Params) -> Annotation:
    """Id of the labeled prim (nearest labeled ancestor) of each pixel, uint32 (H, W), or its color, uint8 (H, W, 4).

    Keys of the tables are strings. `mapping` as for semantic_segmentation, also with prim paths as keys; prims that it
    maps to the same id or color share an entry in the tables.
    """
    return _instances(frame, params, str)


@define("instance_segmentation_fast", aovs=["instance"], params={**LABEL_PARAMS, **_COLORIZE}, dtype=np.uint32)
def instance_segmentation_fast(frame: Frame, params: Params) -> Annotation:
    """As instance_segmentation; keys of the tables are integers, or RGBA tuples."""
    return _instances(frame, params, _identity)


@define("instance_id_segmentation", aovs=["instance"], params={**LABEL_PARAMS, **_COLORIZE}, dtype=np.uint32)
def instance_id_segmentation(frame: Frame, params: Params) -> Annotation:
    """Id of the gprim of each pixel, labeled or not, uint32 (H, W), or its color, uint8 (H, W, 4).

    Keys of the table are strings. `mapping` as for instance_segmentation.
    """
    return _gprims(frame, params, str)


@define("instance_id_segmentation_fast", aovs=["instance"], params={**LABEL_PARAMS, **_COLORIZE}, dtype=np.uint32)
def instance_id_segmentation_fast(frame: Frame, params: Params) -> Annotation:
    """As instance_id_segmentation; keys of the table are integers, or RGBA tuples."""
    return _gprims(frame, params, _identity)


def unique_labels(labels: Sequence[dict[str, str]]) -> tuple[list[dict[str, str]], np.ndarray]:
    """Return the distinct label sets in order of first use, and the index of each member's set."""
    index_of: dict[tuple, int] = {}
    indices = [index_of.setdefault(tuple(sorted(own.items())), len(index_of)) for own in labels]
    return [dict(key) for key in index_of], np.array(indices, np.int64)


def _instances(frame: Frame, params: Params, key: Callable) -> Annotation:
    predicate = predicate_of(params)
    selection = frame.selection(predicate)
    paths = ["BACKGROUND", "UNLABELLED", *(frame.labeled_prims.prim_paths[row] for row in selection.rows)]
    labels = [_BACKGROUND_LABEL, _UNLABELLED_LABEL, *selection.labels]
    ids = _labeled_prim_ids(frame, predicate, np.arange(len(selection)) + FIRST_LABELED)
    ids, old, color_of = _mapped(
        ids, params["mapping"], lambda: [[path, *_keys(own)] for path, own in zip(paths, labels)]
    )
    tables = {"idToLabels": lambda i: paths[old(i)], "idToSemantics": lambda i: labels[old(i)]}
    return _annotation(ids, params, tables, key, color_of)


def _gprims(frame: Frame, params: Params, key: Callable) -> Annotation:
    instance = frame.aov("instance")
    ids = np.where(instance >= 0, instance + FIRST_LABELED, BACKGROUND).astype(np.uint32)
    names = ["BACKGROUND", "UNLABELLED", *frame.gprims]

    def keys() -> list[list[str]]:
        selection = frame.selection(predicate_of(params))
        labels = [selection.labels[member] if member >= 0 else {} for member in selection.member_of_gprim]
        return [[name, *_keys(own)] for name, own in zip(names, [_BACKGROUND_LABEL, _UNLABELLED_LABEL, *labels])]

    ids, old, color_of = _mapped(ids, params["mapping"], keys)
    return _annotation(ids, params, {"idToLabels": lambda i: names[old(i)]}, key, color_of)


def _labeled_prim_ids(frame: Frame, predicate: str | None, id_of_member: np.ndarray) -> np.ndarray:
    """Return (H, W) uint32 ids by one look-up from the gprim of each pixel."""
    members = frame.selection(predicate).member_of_gprim
    id_of_gprim = np.append(id_of_member, UNLABELLED)[members]  # member -1 looks up the appended id
    table = np.append(id_of_gprim, BACKGROUND).astype(np.uint32)  # as does gprim -1, no hit
    return table[frame.aov("instance")]


def _annotation(
    ids: np.ndarray,
    params: Params,
    tables: Mapping[str, Callable[[int], Any]],
    key: Callable,
    color_of: Callable[[np.ndarray], np.ndarray],
) -> Annotation:
    """Build the annotation of `ids` with its tables, keyed by id or, if colorized, by color."""
    present = np.flatnonzero(np.bincount(ids.ravel()))
    if not params["colorize"]:
        info = {name: {key(int(i)): entry(int(i)) for i in present} for name, entry in tables.items()}
        return Annotation(ids, info)
    colors = color_of(present)
    palette = np.zeros((int(present[-1]) + 1 if len(present) else 1, 4), np.uint8)
    palette[present] = colors
    # One 32-bit look-up per pixel is faster than four of bytes.
    image = palette.view(np.uint32)[:, 0][ids].view(np.uint8).reshape(*ids.shape, 4)
    keys = [tuple(int(channel) for channel in color) for color in colors]
    if len(set(keys)) < len(keys):
        warn_once("Two segmentation ids got the same color; use colorize=False to tell them apart.")
    # Ordered by color, as in Replicator's files.
    order = sorted(range(len(keys)), key=keys.__getitem__)
    info = {name: {key(keys[k]): entry(int(present[k])) for k in order} for name, entry in tables.items()}
    return Annotation(image, info)


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
    ids: np.ndarray, mapping: Any, keys: Callable[[], Sequence[Sequence[str]]]
) -> tuple[np.ndarray, Callable[[int], int], Callable[[np.ndarray], np.ndarray]]:
    """Apply `mapping` to `ids`; return the new ids, and functions from new to old id and from new ids to colors.

    keys: for each id the keys to look up in `mapping`; the first that it contains applies.
    """
    if not mapping:
        return ids, _identity, colors_of_ids
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
    seen = np.flatnonzero(np.bincount(ids.ravel(), minlength=len(known)))
    old_id = {int(new_id[old]): int(old) for old in reversed(seen)}

    def color_of(present: np.ndarray) -> np.ndarray:
        colors = colors_of_ids(present)
        for index, color in chosen.items():
            colors[present == new_id[index]] = (*color[:3], color[3] if len(color) > 3 else 255)
        return colors

    return new_id[ids], old_id.__getitem__, color_of
