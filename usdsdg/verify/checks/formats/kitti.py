"""KITTI: ids and colors of classes, numbers of objects, lines, and lists of pictures."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Seen, packed, unpacked
from usdsdg.datasets.truth import Thing, Truth
from usdsdg.errors import counted
from usdsdg.verify.checks.compare import of_pixels
from usdsdg.verify.checks.formats.kitti_lines import check_lines
from usdsdg.writers.formats.kitti import files
from usdsdg.writers.formats.kitti.files import NAME

CLASSES, INSTANCES = "semantic_segmentation", "instance_segmentation_fast"


class Kitti:
    """Checks of all images of a dataset; colors of classes are compared among them."""

    def __init__(self) -> None:
        self._colors: dict[int, tuple[int, str]] = {}  # by id of the class: color and the frame that had it first

    def check(self, seen: Seen) -> Faults:
        """Check one image."""
        if seen.format != NAME:
            return
        for file, lines in seen.lines:
            yield from check_lines(seen, file, lines)
        lists = seen.extra.get("parts")
        if lists is not None and len(lists) != 1:
            yield Fault(files.IMAGE_SETS, seen.name, "one part has the picture", "1", ", ".join(lists) or "none")
        if seen.truth is not None:
            yield from _classes(seen, seen.truth)
            yield from _instances(seen, seen.truth)
        yield from self._colors_of_classes(seen)

    def _colors_of_classes(self, seen: Seen) -> Faults:
        if "ids" not in seen.extra or "colors" not in seen.extra:
            return
        (_, ids), (file, colors) = seen.extra["ids"], seen.extra["colors"]
        if ids.shape != colors.shape[:2]:
            yield Fault(file, seen.name, "has another size than the ids", str(ids.shape), str(colors.shape))
            return
        keys = packed(colors)
        for number in np.unique(ids).tolist():
            found = np.unique(keys[ids == number])
            first, frame = self._colors.setdefault(number, (int(found[0]), seen.name))
            if len(found) > 1:
                yield Fault(file, seen.name, f"class {number} has {len(found)} colors")
            elif int(found[0]) != first:
                yield Fault(
                    file,
                    seen.name,
                    f"class {number} has another color than in frame {frame}",
                    str(unpacked(first)),
                    str(unpacked(int(found[0]))),
                )


def _class_table(seen: Seen) -> dict[str, int]:
    return {
        _plain(name): int(number) for name, number in (seen.extra.get("metadata") or {}).get("semantic_ids", {}).items()
    }


def _plain(name: str) -> str:
    return name.lower().replace("_", " ")


def _class_of(labels: Mapping[str, str], table: Mapping[str, int]) -> int:
    """Return the id of the class of labels: that of the last known one, or of "unlabelled"."""
    names = [_plain(f"{kind}:{name}") for kind, own in labels.items() for name in (own, *own.split(","))]
    return next((table[name] for name in reversed(names) if name in table), table.get("class:unlabelled", 0))


def _classes(seen: Seen, truth: Truth) -> Faults:
    table, key = _class_table(seen), truth.filter_of(CLASSES)
    members = truth.members(key)
    if not table or members is None or "ids" not in seen.extra:
        return
    file, ids = seen.extra["ids"]
    things = truth.things(key)
    expected = np.array(
        [
            *(_class_of(each.labels, table) for each in things),
            table.get("class:background", 0),
            table.get("class:unlabelled", 0),
        ]
    )
    if ids.shape != members.shape:
        yield Fault(file, seen.name, "has another size", str(members.shape), str(ids.shape))
        return
    wrong = ids != expected[members]
    if wrong.any():
        row, column = np.argwhere(wrong)[0]
        yield Fault(
            file,
            seen.name,
            f"ids of classes differ in {of_pixels(wrong)}",
            str(expected[members][row, column]),
            str(ids[row, column]),
        )
    if "colors" in seen.extra:
        yield from _chosen_colors(seen, truth, members, things)


def _chosen_colors(seen: Seen, truth: Truth, members: np.ndarray, things: list[Thing]) -> Faults:
    """Classes to which the user gave a color have it."""
    given = truth.record.parameters.get("mapping_dict") or {}
    named = {
        _plain(name if ":" in name else f"class:{name}"): value
        for name, value in given.items()
        if isinstance(value, list)
    }
    file, colors = seen.extra["colors"]
    for index, thing in enumerate(things):
        names = [_plain(f"{kind}:{name}") for kind, own in thing.labels.items() for name in (own, *own.split(","))]
        color = next((named[name] for name in reversed(names) if name in named), None)
        mine = colors[members == index] if colors.shape[:2] == members.shape else np.zeros((0, 4))
        if color is not None and (mine != np.array(color)[: mine.shape[1]]).any():
            yield Fault(
                file,
                seen.name,
                f"the color of {thing.path}, {thing.label}",
                str(color),
                str(np.unique(mine, axis=0)[:2].tolist()),
            )


def _instances(seen: Seen, truth: Truth) -> Faults:
    key = truth.filter_of(INSTANCES)
    members = truth.members(key)
    for kind in ("instances", "instance colors"):
        if members is None or kind not in seen.extra:
            continue
        file, image = seen.extra[kind]
        keys = packed(image) if image.ndim == 3 else image.astype(np.int64)
        if keys.shape != members.shape:
            yield Fault(file, seen.name, "has another size", str(members.shape), str(keys.shape))
            continue
        first: dict[int, str] = {}
        full = _full_classes(keys) if kind == "instances" else set()
        for index, thing in enumerate(truth.things(key)):
            found = np.unique(keys[members == index])
            if len(found) > 1:
                yield Fault(file, seen.name, f"{thing.path} has {len(found)} numbers")
            elif len(found) and (kind == "instance colors" or found[0] % 256):
                other = first.setdefault(int(found[0]), thing.path)
                if other != thing.path:
                    yield Fault(file, seen.name, f"{other} and {thing.path} share {int(found[0])}")
            if kind == "instances" and len(found) == 1:
                yield from _class_part(seen, file, thing, int(found[0]), full)
        nothing = np.unique(keys[members < 0] % 256) if kind == "instances" else np.zeros(0)
        if nothing.any():
            yield Fault(file, seen.name, "what has no label has no number", "0", str(nothing.tolist()))
        if kind == "instance colors" and (colored := image[members < 0][:, :3].any(axis=1)).any():
            yield Fault(file, seen.name, f"what has no label is black, but {counted(int(colored.sum()), 'pixel')}")


def _full_classes(keys: np.ndarray) -> set[int]:
    """Return the classes of which an image has all numbers, so that further objects have none."""
    numbered = np.unique(keys[keys % 256 > 0])
    classes, counts = np.unique(numbered // 256, return_counts=True)
    return set(classes[counts == 255].tolist())


def _class_part(seen: Seen, file: str, thing: Thing, value: int, full: Collection[int]) -> Faults:
    expected = _class_of(thing.labels, _class_table(seen))
    if _class_table(seen) and value // 256 != expected:
        yield Fault(file, seen.name, f"the class of {thing.path}", str(expected), str(value // 256))
    if value % 256 == 0 and value // 256 not in full:
        yield Fault(file, seen.name, f"{thing.path} has a number", "1 to 255", "0")
