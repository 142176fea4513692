"""Names of classes: as they are shown, and for formats whose texts cannot have every character."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from usdsdg.errors import WriterError, warn_once

# What no XML can have, and line breaks.
CONTROL = r"[\x00-\x1f\x7f\ufffe\uffff]"

_NOTHING = re.compile(r"(?!)")


def shown_labels(labels: Any) -> str:
    """Return labels of an annotator's table, {type: "label"} or a text, as one text to be shown."""
    return ", ".join(map(str, labels.values())) if isinstance(labels, Mapping) else str(labels)


def class_name(labels: Mapping[str, str], unfit: re.Pattern[str]) -> str:
    """Return the name of a class {type: "label[,label]"}: its labels, with "_" for what is unfit."""
    return unfit.sub("_", ",".join(label for _, label in sorted(labels.items())))


def class_names(writer: str, classes: Sequence[Mapping[str, str]], unfit: re.Pattern[str]) -> list[str]:
    """Return the names of all classes, and warn where one has to differ from its labels.

    Raises:
        WriterError: two would be the same.
    """
    names = [class_name(each, unfit) for each in classes]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise WriterError(f"{writer}: several classes would be called {', '.join(twice)}. Rename their labels.")
    for labels, name in zip(classes, names):
        whole = class_name(labels, _NOTHING)
        if name != whole:
            warn_once(f"{writer}: the class {whole!r} is called {name!r}, since the format cannot have all of it.")
    return names
