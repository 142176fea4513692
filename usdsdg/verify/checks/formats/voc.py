"""Pascal VOC: segments of classes, colors of indices, and the lists of pictures."""

from __future__ import annotations

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Seen
from usdsdg.verify.checks.compare import of_pixels
from usdsdg.writers.formats.voc import files
from usdsdg.writers.formats.voc.image_sets import NOT_SHOWN, ONLY_DIFFICULT, SHOWN

# VOC's first colors, and that of the border.
_COLORS = {0: (0, 0, 0), 1: (128, 0, 0), 2: (0, 128, 0), 3: (128, 128, 0), 4: (0, 0, 128), 255: (224, 224, 192)}


def check(seen: Seen) -> Faults:
    """Check one picture's segments, and what the lists say of it."""
    if seen.format != files.NAME:
        return
    labels, rows, lists = seen.extra["voc"]
    name = seen.picture.rsplit("/", 1)[-1]
    if seen.extra["file name"] != name:
        yield Fault(seen.labels, seen.name, "filename is that of the picture", name, str(seen.extra["file name"]))
    for each in seen.labeled:
        if each.name not in labels[1:]:
            yield Fault(seen.labels, seen.name, f"{files.LABELS} names {each.name}", "", ", ".join(labels))
    yield from _segments(seen, labels)
    yield from _lists(seen, rows, lists)


def _segments(seen: Seen, labels: list[str]) -> Faults:
    for kind in (files.CLASSES, files.OBJECTS):
        if kind not in seen.extra:
            continue
        file, indices, palette = seen.extra[kind]
        for index, color in _COLORS.items():
            if tuple(palette[index].tolist()) != color:
                yield Fault(file, seen.name, f"the color of index {index}", str(color), str(palette[index].tolist()))
        if indices.shape[::-1] != seen.size:
            yield Fault(file, seen.name, "has another size", str(seen.size), str(indices.shape[::-1]))
            return
    if files.CLASSES not in seen.extra or files.OBJECTS not in seen.extra:
        return
    (file, classes, palette), (other, own, _) = seen.extra[files.CLASSES], seen.extra[files.OBJECTS]
    yield from _label_colors(seen, palette)
    expected = np.zeros(classes.shape, classes.dtype)
    for each in seen.labeled:
        if each.mask is not None and each.name in labels:
            expected[each.mask] = labels.index(each.name)
    wrong = (expected != classes) & (own != files.VOID)
    if wrong.any():
        yield Fault(file, seen.name, f"classes are those of {other} and the XML, but {of_pixels(wrong)}")
    unknown = sorted(set(np.unique(own).tolist()) - {0, files.VOID, *range(1, len(seen.labeled) + 1)})
    if unknown:
        yield Fault(other, seen.name, "indices are those of the objects of the XML", "", str(unknown))


def _label_colors(seen: Seen, palette: np.ndarray) -> Faults:
    """Readers that take pictures of segments as colors look these up in the table of classes."""
    for index, found in enumerate(seen.extra["voc colors"][: len(palette)]):
        expected = ",".join(map(str, palette[index].tolist()))
        if found != expected:
            yield Fault(files.LABELS, seen.name, f"the color of row {index}", expected, found)


def _lists(seen: Seen, rows: dict[str, str], lists: list[str]) -> Faults:
    """A picture is in the lists of one part, and in those of classes as its objects say."""
    for folder in (files.MAIN, files.SEGMENTATION):
        own = [path for path in rows if path.startswith(f"{folder}/") and not rows[path]]
        if len(own) != 1:
            yield Fault(folder, seen.name, "one part has the picture", "1", ", ".join(own) or "none")
    (split, *_) = [path.rsplit("/", 1)[-1] for path in rows if not rows[path]] or [""]
    for name in dict.fromkeys(each.name for each in seen.labeled):
        difficult = [each.flags["difficult"] for each in seen.labeled if each.name == name]
        expected = ONLY_DIFFICULT if all(difficult) else SHOWN
        path = files.image_set(files.MAIN, split.removesuffix(".txt"), name)
        if rows.get(path) != str(expected):
            yield Fault(path, seen.name, f"what it says of {name}", str(expected), rows.get(path, "nothing"))
    shown = {files.image_set(files.MAIN, split.removesuffix(".txt"), each.name) for each in seen.labeled}
    for path, value in rows.items():
        if value and path not in shown and value != str(NOT_SHOWN):
            yield Fault(path, seen.name, "what it says of a class that is not there", str(NOT_SHOWN), value)
    if not lists:
        yield Fault("ImageSets", seen.name, "there are no lists of pictures")
