"""The classes of a dataset: id and color of each set of labels, the same in all frames, products, and runs.

What a run can show is known before its first frame from stage and graph, and numbered in the order of the names, so
that no frame, seed or viewpoint decides an id. The user's `semantic_classes` come first, with the ids that they name.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from usdsdg.annotators.colors import FIRST_LABELED, colors_of_ids
from usdsdg.errors import ConfigError, warn_once
from usdsdg.session.session import current
from usdsdg.stage.semantics.semantic_classes import GivenClass, read_semantic_classes

Output = Mapping[str, str]  # {type: "label[,label]"}
Key = tuple[tuple[str, str], ...]

CLASSES, CLOSED, STABLE = (
    "/usdsdg/labels/semanticClasses",
    "/usdsdg/labels/closedClasses",
    "/usdsdg/labels/stableIds",
)


class ClassTable:
    """The classes that one label filter can give."""

    def __init__(self, given: Sequence[GivenClass] = (), *, closed: bool = False) -> None:
        self._ids: dict[Key, int] = {}
        self._colors: dict[int, tuple[int, int, int, int]] = {}
        self._given, self._closed, self._begun = len(given), closed, False
        self._listed: list[dict[str, Any]] | None = None
        taken = {each.id for each in given}
        free = (number for number in range(FIRST_LABELED, len(given) + len(taken) + FIRST_LABELED))
        for each in given:
            number = each.id if each.id is not None else next(n for n in free if n not in taken)
            self._ids[each.labels] = number
            if each.color is not None:
                self._colors[number] = each.color

    def add(self, outputs: Iterable[Output]) -> None:
        """Give ids to sets of labels that have none, in the order of the names.

        Raises:
            ConfigError: the table is closed and has some of them not. What is added first, to a table that the user has
                not fixed, is what stage and graph can show.
        """
        missing = sorted({_key(output) for output in outputs} - self._ids.keys())
        if missing and self._closed and (self._given or self._begun):
            raise ConfigError(
                f"{', '.join(map(_text, missing))} is not in the class table of this dataset, which all its parts "
                f"share ({', '.join(map(_text, self._ids)) or 'it is empty'}). List it in semantic_classes, in every "
                "part."
            )
        if missing and self._given:
            warn_once(
                f"{', '.join(map(_text, missing))} is not among semantic_classes; it gets an id after those, which may "
                "be another in other runs. List it there."
            )
        self._begun = True
        if missing:
            self._listed = None
        first = max(self._ids.values(), default=FIRST_LABELED - 1) + 1
        self._ids.update((key, number) for number, key in enumerate(missing, first))

    def ids(self, outputs: Sequence[Output]) -> np.ndarray:
        """Return the id of each set of labels, int64 (N,); new ones are added."""
        self.add(outputs)
        return np.array([self._ids[_key(output)] for output in outputs], np.int64)

    def labels(self) -> dict[int, dict[str, str]]:
        """Return the labels of each class by id, in the order of the ids."""
        return {number: dict(key) for key, number in sorted(self._ids.items(), key=lambda item: item[1])}

    def colors(self) -> dict[int, tuple[int, int, int, int]]:
        """Return the colors that the user has given, RGBA by id."""
        return dict(self._colors)

    def listed(self) -> list[dict[str, Any]]:
        """Return the table as it is written beside a dataset: id, labels, color and name of each class.

        The list is made anew where a class is added; it must not be changed.
        """
        if self._listed is None:
            self._listed = self._rows()
        return self._listed

    def _rows(self) -> list[dict[str, Any]]:
        rows = []
        for number, labels in self.labels().items():
            color = self._colors.get(number) or colors_of_ids([number])[0].tolist()
            rows.append({"id": number, "name": ",".join(labels.values()), "labels": labels, "color": list(color)})
        return rows


@dataclass
class DatasetClasses:
    """The class tables of one dataset."""

    given: tuple[GivenClass, ...]  # what the user has fixed
    closed: bool
    by_filter: dict[str | None, ClassTable] = field(default_factory=dict)
    has_frames: bool = False  # whether writers have written some

    def of(self, predicate: str | None) -> ClassTable:
        """Return the table of a label filter, at first with the classes that the user has fixed."""
        if predicate not in self.by_filter:
            self.by_filter[predicate] = ClassTable(self.given, closed=self.closed)
        return self.by_filter[predicate]


class ClassTables:
    """The class tables of the session by label filter.

    A new stage begins new tables, unless a writer that has written frames goes on with it: these are one dataset.
    """

    def __init__(self) -> None:
        self.version = 1  # changes when the tables are others
        settings = current().settings
        for key in (CLASSES, CLOSED):
            settings.on_change(key, self._start_again)
        self._start_again(None)

    @property
    def given(self) -> tuple[GivenClass, ...]:
        """The classes that the user has fixed."""
        return self.dataset.given

    def of(self, predicate: str | None) -> ClassTable:
        """Return the table of a label filter."""
        return self.dataset.of(predicate)

    def reset(self) -> None:
        """Begin new tables, as for a new stage."""
        self.dataset = DatasetClasses(self.dataset.given, self.dataset.closed)
        self.version += 1

    def resume(self, dataset: DatasetClasses) -> None:
        """Go on with the tables of a dataset, which a stage before may have begun, unless the user has fixed others."""
        before = self.dataset
        if dataset is before or (dataset.given, dataset.closed) != (before.given, before.closed):
            return
        self.dataset = dataset
        if not before.has_frames:  # it has what the new stage can show, and else another dataset's
            for predicate, table in before.by_filter.items():
                dataset.of(predicate).add(table.labels().values())
        self.version += 1

    def _start_again(self, _: Any) -> None:
        settings = current().settings
        self.dataset = DatasetClasses(read_semantic_classes(settings.get(CLASSES)), bool(settings.get(CLOSED)))
        self.version += 1


def ids_are_stable() -> bool:
    """Return whether ids are those of the class tables; if not, they count what each frame shows, as in Isaac Sim."""
    return bool(current().settings.get(STABLE))


def _key(output: Output) -> Key:
    return tuple(sorted(output.items()))


def _text(key: Key) -> str:
    return " ".join(repr(label) if kind == "class" else repr(f"{kind}:{label}") for kind, label in key)
