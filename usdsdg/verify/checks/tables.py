"""One id and one color for one class over the whole dataset, as its table of classes has it; and no class in black."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Ids, Occlusions, Seen, unpacked
from usdsdg.datasets.truth import BACKGROUND, INVALID, UNLABELLED, text_of
from usdsdg.record import CLASSES

_UNLABELED = 1  # id of all that has no label
_NOTHING = (BACKGROUND, UNLABELLED, INVALID)


class Tables:
    """What ids and colors have meant so far."""

    def __init__(self, classes: Mapping[str, Any] | None) -> None:
        self._by_name: dict[tuple, tuple[int, str]] = {}
        self._by_key: dict[tuple, tuple[str, str]] = {}
        self._classes = classes

    def check(self, seen: Seen) -> Faults:
        """Compare the tables of an image with those before."""
        for ids in seen.ids:
            if ids.meanings is None or ids.kind == "gprim" or ids.chosen:
                continue
            if seen.truth is not None and not seen.truth.record.stable_ids:
                continue
            for key, name in ids.meanings.items():
                yield from self._entry(seen, ids, key, name)
        for occlusions in seen.occlusions:
            if self._classes and seen.truth is not None and seen.truth.record.stable_ids:
                yield from _known_classes(seen, occlusions, self._classes)

    def _entry(self, seen: Seen, ids: Ids, key: int, name: str) -> Faults:
        what = (seen.format, ids.kind, ids.colored, ids.filter)
        shown = str(unpacked(key)) if ids.colored else str(key)
        if ids.kind != "instance labels":  # several may have the same, and an object another one than before
            before, frame = self._by_name.setdefault((*what, name), (key, seen.name))
            if before != key:
                was = str(unpacked(before)) if ids.colored else str(before)
                yield Fault(ids.table, seen.name, f"{name} has another {_noun(ids)} than in frame {frame}", was, shown)
            meant, frame = self._by_key.setdefault((*what, key), (name, seen.name))
            if meant != name:
                yield Fault(
                    ids.table, seen.name, f"{_noun(ids)} {shown} means something else than in frame {frame}", meant,
                    name,
                )  # fmt: skip
        if ids.colored and name not in _NOTHING and unpacked(key)[:3] == (0, 0, 0):
            yield Fault(ids.table, seen.name, f"{name} is black, as the background is")
        if ids.kind == "class" and self._classes:
            yield from _in_class_table(seen, ids, name, shown, self._classes)


def _known_classes(seen: Seen, occlusions: Occlusions, classes: Mapping[str, Any]) -> Faults:
    """The ids of classes beside occluded fractions are those of the dataset's table."""
    rows = next((each["classes"] for each in classes["tables"] if (each["filter"] or "") == occlusions.filter), None)
    if rows is None:
        return
    listed = {_UNLABELED, *(each["id"] for each in rows)}
    if unknown := sorted(set(occlusions.rows["semanticId"].tolist()) - listed):
        what = f"rows have the semanticId of no class in {CLASSES}"
        yield Fault(occlusions.file, seen.name, what, str(sorted(listed)), str(unknown))


def _noun(ids: Ids) -> str:
    return "color" if ids.colored else "id"


def _in_class_table(seen: Seen, ids: Ids, name: str, shown: str, classes: Mapping[str, Any]) -> Faults:
    """Compare an entry with the dataset's own table of classes."""
    rows = next((each["classes"] for each in classes["tables"] if (each["filter"] or "") == ids.filter), None)
    if rows is None or name in _NOTHING:
        return
    row = next((each for each in rows if text_of(each["labels"]) == name), None)
    if row is None:
        yield Fault(CLASSES, seen.name, f"{name} is in {ids.table}, and not listed")
    elif shown != str(tuple(row["color"]) if ids.colored else row["id"]):
        expected = tuple(row["color"]) if ids.colored else row["id"]
        yield Fault(ids.table, seen.name, f"the {_noun(ids)} of {name} in {CLASSES}", str(expected), shown)
