"""Keypoints of COCO: as many as the category names, flags that agree with them, and where the stage has them."""

from __future__ import annotations

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Mask, Masks, Seen
from usdsdg.verify.checks.compare import differs, text
from usdsdg.verify.checks.formats.coco import index_of

_PIXELS = 0.02  # positions of the record are float32
_FLAGS = (0, 1, 2)  # outside of the picture, hidden, visible


def check(seen: Seen) -> Faults:
    """Check the keypoints of every annotation."""
    for masks in seen.masks:
        expected = _expected(seen, masks)
        for each in masks.masks:
            names = masks.categories.get(each.category, {}).get("keypoints")
            if (names is None) != (each.keypoints is None):
                what = f"annotation {each.number} has keypoints, and category {each.category} names them"
                yield Fault(masks.file, seen.name, what, str(names), "none" if each.keypoints is None else "some")
            elif names is not None and each.keypoints is not None:
                yield from _numbers(seen, masks, each, names, expected.get(each.number))


def _numbers(
    seen: Seen, masks: Masks, each: Mask, names: list[str], expected: dict[str, tuple[float, float, bool]] | None
) -> Faults:
    assert each.keypoints is not None
    assert seen.size is not None
    flat, count = each.keypoints
    what = f"of annotation {each.number}"
    if len(flat) != 3 * len(names):
        yield Fault(masks.file, seen.name, f"numbers of keypoints {what}", str(3 * len(names)), str(len(flat)))
        return
    rows = np.array(flat).reshape(-1, 3)
    inside = int((rows[:, 2] > 0).sum())
    if count != inside:
        yield Fault(masks.file, seen.name, f"num_keypoints {what}", str(inside), str(count))
    for name, (x, y, flag) in zip(names, rows.tolist()):
        point = f"the keypoint {name} {what}"
        if flag not in _FLAGS:
            yield Fault(masks.file, seen.name, f"{point} has a flag", "0, 1 or 2", f"{flag:g}")
        elif flag == 0 and (x or y):
            yield Fault(masks.file, seen.name, f"{point} is not in the picture", "0, 0", f"{x:g}, {y:g}")
        elif flag and not (0 <= x <= seen.size[0] and 0 <= y <= seen.size[1]):
            yield Fault(masks.file, seen.name, f"{point} is in the picture", str(seen.size), f"{x:g}, {y:g}")
        elif expected is not None:
            yield from _place(seen, masks, point, (x, y, flag), expected.get(name))


def _place(
    seen: Seen,
    masks: Masks,
    point: str,
    found: tuple[float, float, float],
    expected: tuple[float, float, bool] | None,
) -> Faults:
    """A keypoint is where that of the stage is projected to."""
    if expected is None:
        if found[2]:
            yield Fault(masks.file, seen.name, f"{point} is none of the object's", "0", f"{found[2]:g}")
        return
    assert seen.size is not None
    place, is_inside = np.array(expected[:2]), expected[2]
    if bool(found[2]) != is_inside:
        # At the edge of the picture rounding decides.
        near = np.minimum(np.abs(place), np.abs(place - seen.size)).min() < _PIXELS
        if not near:
            yield Fault(masks.file, seen.name, f"{point} is in the picture", str(is_inside), f"{found[2]:g}")
    elif is_inside and differs(found[:2], place, relative=0.0, absolute=_PIXELS):
        yield Fault(masks.file, seen.name, f"{point} [pixels]", text(place), text(found[:2]))


def _expected(seen: Seen, masks: Masks) -> dict[int, dict[str, tuple[float, float, bool]]]:
    """Return the keypoints that the record has for each annotation; none where no keypoints are recorded."""
    truth = seen.truth
    members = truth.members(masks.filter) if truth else None
    if truth is None or members is None or "keypoints" not in truth.record.annotators:
        return {}
    things, points = truth.things(masks.filter), truth.keypoints(masks.filter)
    found = {}
    for each in masks.masks:
        if each.mask is not None and each.mask.shape == members.shape and each.mask.any():
            index = index_of(each, members)
            if index >= 0:
                found[each.number] = points.get(things[index].path, {})
    return found
