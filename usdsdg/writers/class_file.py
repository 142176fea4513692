"""The class table that is written beside a dataset, `.usdsdg/classes.json`."""

import json
from collections.abc import Iterable
from typing import Any

from usdsdg.annotators.annotator import Annotator
from usdsdg.annotators.class_table import DatasetClasses, ids_are_stable
from usdsdg.errors import warn_once
from usdsdg.session.session import current
from usdsdg.stage.semantics.semantic_classes import BESIDE, FILE
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.files import plain, write_text
from usdsdg.writers.journal.run import get_run
from usdsdg.writers.spool import place_of


class ClassFile:
    """Keeps the class file of one writer up to date: {"version": 1, "tables": [{"filter", "classes": [...]}]}.

    A class has an id, a name, labels by type, and a color (r, g, b, a). `semantic_classes` takes the file, or the
    folder of the dataset, so that another run goes on with the same classes.
    """

    def __init__(self) -> None:
        self._written: list[dict[str, Any]] = []
        self._classes: DatasetClasses | None = None  # those of the frames since the writer was attached

    def attach(self, writer: Any) -> None:
        """Let the frames of the writer, which is attached now, have the classes of those that it has written."""
        tables = current().class_tables
        before = tables.dataset
        if writer.num_written and self._classes is not None:
            tables.resume(self._classes)
        self._classes = tables.dataset
        others = [each for each in current().writers if each is not writer and each.num_written]
        if self._classes is not before and before.has_frames and others:
            warn_once(
                f"{type(writer).__name__} goes on with the classes of a stage before, so their ids change in what "
                f"{type(others[0]).__name__} has begun since. Detach that one before, or list semantic_classes."
            )

    def update(self, backend: BaseBackend, annotators: Iterable[Any]) -> None:
        """Schedule the file if the tables of the annotators' label filters have changed.

        Other writers in the folder write the same file, which has the tables of all of them.
        """
        if not ids_are_stable():
            return
        current().class_tables.dataset.has_frames = True
        place = place_of(backend)
        others = [each for each in current().writers if place is not None and _place(each) == place]
        read = [*annotators, *(annotator for other in others for annotator in other.annotators)]
        reading = [each for each in read if isinstance(each, Annotator) and each.reads_labels]
        filters = sorted({each.label_filter for each in reading}, key=lambda text: text or "")
        tables = [{"filter": each, "classes": current().class_tables.of(each).listed()} for each in filters]
        if tables != self._written:
            self._written = tables
            text = json.dumps({"version": 1, "tables": tables}, default=plain, indent=1)
            claimed = get_run().claim(place) if place is not None else None
            if claimed is not None:
                claimed.keep_classes(text)
            # In turn, since it replaces the earlier file.
            with current().io_queue.of_all_frames():
                backend.schedule_in_turn(FILE, write_text, path=f"{BESIDE}/{FILE}", text=text)


def _place(writer: Any) -> str | None:
    return place_of(writer.backend) if writer.backend is not None else None
