"""What the readers of WebDataset and Parquet share: a sample to what its shard says about one image."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import Image

from usdsdg.datasets.attempt import UNREADABLE, attempt
from usdsdg.datasets.faults import Fault
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.matching import classes_of
from usdsdg.datasets.seen import Boxes, Color, Depth, Seen
from usdsdg.datasets.seen_object import SeenObject
from usdsdg.datasets.truth import Thing, Truth
from usdsdg.writers.formats.shards.samples import BOXES
from usdsdg.writers.formats.shards.shard_files import DEPTH, IMAGE, INSTANCES

_OPTIONS = {INSTANCES: "masks", DEPTH: "depth"}  # of the writers, by the image that they ask for
ROW = np.dtype([(name, "<i4") for name in ("x_min", "y_min", "x_max", "y_max")] + [("occlusionRatio", "<f4")])


@dataclass(frozen=True)
class Stored:
    """The sample of one image, and the names of all classes."""

    file: str
    facts: Mapping[str, Any]
    objects: Sequence[Mapping[str, Any]]
    classes: Sequence[str]
    instances: np.ndarray | None = None  # (H, W) ids of objects


def seen_of(
    folder: Folder,
    name: str,
    file: str,
    facts: Mapping[str, Any],
    objects: Sequence[Mapping[str, Any]],
    classes: Sequence[str],
    load: Callable[[str], tuple[str, bytes] | None],
    *,
    classes_file: str,
) -> Seen:
    """Return what a sample of a shard says.

    name: of the writer. classes_file: which names the classes. load: returns name and bytes of the member that is the
        image, the ids or the depth.
    """
    frame, view = int(facts["frame"]), str(facts["view"])
    seen = Seen(name, str(facts["key"]), "", [file], _truth(folder, name, frame, view))
    if seen.truth is None and any(record.writer == name for record in folder.records):
        folder.faults.append(Fault(file, seen.name, f"is of no recorded frame: {frame} of {view}"))
    _check_classes(folder, seen.truth, classes, classes_file)
    seen.labels, seen.size = file, (int(facts["width"]), int(facts["height"]))
    seen.extra["sample"] = Stored(file, facts, objects, classes)
    seen.boxes.append(_boxes(file, objects, seen.truth))
    seen.later(lambda made: _read_images(folder, made, load))
    return seen


def _check_classes(folder: Folder, truth: Truth | None, classes: Sequence[str], file: str) -> None:
    """Names are those of the class table, as far as they go: it may have grown since in a run that has not ended."""
    rows = classes_of(folder, truth.filter_of(BOXES)) if truth is not None else None
    expected = [",".join(each["labels"].values()) for each in sorted(rows or (), key=lambda each: each["id"])]
    if rows is not None and list(classes) != expected[: len(classes)]:
        what = "names of classes are those of the class table"
        folder.faults.append(Fault(file, "all", what, ", ".join(expected), ", ".join(map(str, classes))))


def _truth(folder: Folder, writer: str, frame: int, view: str) -> Truth | None:
    for record in folder.records:
        if (record.writer, record.number) == (writer, frame):
            return next((Truth(record, each) for each in record.products if each.name == view), None)
    return None


def name_of(thing: Thing) -> str:
    """Return the name of a thing's class, as samples have it."""
    return ",".join(thing.labels.values())


def _boxes(file: str, objects: Sequence[Mapping[str, Any]], truth: Truth | None) -> Boxes:
    key = truth.filter_of(BOXES) if truth else ""
    known = {each.path: each for each in truth.things(key)} if truth else {}
    rows = np.zeros(len(objects), ROW)
    labels, paths = [], []
    for row, each in zip(rows, objects):
        x, y, width, height = (float(value) for value in each["bbox"])
        row["x_min"], row["y_min"], row["x_max"], row["y_max"] = x, y, x + width - 1, y + height - 1
        row["occlusionRatio"] = 1.0 - float(each["visibility"])
        thing, label, path = known.get(each["path"]), str(each["label"]), str(each["path"])
        # The same label, as the record writes it.
        labels.append(thing.label if thing is not None and name_of(thing) == label else label)
        paths.append(path)
    return Boxes(file, "tight", labels, paths, rows, key, [str(each["label"]) for each in objects])


def _read_images(folder: Folder, seen: Seen, load: Callable[[str], tuple[str, bytes] | None]) -> None:
    stored: Stored = seen.extra["sample"]
    decoded: dict[str, tuple[str, np.ndarray]] = {}
    for kind in (IMAGE, INSTANCES, DEPTH):
        member = load(kind)
        if member is None:
            if kind == IMAGE or (seen.truth is not None and seen.truth.record.parameters.get(_OPTIONS[kind])):
                folder.faults.append(Fault(stored.file, seen.name, f"the {kind} of the sample is missing"))
            continue
        name, data = member
        what = f"{name} {UNREADABLE}"
        made = attempt(folder.faults, stored.file, seen.name, what, lambda k=kind, d=data: _decoded(k, d))
        if made is not None:
            decoded[kind] = name, made
    if IMAGE in decoded:
        name, image = decoded[IMAGE]
        seen.colors.append(Color(f"{stored.file}:{name}", image, exact=name.endswith(".png")))
    if INSTANCES in decoded:
        ids = decoded[INSTANCES][1].astype(np.int64)
        seen.extra["sample"] = Stored(stored.file, stored.facts, stored.objects, stored.classes, ids)
    if DEPTH in decoded:
        seen.depths.append(Depth(f"{stored.file}:{decoded[DEPTH][0]}", "plane", decoded[DEPTH][1]))


def _decoded(kind: str, data: bytes) -> np.ndarray:
    if kind == DEPTH:
        return np.load(io.BytesIO(data), allow_pickle=False)
    return np.array(Image.open(io.BytesIO(data)))


def objects(seen: Seen) -> list[SeenObject]:
    """Return the objects of the sample."""
    found = []
    for each in seen.extra["sample"].objects:
        x, y, width, height = (float(value) for value in each["bbox"])
        made = SeenObject(str(each["label"]), str(each["path"]), (x, y, x + width, y + height))
        made.visibility = float(each["visibility"])
        made.mask = lambda complete, number=int(each["id"]): _mask(complete, number)
        found.append(made)
    return found


def _mask(seen: Seen, number: int) -> np.ndarray | None:
    ids = seen.extra["sample"].instances
    return None if ids is None else ids == number
