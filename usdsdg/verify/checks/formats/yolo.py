"""YOLO: a line for each visible object, with the number of its class, its box or its outline, and all classes named."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.polygons import filled
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.truth import Thing, Truth
from usdsdg.errors import counted
from usdsdg.record import CLASSES
from usdsdg.verify.checks.compare import differs, of_pixels, text
from usdsdg.verify.checks.rectangles import least_rectangles
from usdsdg.writers.formats.shapes.polygons import without_holes
from usdsdg.writers.formats.yolo.oriented import fitted
from usdsdg.writers.formats.yolo.yolo_files import DESCRIPTION, IMAGES, NAME

BOXES, KEYPOINTS = "bounding_box_2d_tight_fast", "keypoints"
_DIGITS = 2e-6  # of fractions of the picture
_BOX = 4  # numbers of a box; an outline has more
_KEYPOINT = 0.02  # pixels: positions of the record are float32, those of the files have few digits
_CORNERS = 4  # of an oriented box
_NEAR = 0.01  # pixels by which corners of oriented boxes may be off


class Yolo:
    """Checks of all images of a dataset; the names of classes are looked at once."""

    def __init__(self, classes: Mapping[str, Any] | None) -> None:
        self._classes, self._is_first = classes, True

    def check(self, seen: Seen) -> Faults:
        """Check one image."""
        if seen.format != NAME:
            return
        if self._is_first:
            self._is_first = False
            yield from self._names(seen)
            yield from _parts(seen)
        part, parts = f"{IMAGES}/{seen.extra['part']}", seen.extra["parts"]
        if seen.extra["names"] is not None and part not in parts.values():
            yield Fault(DESCRIPTION, seen.name, "no part has the folder of the picture", part, _text_of_parts(parts))
        if "unlabeled" in seen.extra:
            yield Fault(seen.extra["unlabeled"], seen.name, "has no file of labels")
        if not seen.picture:
            yield Fault(seen.labels, seen.name, "has no picture")
        if seen.extra["names"] is None and _task(seen) in (None, "pose"):
            return  # the number of keypoints is not known
        for file, lines in seen.lines:
            yield from _lines(seen, file, lines)

    def _names(self, seen: Seen) -> Faults:
        """data.yaml names the classes of the class table, in its order."""
        names = seen.extra["names"]
        if names is None:  # data.yaml cannot be read, which is a fault already
            return
        if sorted(names) != list(range(len(names))):
            yield Fault(DESCRIPTION, "all", "classes are numbered from 0 without gaps", "", str(sorted(names)))
        key = seen.truth.filter_of(BOXES) if seen.truth else "class:*"
        tables = (self._classes or {}).get("tables", ())
        rows = next((each["classes"] for each in tables if (each["filter"] or "") == key), None)
        if rows is not None and [names[number] for number in sorted(names)] != [row["name"] for row in rows]:
            expected, found = (", ".join(each) for each in ([row["name"] for row in rows], names.values()))
            yield Fault(DESCRIPTION, "all", f"names are those of {CLASSES}", expected, found)


def _parts(seen: Seen) -> Faults:
    """data.yaml has the folders of the parts, and of training and validation, which Ultralytics asks for."""
    parts = seen.extra["parts"]
    if seen.extra["names"] is None:
        return
    dealt = list((seen.truth.record.parameters.get("splits") if seen.truth else None) or {"train": 1})
    own = {name: f"{IMAGES}/{name}" for name in dealt}
    expected = own | {name: own[dealt[0]] for name in ("train", "val") if name not in own}
    if seen.truth is not None and any(parts.get(name) != each for name, each in expected.items()):
        yield Fault(DESCRIPTION, "all", "the folders of the parts", _text_of_parts(expected), _text_of_parts(parts))
    elif missing := [name for name in ("train", "val") if name not in parts]:
        yield Fault(DESCRIPTION, "all", f"has no {' and no '.join(missing)}", "", _text_of_parts(parts))


def _text_of_parts(parts: Mapping[str, str]) -> str:
    return ", ".join(f"{name}: {folder}" for name, folder in parts.items()) or "none"


def _task(seen: Seen) -> str | None:
    """Return the task of the writer; None where it is not recorded."""
    return seen.truth.record.parameters.get("task", "detect") if seen.truth else None


def _lines(seen: Seen, file: str, lines: list[list[str]]) -> Faults:
    names, count = seen.extra["names"], seen.extra["keypoints"]
    task = _task(seen)
    parsed = []
    for number, fields in enumerate(lines, 1):
        try:
            values = np.array(fields[1 : 1 + _BOX] if count else fields[1:], np.float64).reshape(-1, 2)
            points = np.array(fields[1 + _BOX :], np.float64).reshape(count, 3) if count else np.zeros((0, 3))
            kind = int(fields[0])
        except ValueError:
            what = f"a box and {counted(count, 'keypoint')}" if count else "pairs of numbers"
            yield Fault(file, seen.name, f"line {number} is not a class and {what}")
            continue
        if names is not None and kind not in names:
            yield Fault(file, seen.name, f"line {number} is of a class that {DESCRIPTION} does not name", "", fields[0])
        # An oriented box around pixels at the picture's edge reaches out of it; without a record it may be one.
        may_reach_out = task == "obb" or (task is None and len(values) == _CORNERS)
        if ((values < 0) | (values > 1)).any() and not may_reach_out:
            yield Fault(file, seen.name, f"line {number} has fractions of the picture", "0 to 1", text(values[:2]))
        yield from _keypoints(seen, file, number, points)
        parsed.append((None if names is None else names.get(kind, "?"), values, points))
    if seen.truth is not None:
        yield from _objects(seen, file, parsed, seen.truth, task == "obb")


def _keypoints(seen: Seen, file: str, number: int, points: np.ndarray) -> Faults:
    """Keypoints are in the picture, or 0 three times."""
    known = points[:, 2] > 0
    if not np.isin(points[:, 2], (0, 1, 2)).all():
        yield Fault(file, seen.name, f"visibility of keypoints of line {number}", "0, 1 or 2", text(points[:, 2]))
    elif points[~known].any() or ((points[known, :2] < 0) | (points[known, :2] > 1)).any():
        yield Fault(file, seen.name, f"keypoints of line {number} are in the picture, or 0", "", text(points[:, :2]))


def _places(
    seen: Seen,
    file: str,
    thing: Thing,
    points: np.ndarray,
    expected: Sequence[tuple[str, tuple[float, float, bool]]],
    truth: Truth,
) -> Faults:
    """Keypoints are where those of the stage project to; which is which the files do not tell, but for an option."""
    size, names = np.array(truth.product.size, float), truth.record.parameters.get("keypoints")
    known = [
        (name, np.array((x, y)), seen_there) for name, (x, y, seen_there) in expected if not names or name in names
    ]
    # At the edge of the picture rounding decides.
    at_edge = [np.minimum(abs(place), abs(place - size)).min() < _KEYPOINT for _, place, _ in known]
    left = [place for (_, place, is_inside), near in zip(known, at_edge) if is_inside or near]
    shown = list(points[points[:, 2] > 0, :2] * size)
    for place in shown:
        if not any(np.abs(each - place).max() <= _KEYPOINT for each in left):
            yield Fault(
                file, seen.name, f"a keypoint of {thing.path} is none of the object's [pixels]", "", text(place)
            )
    # Of several of one name, which are of parts of the object, a line has one.
    counts = Counter(name for name, _, _ in known)
    for (name, place, is_inside), near in zip(known, at_edge):
        is_shown = any(np.abs(each - place).max() <= _KEYPOINT for each in shown)
        if is_inside and not near and counts[name] == 1 and not is_shown:
            yield Fault(file, seen.name, f"{thing.path} lacks a keypoint that is in the picture", name)


def _objects(
    seen: Seen, file: str, parsed: list[tuple[str | None, np.ndarray, np.ndarray]], truth: Truth, is_oriented: bool
) -> Faults:
    """Every line is of a visible object; its class is compared where its name is known."""
    members = truth.members(truth.filter_of(BOXES))
    if members is None:
        return
    things = {
        index: each for index, each in enumerate(truth.things(truth.filter_of(BOXES))) if truth.is_visible_enough(each)
    }
    rectangles = {index: least_rectangles(members == index) for index in things} if is_oriented else {}
    ends = {
        index: _extent(fitted(rectangles[index][0], truth.product.size)) if is_oriented else _edges(each)
        for index, each in things.items()
    }
    size = np.array([truth.product.size, truth.product.size], float).ravel()

    def off(index: int, box: np.ndarray, name: str | None) -> float:
        # Of two with one box, that of the name.
        return float(np.abs(ends[index] / size - box).max()) + 1e-3 * (_name(things[index]) != name)

    keypoints: dict[str, list[tuple[str, tuple[float, float, bool]]]] = {}
    for owner, point, place in truth.keypoints_in_turn(truth.filter_of(KEYPOINTS)) if seen.extra["keypoints"] else ():
        keypoints.setdefault(owner, []).append((point, place))
    for name, values, points in parsed:
        box = _box(values)
        if not things:
            yield Fault(
                file, seen.name, f"a line of {name or 'an object'} is of nothing that is visible", "", text(box * size)
            )
            continue
        index = min(things, key=partial(off, box=box, name=name))
        thing = things.pop(index)
        if name is not None and name != _name(thing):
            yield Fault(file, seen.name, f"the class of {thing.path}", _name(thing), name)
        if len(points):
            yield from _places(seen, file, thing, points, keypoints.get(thing.path, []), truth)
        if is_oriented:
            corners, mask = values * truth.product.size, members == index
            faults = [list(oriented(seen, file, thing, corners, mask, least)) for least in rectangles[index]]
            yield from min(faults, key=len)
        elif differs(box, ends[index] / size, relative=0.0, absolute=_DIGITS):
            yield Fault(file, seen.name, f"the box of {thing.path} [pixels]", text(ends[index]), text(box * size))
        elif values.size > _BOX:
            yield from _outline(seen, file, thing, values * truth.product.size, members == index)
    for thing in things.values():
        yield Fault(file, seen.name, f"{thing.path} is visible and has no line", _name(thing))


def _name(thing: Thing) -> str:
    return ",".join(label for _, label in sorted(thing.labels.items()))


def _edges(thing: Thing) -> np.ndarray:
    """Return left, top, right and bottom edge of a thing's visible pixels."""
    left, top, right, bottom = thing.box or (0, 0, -1, -1)
    return np.array([left, top, right + 1, bottom + 1], float)


def _box(values: np.ndarray) -> np.ndarray:
    """Return left, top, right and bottom of a line's box or outline."""
    if values.size == _BOX:
        return np.concatenate([values[0] - values[1] / 2, values[0] + values[1] / 2])
    return _extent(values)


def _extent(points: np.ndarray) -> np.ndarray:
    return np.concatenate([points.min(axis=0), points.max(axis=0)])


def oriented(seen: Seen, file: str, thing: Thing, corners: np.ndarray, mask: np.ndarray, least: np.ndarray) -> Faults:
    """An oriented box is a rectangle around the pixels of its object, and no smaller one exists.

    One that is larger than the picture has its corners in it.
    """
    inside = fitted(least, (mask.shape[1], mask.shape[0]))
    if inside is not least:
        if np.abs(_extent(corners) - _extent(inside)).max() > _NEAR or _area(corners) < _area(inside) * (1 - _NEAR):
            yield Fault(file, seen.name, f"the oriented box of {thing.path} [pixels]", text(inside), text(corners))
        return
    what, sides = f"the oriented box of {thing.path}", np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(sides, axis=1)
    turns = np.abs((sides * np.roll(sides, -1, axis=0)).sum(axis=1))
    if (
        len(corners) != _CORNERS
        or np.abs(lengths[:2] - lengths[2:]).max() > _NEAR
        or (turns > _NEAR * lengths.max()).any()
    ):
        yield Fault(file, seen.name, f"{what} is a rectangle", "", text(corners))
        return
    if (mask & ~filled(corners, mask.shape)).any():
        yield Fault(file, seen.name, f"{what} holds its pixels", "", text(corners))
    area, smallest = (
        lengths[0] * lengths[1],
        float(np.linalg.norm(least[1] - least[0]) * np.linalg.norm(least[2] - least[1])),
    )
    if abs(area - smallest) > _NEAR * (lengths[0] + lengths[1]):
        yield Fault(file, seen.name, f"the area of {what} [pixels]", f"{smallest:.2f}", f"{area:.2f}")


def _area(corners: np.ndarray) -> float:
    """Return the area of a polygon (N, 2)."""
    (x, y), (next_x, next_y) = corners.T, np.roll(corners, -1, axis=0).T
    return abs(float((x * next_y - next_x * y).sum())) / 2


def _outline(seen: Seen, file: str, thing: Thing, corners: np.ndarray, mask: np.ndarray) -> Faults:
    """An outline holds the pixels of its object and those in its holes, and no others."""
    wrong = filled(corners, mask.shape) != without_holes(mask)
    if wrong.any():
        yield Fault(file, seen.name, f"the outline of {thing.path} is that of its mask, but {of_pixels(wrong)}")
