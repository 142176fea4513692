"""COCO's panoptic form: segments are those of the picture, of the record, and of the other JSON."""

from __future__ import annotations

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Masks, Seen, Segments
from usdsdg.datasets.truth import Truth
from usdsdg.verify.checks.compare import of_pixels
from usdsdg.verify.checks.formats.coco import category_of, is_listed


def check(seen: Seen) -> Faults:
    """Check the segments of an image."""
    for segments in seen.segments:
        if segments.ids.shape[::-1] != seen.size:
            yield Fault(segments.picture, seen.name, "has another size", str(seen.size), str(segments.ids.shape[::-1]))
            continue
        yield from _picture(seen, segments)
        for masks in seen.masks:
            yield from _annotations(seen, segments, masks)
            if seen.truth is None:
                yield from _segments(seen, segments, masks)
            else:
                yield from _things(seen, segments, masks, seen.truth)


def _picture(seen: Seen, segments: Segments) -> Faults:
    """The picture has the listed ids, and their boxes and areas are right."""
    listed = [int(each["id"]) for each in segments.records]
    present = np.setdiff1d(np.unique(segments.ids), [0]).tolist()
    if sorted(listed) != present:
        yield Fault(segments.file, seen.name, "segments are those of the picture", str(present), str(sorted(listed)))
    for each in segments.records:
        name, (rows, columns) = f"segment {each['id']}", np.nonzero(segments.ids == each["id"])
        if each["category_id"] not in segments.categories:
            what = f"{name} is of category {each['category_id']}, which is not listed"
            yield Fault(segments.file, seen.name, what)
        allowed = (0, 1) if seen.truth is None else (0,)  # CocoWriter has no crowds
        if each["iscrowd"] not in allowed:
            expected = " or ".join(map(str, allowed))
            yield Fault(segments.file, seen.name, f"iscrowd of {name}", expected, str(each["iscrowd"]))
        if not len(rows):
            continue
        box = [int(columns.min()), int(rows.min()), int(np.ptp(columns)) + 1, int(np.ptp(rows)) + 1]
        if list(each["bbox"]) != box:
            yield Fault(segments.file, seen.name, f"the box of {name}", str(box), str(each["bbox"]))
        if each["area"] != len(rows):
            yield Fault(segments.file, seen.name, f"the area of {name}", str(len(rows)), str(each["area"]))


def _annotations(seen: Seen, segments: Segments, masks: Masks) -> Faults:
    """Every annotation with an exact mask is a segment of its category, or a part of one of stuff."""
    categories = {int(each["id"]): int(each["category_id"]) for each in segments.records}
    for each in masks.masks:
        if each.mask is None or each.mask.shape != segments.ids.shape or not each.has_holes or not each.mask.any():
            continue
        ids = np.unique(segments.ids[each.mask]).tolist()
        found = sorted({categories.get(number, 0) for number in ids})
        if len(ids) != 1 or found != [each.category]:
            what = f"annotation {each.number} of {masks.file} is one segment of its category"
            yield Fault(segments.picture, seen.name, what, str(each.category), f"{found} in segments {ids}")


def _segments(seen: Seen, segments: Segments, masks: Masks) -> Faults:
    """Without a record: every segment of a thing has an annotation of its category, whose mask has pixels of it."""
    for each in segments.records:
        number, category = each["id"], int(each["category_id"])
        mine = segments.ids == number
        if each["iscrowd"] or not mine.any() or not segments.categories.get(category, {}).get("isthing", 1):
            continue
        shown = (one.mask for one in masks.masks if one.category == category)
        if not any(mask is not None and mask.shape == mine.shape and (mask & mine).any() for mask in shown):
            yield Fault(masks.file, seen.name, f"segment {number} of {segments.file} has no annotation")


def _things(seen: Seen, segments: Segments, masks: Masks, truth: Truth) -> Faults:
    """Each thing is a segment of its own, and each category of stuff one."""
    members = truth.members(masks.filter)
    if members is None or members.shape != segments.ids.shape:
        return
    is_thing = {int(number): bool(each.get("isthing", 1)) for number, each in segments.categories.items()}
    expected = np.zeros(members.shape, np.int64)
    names = ["no segment"]
    numbers: dict[int, int] = {}  # of categories of stuff
    for index, thing in enumerate(truth.things(masks.filter)):
        category = category_of(thing, masks)
        if category is None or not is_listed(thing, masks, truth):
            continue
        is_own = is_thing.get(category, True)
        number = len(names) if is_own else numbers.setdefault(category, len(names))
        names += [thing.path if is_own else f"category {category}"] if number == len(names) else []
        expected[members == index] = number
        kinds = {
            each["category_id"] for each in segments.records if (segments.ids[members == index] == each["id"]).any()
        }
        if kinds - {category}:
            what = f"the category of {thing.path}, {thing.label}"
            yield Fault(segments.file, seen.name, what, str(category), str(sorted(kinds)))
    for number, name in enumerate(names):
        mine = expected == number
        found = np.unique(segments.ids[mine])
        if not number and found.any():
            yield Fault(segments.picture, seen.name, f"{of_pixels(mine & (segments.ids > 0))} are of no object")
        elif number and (len(found) > 1 or not found.all()):
            yield Fault(segments.picture, seen.name, f"{name} is one segment", "1", str(found.tolist()))
        elif number and (segments.ids[~mine] == found[0]).any():
            what = f"the segment of {name} has others' pixels, {of_pixels(~mine & (segments.ids == found[0]))}"
            yield Fault(segments.picture, seen.name, what)
