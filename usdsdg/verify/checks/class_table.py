"""The table of classes beside a dataset has the classes that its records name, with their ids."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.truth import text_of
from usdsdg.record import CLASSES


def check(folder: Folder) -> Faults:
    """Compare the table with the ids that the records have for the filters of annotators."""
    if folder.classes is None:
        return
    tables: Mapping[str, list[dict[str, Any]]] = {
        each["filter"] or "": each["classes"] for each in folder.classes["tables"]
    }
    known: set[tuple[str, str, int]] = set()
    for record in folder.records if all(each.stable_ids for each in folder.records) else ():
        filters = {str(each["filter"]) for each in record.annotators.values() if each.get("filter")}
        for key in sorted(filters):
            if key not in tables:
                if (key, "", 0) not in known:
                    yield Fault(CLASSES, "all", f"has a table for the filter {key}", "", ", ".join(tables) or "none")
                known.add((key, "", 0))
                continue
            ids = {text_of(row["labels"]): row["id"] for row in tables[key]}
            for product in record.products:
                if key not in product.selections:
                    continue
                selection = product.selections[key]
                for labels, number in zip(selection.labels, selection.class_ids.tolist()):
                    name = text_of(labels)
                    if (key, name, number) not in known and ids.get(name) != number:
                        yield Fault(CLASSES, str(record.number), f"the id of {name}", str(number), str(ids.get(name)))
                    known.add((key, name, number))
