"""YOLO: a line for each visible object, with the number of its class, its box or its outline, and all classes named."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.formats.yolo import NAME
from usdsdg.datasets.polygons import filled
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.truth import Thing, Truth
from usdsdg.record import CLASSES
from usdsdg.verify.checks.compare import differs, of_pixels, text

BOXES, DESCRIPTION = "bounding_box_2d_tight_fast", "data.yaml"
_DIGITS = 2e-6  # of fractions of the picture
_BOX = 4  # numbers of a box; an outline has more


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
        if "unlabeled" in seen.extra:
            yield Fault(seen.extra["unlabeled"], seen.name, "has no file of labels")
        for file, lines in seen.lines:
            yield from _lines(seen, file, lines)

    def _names(self, seen: Seen) -> Faults:
        """data.yaml names the classes of the class table, in its order."""
        names = seen.extra["names"]
        if sorted(names) != list(range(len(names))):
            yield Fault(DESCRIPTION, "all", "classes are numbered from 0 without gaps", "", str(sorted(names)))
        key = seen.truth.filter_of(BOXES) if seen.truth else "class:*"
        tables = (self._classes or {}).get("tables", ())
        rows = next((each["classes"] for each in tables if (each["filter"] or "") == key), None)
        if rows is not None and [names[number] for number in sorted(names)] != [row["name"] for row in rows]:
            expected, found = (", ".join(each) for each in ([row["name"] for row in rows], names.values()))
            yield Fault(DESCRIPTION, "all", f"names are those of {CLASSES}", expected, found)


def _lines(seen: Seen, file: str, lines: list[list[str]]) -> Faults:
    names, parsed = seen.extra["names"], []
    for number, fields in enumerate(lines, 1):
        try:
            values = np.array(fields[1:], np.float64).reshape(-1, 2)
            kind = int(fields[0])
        except ValueError:
            yield Fault(file, seen.name, f"line {number} is not a class and pairs of numbers")
            continue
        if kind not in names:
            yield Fault(file, seen.name, f"line {number} is of a class that {DESCRIPTION} does not name", "", fields[0])
        if ((values < 0) | (values > 1)).any():
            yield Fault(file, seen.name, f"line {number} has fractions of the picture", "0 to 1", text(values[:2]))
        parsed.append((names.get(kind, "?"), values))
    if seen.truth is not None:
        yield from _objects(seen, file, parsed, seen.truth)


def _objects(seen: Seen, file: str, parsed: list[tuple[str, np.ndarray]], truth: Truth) -> Faults:
    members = truth.members(truth.filter_of(BOXES))
    if members is None:
        return
    things = {index: each for index, each in enumerate(truth.things(truth.filter_of(BOXES))) if _is_listed(each, truth)}
    size = np.array([truth.product.size, truth.product.size], float).ravel()

    def off(index: int, box: np.ndarray, name: str) -> float:
        # Of two with one box, that of the name.
        return float(np.abs(_edges(things[index]) / size - box).max()) + 1e-3 * (_name(things[index]) != name)

    for name, values in parsed:
        box = _box(values)
        if not things:
            yield Fault(file, seen.name, f"a line of {name} is of nothing that is visible", "", text(box * size))
            continue
        index = min(things, key=partial(off, box=box, name=name))
        thing = things.pop(index)
        if name != _name(thing):
            yield Fault(file, seen.name, f"the class of {thing.path}", _name(thing), name)
        if differs(box, _edges(thing) / size, relative=0.0, absolute=_DIGITS):
            yield Fault(file, seen.name, f"the box of {thing.path} [pixels]", text(_edges(thing)), text(box * size))
        elif values.size > _BOX:
            yield from _outline(seen, file, thing, values * truth.product.size, members == index)
    for thing in things.values():
        yield Fault(file, seen.name, f"{thing.path} is visible and has no line", _name(thing))


def _is_listed(thing: Thing, truth: Truth) -> bool:
    fewest, least = (
        truth.record.parameters.get(f"min_{name}", own) for name, own in (("pixels", 1), ("visibility", 0))
    )
    return thing.visible >= max(fewest, 1) and (thing.occlusion is None or 1.0 - thing.occlusion >= least)


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
    return np.concatenate([values.min(axis=0), values.max(axis=0)])


def _outline(seen: Seen, file: str, thing: Thing, corners: np.ndarray, mask: np.ndarray) -> Faults:
    """An outline holds the pixels of its object, and no others but those in its holes."""
    from scipy import ndimage

    inside = filled(corners, mask.shape)
    holes = ndimage.binary_fill_holes(mask) & ~mask
    wrong = (inside != mask) & ~holes
    if wrong.any():
        yield Fault(file, seen.name, f"the outline of {thing.path} is that of its mask, but {of_pixels(wrong)}")
