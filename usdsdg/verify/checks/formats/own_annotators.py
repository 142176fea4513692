"""BasicWriter's files beyond Replicator's: lists of objects in view, with their pixels, masks and rectangles."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.formats.basic_own import BOXES, COORDINATES, CORRESPONDENCE, MASKS, OWN, OwnFiles
from usdsdg.datasets.formats.coco import decoded
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.truth import BACKGROUND, Thing, Truth, text_of
from usdsdg.verify.checks.compare import differs, of_pixels, pairs, text
from usdsdg.verify.checks.formats.correspondence import check_correspondence
from usdsdg.verify.checks.formats.own_points import check_coordinates, check_keypoints
from usdsdg.verify.checks.rectangles import problem_of
from usdsdg.writers.formats.shapes.masks import extent

_RATIO = 1e-6
_CORNER = 0.01  # pixels by which corners of oriented boxes may be off
_BOX = ("x_min", "y_min", "x_max", "y_max")
_UNLABELLED = 1


def check(seen: Seen) -> Faults:
    """Compare the files of an image with its record."""
    own: Mapping[str, OwnFiles] = seen.extra.get(OWN, {})
    truth = seen.truth
    if truth is None:
        return
    if CORRESPONDENCE in own:
        yield from check_correspondence(seen, own[CORRESPONDENCE], truth)
    if truth.product.gprim_image is None:
        return
    for kind, files in own.items():
        if kind == "keypoints":
            yield from check_keypoints(seen, files, truth)
        elif kind == COORDINATES:
            yield from check_coordinates(seen, files, truth)
        elif truth.product.amodal is not None and truth.camera is not None:
            yield from _of_objects(seen, files, truth)
    yield from _truncated(seen, own)


def _of_objects(seen: Seen, files: OwnFiles, truth: Truth) -> Faults:
    things = [each for each in truth.things(files.filter) if each.amodal]
    if files.kind in BOXES:
        yield from _boxes(seen, files, truth, things)
    elif files.kind == "visibility":
        yield from _visibility(seen, files, things)
    elif files.kind == "truncation":
        yield from _ids(seen, files, things)
    elif files.kind == MASKS:
        yield from _masks(seen, files, truth, things)


def _ids(seen: Seen, files: OwnFiles, things: Sequence[Thing]) -> Iterator[Fault]:
    """Rows are those of the objects in view, with their ids."""
    rows = files.values
    if rows is None:
        return
    expected = [(each.id, each.class_id) for each in things]
    found = list(zip(rows["instanceId"].tolist(), rows["semanticId"].tolist()))
    if found != expected:
        yield Fault(files.file, seen.name, "ids of the objects in view", _short(expected), _short(found))


def _names(seen: Seen, files: OwnFiles, things: Sequence[Thing], *, unlabelled: bool = False) -> Iterator[Fault]:
    """The table names the objects in the order of the rows, and by their ids."""
    table = files.table
    if table is None:
        return
    paths = [each.path for each in things]
    if table.get("primPaths") != paths:
        yield Fault(files.table_file, seen.name, "primPaths", _short(paths), _short(table.get("primPaths")))
    named = {str(each.id): each.path for each in things} | ({str(_UNLABELLED): "UNLABELLED"} if unlabelled else {})
    found = table.get("idToLabels")
    if not isinstance(found, Mapping) or any(found.get(key) != path for key, path in named.items()):
        yield Fault(files.table_file, seen.name, "idToLabels", _short(named), _short(found))


def _visibility(seen: Seen, files: OwnFiles, things: Sequence[Thing]) -> Faults:
    faults = list(_ids(seen, files, things))
    yield from faults
    yield from _names(seen, files, things)
    rows, table = files.values, files.table or {}
    if rows is None or faults:
        return
    for row, thing in zip(rows, things):
        expected = (thing.visible, thing.amodal, *(thing.amodal_box or ()))
        found = tuple(int(row[name]) for name in ("visiblePixels", "amodalPixels", *_BOX))
        if found != expected:
            yield Fault(files.file, seen.name, f"pixels and box of {thing.path}", str(expected), str(found))
        visible = 1.0 - (thing.occlusion or 0.0)
        if differs(row["visibleRatio"], visible, relative=0.0, absolute=_RATIO):
            yield Fault(
                files.file, seen.name, f"visibleRatio of {thing.path}", f"{visible:.6g}", str(row["visibleRatio"])
            )
    hidden: list[Mapping[str, int]] = table.get("hiddenBy") or []
    expected = [(each.amodal or 0) - each.visible for each in things]
    found = [sum(each.values()) for each in hidden]
    if found != expected:
        what = "hiddenBy has the pixels that are not visible"
        yield Fault(files.table_file, seen.name, what, _short(expected), _short(found))
    elif unknown := {key for each in hidden for key in each} - set(table.get("idToLabels") or {}):
        what = "hiddenBy has ids that idToLabels names"
        yield Fault(files.table_file, seen.name, what, "", _short(sorted(unknown)))


def _masks(seen: Seen, files: OwnFiles, truth: Truth, things: Sequence[Thing]) -> Faults:
    """Whole masks have the pixels of the record, and hold what is visible."""
    table, members = files.table, truth.members(files.filter)
    if table is None or members is None:
        return
    ids = [each.id for each in things]
    if table.get("instanceIds") != ids:
        yield Fault(files.file, seen.name, "instanceIds", _short(ids), _short(table.get("instanceIds")))
        return
    yield from _names(seen, files, things)
    labels = {str(each.id): text_of(each.labels) for each in things}
    found = {key: text_of(each) for key, each in (table.get("idToSemantics") or {}).items()}
    if any(found.get(key) != each for key, each in labels.items()):
        yield Fault(files.file, seen.name, "idToSemantics", _short(labels), _short(found))
    order = {each.id: index for index, each in enumerate(truth.things(files.filter))}
    encoded = table.get("masks")
    if not isinstance(encoded, list) or len(encoded) != len(things):
        yield Fault(files.file, seen.name, "masks are as many as objects", str(len(things)), _short(encoded))
        return
    for thing, runs in zip(things, encoded):
        if tuple(runs["size"]) != members.shape:
            what = f"the size of the mask of {thing.path}"
            yield Fault(files.file, seen.name, what, str(members.shape), str(tuple(runs["size"])))
            continue
        try:
            mask = decoded(runs["counts"], runs["size"])
        except ValueError as error:
            yield Fault(files.file, seen.name, f"the mask of {thing.path} cannot be read: {error}")
            continue
        if (int(mask.sum()), extent(mask)) != (thing.amodal, thing.amodal_box):
            expected, is_found = f"{thing.amodal} in {thing.amodal_box}", f"{int(mask.sum())} in {extent(mask)}"
            yield Fault(files.file, seen.name, f"pixels and extent of the mask of {thing.path}", expected, is_found)
        lacking = (members == order[thing.id]) & ~mask
        if lacking.any():
            what = f"the mask of {thing.path} holds what is visible, but {of_pixels(lacking)}"
            yield Fault(files.file, seen.name, what)


def _boxes(seen: Seen, files: OwnFiles, truth: Truth, things: Sequence[Thing]) -> Faults:
    """Boxes are of the objects in view, with their labels and occlusion."""
    rows, labels, paths = files.values, files.table, files.paths
    members = truth.members(files.filter)
    if rows is None or labels is None or paths is None or members is None:
        return
    if len(paths) != len(rows):
        yield Fault(files.paths_file, seen.name, "has a prim path for each box", str(len(rows)), str(len(paths)))
        return
    kept = [each for each in things if each.visible or files.kind != "oriented_bounding_box_2d"]
    matched, faults = pairs(seen, files.paths_file, list(map(str, paths)), [each.path for each in kept], "the box of")
    yield from faults
    order = {each.path: index for index, each in enumerate(truth.things(files.filter))}
    for mine, theirs in matched:
        row, thing = rows[mine], kept[theirs]
        found = text_of(labels.get(str(int(row["semanticId"])), BACKGROUND))
        if found != thing.label:
            yield Fault(files.table_file, seen.name, f"the labels of {thing.path}", thing.label, found)
        if differs(row["occlusionRatio"], thing.occlusion or 0.0, relative=0.0, absolute=_RATIO):
            what = f"occlusionRatio of {thing.path}"
            yield Fault(files.file, seen.name, what, f"{thing.occlusion or 0.0:.6g}", str(row["occlusionRatio"]))
        if files.kind == "bounding_box_2d_amodal":
            yield from _whole(seen, files, row, thing)
        else:
            mask = members == order[thing.path] if files.kind == "oriented_bounding_box_2d" else None
            yield from _oriented(seen, files, row, thing, mask)


def _whole(seen: Seen, files: OwnFiles, row: np.void, thing: Thing) -> Faults:
    """The box of a whole object holds that of what is in the picture, and is it where nothing is outside."""
    box, inside = tuple(int(row[name]) for name in _BOX), thing.amodal_box or (0, 0, 0, 0)
    holds = all(a <= b for a, b in zip(box[:2], inside[:2])) and all(a >= b for a, b in zip(box[2:], inside[2:]))
    if not holds or (row["truncationRatio"] == 0 and box != inside):
        yield Fault(files.file, seen.name, f"the box of {thing.path} holds its pixels", str(inside), str(box))
    if not 0 <= row["truncationRatio"] < 1:
        yield Fault(files.file, seen.name, f"truncationRatio of {thing.path}", "0 to 1", str(row["truncationRatio"]))


def _oriented(seen: Seen, files: OwnFiles, row: np.void, thing: Thing, mask: np.ndarray | None) -> Faults:
    """Center, sides and angle are those of the corners, which are around the pixels."""
    corners = row["corners"].astype(np.float64)
    turn = np.radians(float(row["angle"]))
    along = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    halves = along * np.array([[row["width"]], [row["height"]]], np.float64) / 2
    center = np.array([row["x"], row["y"]], np.float64)
    expected = center + np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) @ halves
    # The corners begin with the topmost one.
    off = min(np.abs(np.roll(corners, turned, axis=0) - expected).max() for turned in range(4))
    what = f"the oriented box of {thing.path}"
    if not off <= _CORNER:
        yield Fault(files.file, seen.name, f"{what} has the corners of its sides", text(expected), text(corners))
    elif mask is not None and (problem := problem_of(corners, mask)):
        yield Fault(files.file, seen.name, f"{what} {problem}", "", text(corners))
    elif mask is None and thing.amodal_box is not None:
        low, high = corners.min(axis=0) - _CORNER, corners.max(axis=0) + _CORNER
        box = np.array(thing.amodal_box, np.float64).reshape(2, 2) + np.array([[0], [1]])
        if (box[0] < low).any() or (box[1] > high).any():
            yield Fault(files.file, seen.name, f"{what} holds its pixels", str(thing.amodal_box), text([*low, *high]))


def _truncated(seen: Seen, own: Mapping[str, OwnFiles]) -> Faults:
    """The share outside of the picture is the same in both files that have it."""
    boxes, shares = own.get("bounding_box_2d_amodal"), own.get("truncation")
    if boxes is None or shares is None or boxes.values is None or shares.values is None:
        return
    mine, theirs = (np.sort(each.values["truncationRatio"]) for each in (shares, boxes) if each.values is not None)
    if boxes.filter == shares.filter and differs(mine, theirs, relative=0.0, absolute=_RATIO):
        yield Fault(shares.file, seen.name, f"truncationRatio is as in {boxes.file}", text(theirs), text(mine))


def _short(values: Any) -> str:
    found = str(values)
    return found if len(found) <= 120 else f"{found[:117]}..."
