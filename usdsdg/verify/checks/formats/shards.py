"""WebDataset and Parquet: objects with the numbers of their classes, areas and ids as in the image of ids."""

from __future__ import annotations

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.formats.sharded import Stored
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.truth import Truth
from usdsdg.verify.checks.compare import of_pixels
from usdsdg.writers.formats.shapes.masks import extent
from usdsdg.writers.formats.shards.samples import BOXES
from usdsdg.writers.formats.shards.shard_files import PARQUET, WEBDATASET


def check(seen: Seen) -> Faults:
    """Check the objects of a sample."""
    if seen.format not in (PARQUET, WEBDATASET):
        return
    stored: Stored = seen.extra["sample"]
    for color in seen.colors:
        if (color.image.shape[1], color.image.shape[0]) != seen.size:
            yield Fault(color.file, seen.name, "width and height", str(seen.size), str(color.image.shape[1::-1]))
    ids = [int(each["id"]) for each in stored.objects]
    if ids != list(range(1, len(ids) + 1)):
        yield Fault(stored.file, seen.name, "ids of objects count from 1", "", str(ids[:8]))
    for each in stored.objects:
        yield from _class(seen, stored, int(each["category"]), str(each["label"]))
    if stored.instances is not None:
        yield from _masks(seen, stored, stored.instances)
    if seen.truth is not None:
        yield from _recorded(seen, stored, seen.truth)


def _class(seen: Seen, stored: Stored, category: int, label: str) -> Faults:
    named = stored.classes[category] if 0 <= category < len(stored.classes) else "none"
    if named != label:
        yield Fault(stored.file, seen.name, f"category {category} of an object {label!r}", label, named)


def _masks(seen: Seen, stored: Stored, ids: np.ndarray) -> Faults:
    """An object's pixels in the image of ids have its box and its area."""
    present = {int(each["id"]) for each in stored.objects} | {0}
    unknown = sorted(set(np.unique(ids).tolist()) - present)
    if unknown:
        yield Fault(stored.file, seen.name, "the image of ids has ids of no object", "", str(unknown[:8]))
    for each in stored.objects:
        mask = ids == int(each["id"])
        ends, name = extent(mask), f"object {each['id']}, {each['path']}"
        box = None if ends is None else [*map(float, ends[:2]), ends[2] - ends[0] + 1.0, ends[3] - ends[1] + 1.0]
        if box != list(each["bbox"]):
            yield Fault(stored.file, seen.name, f"bbox of {name} is its mask's extent", str(box), str(each["bbox"]))
        if int(each["area"]) != int(mask.sum()):
            yield Fault(stored.file, seen.name, f"area of {name}", str(int(mask.sum())), str(each["area"]))


def _recorded(seen: Seen, stored: Stored, truth: Truth) -> Faults:
    """Areas and masks are those of the record; boxes, labels and visibility are checked with those of all formats."""
    key = truth.filter_of(BOXES)
    members = truth.members(key)
    if members is None:
        return
    places = {each.path: (index, each) for index, each in enumerate(truth.things(key))}
    for each in stored.objects:
        if each["path"] not in places:
            continue
        index, thing = places[each["path"]]
        if int(each["area"]) != thing.visible:
            yield Fault(stored.file, seen.name, f"area of {thing.path}", str(thing.visible), str(each["area"]))
        if stored.instances is None or stored.instances.shape != members.shape:
            continue
        wrong = (stored.instances == int(each["id"])) != (members == index)
        if wrong.any():
            yield Fault(stored.file, seen.name, f"the mask of {thing.path} differs in {of_pixels(wrong)}")
