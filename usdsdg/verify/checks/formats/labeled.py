"""Names, boxes, masks and flags of objects, for formats that have these: Pascal VOC and CVAT."""

from __future__ import annotations

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Labeled, Seen
from usdsdg.datasets.truth import Thing, Truth
from usdsdg.verify.checks.compare import of_pixels, text
from usdsdg.verify.checks.poses import truncation
from usdsdg.writers.formats.class_names import class_name
from usdsdg.writers.formats.cvat import files as cvat
from usdsdg.writers.formats.shapes.polygons import without_holes
from usdsdg.writers.formats.voc import files as voc

BOXES = "bounding_box_2d_tight_fast"
_UNFIT = {voc.NAME: voc.UNFIT, cvat.NAME: cvat.UNFIT}  # what their names of classes cannot have
_RATIO = 1e-4  # of fractions that decide a flag


def check(seen: Seen) -> Faults:
    """Check the labeled objects of an image."""
    if not seen.labeled and seen.format not in _UNFIT:
        return
    for color in seen.colors:
        size = (color.image.shape[1], color.image.shape[0])
        if size != seen.size:
            yield Fault(seen.labels, seen.name, f"width and height of {color.file}", str(size), str(seen.size))
    for each in seen.labeled:
        yield from _alone(seen, each)
    if seen.truth is not None:
        yield from _things(seen, seen.truth)


def _alone(seen: Seen, each: Labeled) -> Faults:
    """The box is in the picture, and the extent of the mask."""
    assert seen.size is not None
    left, top, right, bottom = each.box
    if not (0 <= left < right <= seen.size[0] and 0 <= top < bottom <= seen.size[1]):
        yield Fault(seen.labels, seen.name, f"the box of {each.name} is in the picture", str(seen.size), text(each.box))
    if each.mask is None:
        return
    rows, columns = np.nonzero(each.mask)
    if not len(rows):
        yield Fault(seen.labels, seen.name, f"the mask of {each.name} in {text(each.box)} has no pixel")
        return
    extent = (columns.min(), rows.min(), columns.max() + 1, rows.max() + 1)
    if tuple(map(float, extent)) != each.box:
        what = f"the box of {each.name} is the extent of its mask"
        yield Fault(seen.labels, seen.name, what, text(extent), text(each.box))


def _things(seen: Seen, truth: Truth) -> Faults:
    """Every visible object is there once, with its name, box, mask and flags."""
    key = truth.filter_of(BOXES)
    members = truth.members(key)
    if members is None:
        return
    things = truth.things(key)
    left = {index: each for index, each in enumerate(things) if each.visible and _is_listed(seen, each, truth)}
    for each in seen.labeled:
        index = _index(seen, each, left, members)
        if index is None:
            yield Fault(seen.labels, seen.name, f"a {each.name} is of nothing that is visible", "", text(each.box))
            continue
        yield from _one(seen, each, left.pop(index), members == index, truth)
    for thing in left.values():
        yield Fault(seen.labels, seen.name, f"{thing.path} is visible and not annotated", _name(seen, thing))


def _is_listed(seen: Seen, thing: Thing, truth: Truth) -> bool:
    # What is hardly visible is difficult in VOC, and left out elsewhere.
    return seen.format == voc.NAME or truth.is_visible_enough(thing)


def _index(seen: Seen, each: Labeled, left: dict[int, Thing], members: np.ndarray) -> int | None:
    """Return which thing an object is: that with its mask, else that with its box, preferably of its name."""
    if each.mask is not None and each.mask.shape == members.shape:
        counts = {index: int((each.mask & (members == index)).sum()) for index in left}
        own = {index: count for index, count in counts.items() if count}
        exact = [index for index in own if (without_holes(members == index) == without_holes(each.mask)).all()]
        return exact[0] if exact else max(own, key=lambda index: own[index]) if own else None

    def off(index: int) -> float:
        return float(np.abs(np.subtract(_edges(left[index]), each.box)).max()) + 0.5 * (
            _name(seen, left[index]) != each.name
        )

    return min(left, key=off) if left else None


def _one(seen: Seen, each: Labeled, thing: Thing, pixels: np.ndarray, truth: Truth) -> Faults:
    if each.name != _name(seen, thing):
        yield Fault(seen.labels, seen.name, f"the name of {thing.path}", _name(seen, thing), each.name)
    if _edges(thing) != each.box:
        yield Fault(seen.labels, seen.name, f"the box of {thing.path}", text(_edges(thing)), text(each.box))
    if each.mask is not None:
        wrong = each.mask != (pixels if each.has_holes else without_holes(pixels))
        if wrong.any():
            yield Fault(seen.labels, seen.name, f"the mask of {thing.path} differs in {of_pixels(wrong)}")
    if each.instance is not None and each.instance != thing.id:
        yield Fault(seen.labels, seen.name, f"the instance of {thing.path}", str(thing.id), str(each.instance))
    outside = truncation(thing, truth.camera) if truth.camera else None
    parameters = truth.record.parameters
    for name, ratio, own in (("occluded", thing.occlusion, 0.05), ("truncated", outside, 0.15)):
        limit = float(parameters.get(f"{name}_threshold", own))
        if (
            name in each.flags
            and ratio is not None
            and abs(ratio - limit) > _RATIO
            and each.flags[name] != (ratio > limit)
        ):
            yield Fault(seen.labels, seen.name, f"{name} of {thing.path}", f"{ratio:.4f}", str(each.flags[name]))
    if "difficult" in each.flags and each.flags["difficult"] == truth.is_visible_enough(thing):
        expected = str(not truth.is_visible_enough(thing))
        yield Fault(seen.labels, seen.name, f"difficult of {thing.path}", expected, str(each.flags["difficult"]))


def _name(seen: Seen, thing: Thing) -> str:
    return class_name(thing.labels, _UNFIT[seen.format])


def _edges(thing: Thing) -> tuple[float, float, float, float]:
    left, top, right, bottom = thing.box or (0, 0, -1, -1)
    return float(left), float(top), right + 1.0, bottom + 1.0
