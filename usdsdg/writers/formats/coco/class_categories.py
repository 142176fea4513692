"""The classes of the dataset as COCO categories, with the ids that they have in masks."""

from collections.abc import Mapping
from typing import Any

from usdsdg.annotators.class_table import ClassTable
from usdsdg.session.session import current
from usdsdg.writers.formats.coco.coco_categories import Category


class ClassCategories:
    """Every class that the run can show, seen or not, as a category. Asked as `Categories` is.

    Classes of one name, which labels of several types have, are one category, with the id of the first.
    """

    reserve = None  # every label has a category

    def __init__(self, label_filter: str | None) -> None:
        self._filter = label_filter

    def all(self) -> list[Category]:
        """Return the categories by id."""
        return list(self._by_name().values())

    def of(self, labels: Mapping[str, str]) -> Category:
        """Return the category of {type: "label[,label]"}."""
        number = int(self._table.ids([labels])[0])
        name = next(row["name"] for row in self._table.listed() if row["id"] == number)
        return self._by_name()[name]

    def _by_name(self) -> dict[str, Category]:
        found: dict[str, Category] = {}
        for row in self._table.listed():
            found.setdefault(row["name"], _category(row))
        return found

    @property
    def _table(self) -> ClassTable:
        return current().class_tables.of(self._filter)


def _category(row: Mapping[str, Any]) -> Category:
    name = row["name"]
    return {"name": name, "id": row["id"], "color": row["color"][:3], "supercategory": name, "isthing": 1}
