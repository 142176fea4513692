"""Which record, and which of its render products, the files of an image belong to."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

from usdsdg.datasets.folder import Folder
from usdsdg.datasets.truth import Truth
from usdsdg.record.frame_record import FrameRecord


def record_of(folder: Folder, files: Sequence[str]) -> FrameRecord | None:
    """Return the record that names most of the files; None if none does."""
    counts = Counter(folder.record_of[file].number for file in files if file in folder.record_of)
    if not counts:
        return None
    number = counts.most_common(1)[0][0]
    return next(
        folder.record_of[file] for file in files if file in folder.record_of and folder.record_of[file].number == number
    )


def classes_of(folder: Folder, key: str) -> list[dict[str, Any]] | None:
    """Return the rows of the class table of a label filter; None if it is not written."""
    tables = (folder.classes or {}).get("tables", ())
    return next((each["classes"] for each in tables if (each["filter"] or "") == key), None)


def truth_of(folder: Folder, files: Sequence[str], view: str) -> Truth | None:
    """Return what is recorded of the image of these files; `view` is the product's name, "" for the only one."""
    record = record_of(folder, files)
    if record is None:
        return None
    names = view.split("/")
    product = next((each for each in record.products if each.name in names), None)
    if product is None and len(record.products) == 1:
        product = record.products[0]
    return None if product is None else Truth(record, product)
