"""Places of classes: numbers from 0 without gaps, in the order of the class table, for formats that count so."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdsdg.annotators.class_table import ClassTable, Output
from usdsdg.session.session import current


def table_of(label_filter: str | None) -> ClassTable:
    """Return the class table of an annotator's label filter."""
    return current().class_tables.of(label_filter)


def names(table: ClassTable) -> list[str]:
    """Return the names of all classes; several labels of one are joined with commas."""
    return [",".join(labels.values()) for labels in table.labels().values()]


def places(table: ClassTable, kinds: Sequence[Output]) -> np.ndarray:
    """Return the place of each of the labels' classes, int (N,). Ids may have gaps where the user has given them."""
    ids = table.ids(kinds)  # which adds classes that are new
    return np.searchsorted(list(table.labels()), ids)
