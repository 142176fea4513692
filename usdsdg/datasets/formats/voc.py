"""Reader of VocWriter's folders."""

from __future__ import annotations

from collections.abc import Iterator
from glob import escape
from pathlib import PurePosixPath
from xml.etree import ElementTree

import numpy as np
from PIL import Image

from usdsdg.datasets.color_images import read_color
from usdsdg.datasets.faults import Fault
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.matching import truth_of
from usdsdg.datasets.seen import Labeled, Seen
from usdsdg.datasets.seen_object import SeenObject
from usdsdg.writers.formats.voc import files as names
from usdsdg.writers.formats.voc.files import NAME

_FLAGS = ("truncated", "occluded", "difficult")


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the files of each picture say."""
    pictures = {PurePosixPath(file).stem: file for file in files if PurePosixPath(file).parts[0] == names.PICTURES}
    annotations = [
        file for file in files if PurePosixPath(file).parts[0] == names.ANNOTATIONS and file.endswith(".xml")
    ]
    if not annotations:
        return
    rows_of_labels = _rows_of_labels(folder)
    labels = [row[0] for row in rows_of_labels]
    listed = [file for file in files if PurePosixPath(file).parts[0] == "ImageSets"]
    lists = {file: _listed(folder, file) for file in [*listed, *_hidden_lists(folder, labels)]}
    stems = {PurePosixPath(file).stem for file in annotations}
    for file, rows in lists.items():
        if unknown := sorted(set(rows) - stems):
            folder.faults.append(Fault(file, "all", "lists pictures without annotations", "", ", ".join(unknown[:8])))
    for file in annotations:
        stem = PurePosixPath(file).stem
        mine = [file, *(names.segments(kind, stem) for kind in (names.CLASSES, names.OBJECTS))]
        mine += [pictures[stem]] if stem in pictures else []
        view, _, number = stem.rpartition("_")
        seen = Seen(NAME, number, view, mine, truth_of(folder, mine, view))
        seen.picture, seen.labels = pictures.get(stem, ""), file
        root = folder.binary(file, seen.name, ElementTree.fromstring)
        if root is None or folder.parsed(file, seen.name, lambda s=seen, r=root: _fill(s, r)) is None:
            continue
        seen.extra["voc"] = (labels, {path: rows[stem] for path, rows in lists.items() if stem in rows}, list(lists))
        seen.extra["voc colors"] = [row[1] if len(row) > 1 else "" for row in rows_of_labels]
        seen.later(lambda made: _read_images(folder, made))
        yield seen


def _rows_of_labels(folder: Folder) -> list[list[str]]:
    """Return the columns of the rows of the indices of classes: a name, a color, and more."""
    text = folder.text(names.LABELS, "all") or ""
    return [line.split(":") for line in text.splitlines() if line and not line.startswith("#")]


def _hidden_lists(folder: Folder, labels: list[str]) -> list[str]:
    """Return the lists of classes whose names begin with a dot, which are hidden files."""
    hidden = [label for label in labels if label.startswith(".")]
    found = [file for label in hidden for file in (folder.path / names.MAIN).glob(f"{escape(label)}_*.txt")]
    return sorted({f"{names.MAIN}/{file.name}" for file in found})


def _listed(folder: Folder, file: str) -> dict[str, str]:
    """Return the pictures of a list with what it says of each."""
    rows = [line.split() for line in (folder.text(file, "all") or "").splitlines()]
    return {row[0]: " ".join(row[1:]) for row in rows if row}


def _fill(seen: Seen, root: ElementTree.Element) -> Seen:
    size = {each.tag: int(each.text or "") for each in _child(root, "size")}
    seen.size = (size["width"], size["height"])
    seen.extra["file name"] = _child(root, "filename").text
    for each in root.findall("object"):
        sides = {side.tag: int(side.text or "") for side in _child(each, "bndbox")}
        flags = {name: {"0": False, "1": True}[_child(each, name).text or ""] for name in _FLAGS}
        # They are counted from 1, the last included.
        box = (sides["xmin"] - 1.0, sides["ymin"] - 1.0, float(sides["xmax"]), float(sides["ymax"]))
        seen.labeled.append(Labeled(_child(each, "name").text or "", box, flags=flags))
    return seen


def _child(root: ElementTree.Element, name: str) -> ElementTree.Element:
    found = root.find(name)
    if found is None:
        raise KeyError(name)
    return found


def _read_images(folder: Folder, seen: Seen) -> None:
    if seen.picture:
        read_color(folder, seen, seen.picture)
    for file in seen.files[1:3]:
        found = folder.binary(file, seen.name, lambda data: _indices(data))
        if found is not None:
            seen.extra[file.split("/")[0]] = (file, *found)
    if names.OBJECTS in seen.extra:
        indices = seen.extra[names.OBJECTS][1]
        seen.labeled = [
            Labeled(each.name, each.box, indices == number if number < names.VOID else None, flags=each.flags)
            for number, each in enumerate(seen.labeled, 1)
        ]


def _indices(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices (H, W) of a picture, and its palette (N, 3)."""
    import io

    with Image.open(io.BytesIO(data)) as image:
        if image.mode != "P":
            raise ValueError(f"it has no palette: it is of mode {image.mode}")
        return np.array(image), np.array(image.getpalette(), np.uint8).reshape(-1, 3)


def objects(seen: Seen) -> list[SeenObject]:
    """Return the objects of the XML."""
    return [SeenObject(each.name, box=each.box) for each in seen.labeled]
