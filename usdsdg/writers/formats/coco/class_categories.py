"""The classes of the dataset as COCO categories, with the ids that they have in masks."""

from collections.abc import Mapping
from typing import Any

from usdsdg.annotators.class_table import ClassTable
from usdsdg.session.session import current
from usdsdg.writers.formats.coco.coco_categories import Category


class ClassCategories:
    """Every class that the run can show, seen or not, as a category. Asked as `Categories` is."""

    reserve = None  # every label has a category

    def __init__(self, label_filter: str | None) -> None:
        self._filter = label_filter

    def all(self) -> list[Category]:
        """Return the categories by id."""
        return [_category(row) for row in self._table.listed()]

    def of(self, labels: Mapping[str, str]) -> Category:
        """Return the category of {type: "label[,label]"}."""
        number = int(self._table.ids([labels])[0])
        return next(each for each in self.all() if each["id"] == number)

    @property
    def _table(self) -> ClassTable:
        return current().class_tables.of(self._filter)


def _category(row: Mapping[str, Any]) -> Category:
    name = row["name"]
    return {"name": name, "id": row["id"], "color": row["color"][:3], "supercategory": name, "isthing": 1}
