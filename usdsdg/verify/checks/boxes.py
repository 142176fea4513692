"""2D and 3D boxes, and occlusion: of the right things, with the right corners and ratios, and in agreement."""

from __future__ import annotations

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Boxes, Ids, Occlusions, Seen
from usdsdg.datasets.truth import Thing, Truth, extents
from usdsdg.verify.checks.compare import differs, pairs, text

_CORNERS = ("x_min", "y_min", "x_max", "y_max")
_SOLID = ("x_min", "y_min", "z_min", "x_max", "y_max", "z_max")
_RATIO = 1e-6
_UNLABELED = 1  # id of all that has no label


def check(seen: Seen) -> Faults:
    """Compare boxes with the record, with the images of ids, and with each other."""
    for boxes in seen.boxes:
        if seen.truth is not None:
            yield from _recorded(seen, boxes)
        if boxes.kind == "tight":
            for ids in seen.ids:
                yield from _of_masks(seen, boxes, ids)
    for occlusions in seen.occlusions:
        if seen.truth is not None:
            yield from _occlusions(seen, occlusions)
    yield from _agree(seen)


def _is_listed(thing: Thing, kind: str, truth: Truth) -> bool:
    return truth.is_visible_enough(thing) if kind == "tight" else bool(thing.amodal)


def _recorded(seen: Seen, boxes: Boxes) -> Faults:
    assert seen.truth is not None
    things = seen.truth.things(boxes.filter)
    if boxes.kind != "tight" and any(each.amodal is None for each in things):
        return
    things = [each for each in things if _is_listed(each, boxes.kind, seen.truth)]
    if boxes.paths is not None and len(boxes.paths) != len(boxes.rows):
        yield Fault(
            boxes.file, seen.name, "boxes and prim paths differ in number", str(len(boxes.rows)), str(len(boxes.paths))
        )
        return
    names = boxes.paths if boxes.paths is not None else boxes.labels
    expected = [each.path if boxes.paths is not None else each.label for each in things]
    matched, faults = pairs(seen, boxes.file, names, expected, "the box of")
    yield from faults
    for mine, theirs in matched:
        yield from _row(seen, boxes, mine, things[theirs])


def _row(seen: Seen, boxes: Boxes, index: int, thing: Thing) -> Faults:
    row, name = boxes.rows[index], thing.path
    if boxes.labels[index] != thing.label:
        yield Fault(boxes.file, seen.name, f"the label of {name}", thing.label, boxes.labels[index])
    if thing.occlusion is not None and differs(row["occlusionRatio"], thing.occlusion, relative=0.0, absolute=_RATIO):
        yield Fault(
            boxes.file,
            seen.name,
            f"occlusionRatio of {name}",
            f"{thing.occlusion:.4f}",
            f"{float(row['occlusionRatio']):.4f}",
        )
    if boxes.kind == "3d":
        corners = np.array([row[side] for side in _SOLID])
        if differs(corners, thing.bounds.ravel(), relative=1e-6, absolute=1e-9):
            yield Fault(boxes.file, seen.name, f"the 3D box of {name}", text(thing.bounds), text(corners))
        if differs(row["transform"], thing.local_to_world, relative=1e-6, absolute=1e-9):
            yield Fault(
                boxes.file, seen.name, f"the transform of {name}", text(thing.local_to_world), text(row["transform"])
            )
        return
    corners = tuple(int(row[side]) for side in _CORNERS)
    expected = thing.box if boxes.kind == "tight" else thing.amodal_box
    if corners != expected:
        yield Fault(boxes.file, seen.name, f"the {boxes.kind} box of {name}", str(expected), str(corners))


def _of_masks(seen: Seen, boxes: Boxes, ids: Ids) -> Faults:
    """A tight box is the extent of its mask, for files that tell the prim path of both."""
    if (
        ids.kind != "instance"
        or ids.meanings is None
        or ids.chosen
        or boxes.paths is None
        or ids.filter != boxes.filter
    ):
        return
    if len(boxes.paths) != len(boxes.rows):
        return
    present, inverse = np.unique(ids.keys, return_inverse=True)
    found = extents(inverse.reshape(ids.keys.shape), len(present))
    by_path = {ids.meanings.get(int(key), ""): tuple(box) for key, box in zip(present, found.tolist())}
    repeated = {path for path in boxes.paths if boxes.paths.count(path) > 1}
    for path, row in zip(boxes.paths, boxes.rows):
        corners = tuple(int(row[side]) for side in _CORNERS)
        if path not in by_path:
            yield Fault(boxes.file, seen.name, f"{path} has a box, but no pixel in {ids.file}")
        elif by_path[path] != corners and path not in repeated:
            yield Fault(
                boxes.file,
                seen.name,
                f"the box of {path} is not the extent of its mask in {ids.file}",
                str(by_path[path]),
                str(corners),
            )


def _occlusions(seen: Seen, occlusions: Occlusions) -> Faults:
    assert seen.truth is not None
    things = {each.id: each for each in seen.truth.things(occlusions.filter) if each.amodal}
    if any(each.amodal is None for each in seen.truth.things(occlusions.filter)):
        return
    yield from _ids_of_rows(seen, occlusions, {thing.id: thing for thing in seen.truth.things(occlusions.filter)})
    # What is out of view, or not measured, has no ratio.
    rows = occlusions.rows[~np.isnan(occlusions.rows["occlusionRatio"])]
    names = [str(int(row["instanceId"])) for row in rows]
    matched, faults = pairs(seen, occlusions.file, names, list(map(str, things)), "the ratio of id")
    yield from faults
    listed = list(things.values())
    for mine, theirs in matched:
        row, thing = rows[mine], listed[theirs]
        if differs(row["occlusionRatio"], thing.occlusion, relative=0.0, absolute=_RATIO):
            expected, found = f"{thing.occlusion:.4f}", f"{float(row['occlusionRatio']):.4f}"
            yield Fault(occlusions.file, seen.name, f"occlusionRatio of {thing.path}", expected, found)


def _ids_of_rows(seen: Seen, occlusions: Occlusions, things: dict[int, Thing]) -> Faults:
    """Every row has the ids of an object, once; what has no label has one row, with its own for both."""
    known: set[int] = set()
    for row in occlusions.rows:
        instance, semantic = int(row["instanceId"]), int(row["semanticId"])
        thing = things.get(instance)
        if instance in known:
            yield Fault(occlusions.file, seen.name, f"several rows have the instanceId {instance}")
        known.add(instance)
        if thing is not None and semantic != thing.class_id:
            what = f"semanticId of {thing.path}"
            yield Fault(occlusions.file, seen.name, what, str(thing.class_id), str(semantic))
        elif (instance == _UNLABELED) != (semantic == _UNLABELED) or not (instance and semantic):
            what = "both ids of a row are of an object, or both of what has no label"
            yield Fault(occlusions.file, seen.name, what, "", f"instanceId {instance}, semanticId {semantic}")


def _agree(seen: Seen) -> Faults:
    """Boxes of one prim in several files: a loose box contains the tight one, and all have the same occlusion."""
    first: dict[tuple[str, str], tuple[str, float]] = {}
    tight: dict[tuple[str, str], tuple[int, ...]] = {}
    kinds = sorted(seen.boxes, key=lambda each: each.kind != "tight")
    for boxes in kinds:
        paths = boxes.paths or []
        for path, row in zip(paths, boxes.rows):
            if paths.count(path) > 1:
                continue
            key, ratio = (path, boxes.filter), float(row["occlusionRatio"])
            if not (np.isnan(ratio) or 0.0 <= ratio <= 1.0):
                yield Fault(boxes.file, seen.name, f"occlusionRatio of {path} is no fraction", "0 to 1", f"{ratio:g}")
            file, before = first.setdefault(key, (boxes.file, ratio))
            if differs(ratio, before, relative=0.0, absolute=_RATIO):
                yield Fault(
                    boxes.file,
                    seen.name,
                    f"occlusionRatio of {path} differs from that in {file}",
                    f"{before:.4f}",
                    f"{ratio:.4f}",
                )
            if boxes.kind == "3d":
                continue
            corners = tuple(int(row[side]) for side in _CORNERS)
            if corners[0] > corners[2] or corners[1] > corners[3]:
                yield Fault(boxes.file, seen.name, f"the box of {path} ends before it begins", "", str(corners))
            if boxes.kind == "tight":
                tight[key] = corners
            elif key in tight and not _contains(corners, tight[key]):
                yield Fault(
                    boxes.file,
                    seen.name,
                    f"the loose box of {path} does not contain the tight one",
                    str(tight[key]),
                    str(corners),
                )


def _contains(outer: tuple[int, ...], inner: tuple[int, ...]) -> bool:
    return outer[0] <= inner[0] and outer[1] <= inner[1] and outer[2] >= inner[2] and outer[3] >= inner[3]
