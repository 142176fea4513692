"""`semantic_classes`: the classes of a dataset as users give them, in Python, a configuration or a file."""

import json
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from usdsdg.errors import ConfigError
from usdsdg.stage.assets.file_checks import check_regular

BESIDE = ".usdsdg"  # folder in a dataset with what usdsdg notes about it
FILE = "classes.json"
FIRST_ID = 2  # 0 is the background, 1 is what has no label
MAX_ID = 65535  # what a 16-bit mask holds
MAX_BYTES = 16 << 20  # of a file

_FORM = (
    "expected names such as ['apple', 'pear'], ids {'apple': 2, 'pear': 3}, {'apple': {'id': 2, 'color': [255, 0, "
    "0]}}, a .json, .yaml or .txt file of these, or the folder of a dataset"
)


@dataclass(frozen=True)
class GivenClass:
    """One class that the user has fixed."""

    labels: tuple[tuple[str, str], ...]  # (type, "label[,label]"), sorted
    id: int | None = None
    color: tuple[int, int, int, int] | None = None


def read_semantic_classes(given: Any) -> tuple[GivenClass, ...]:
    """Return the classes of a list, a mapping, a file or a dataset; () for None or an empty one.

    A name is a label of the type "class", or "type:label"; several labels of one prim are joined by commas, as
    annotators output them. Names are compared in lower case. A class without an id gets the next free one, from 2.

    Raises:
        ConfigError: it is something else, two classes are the same or have one id, or an id is below 2 (0 is the
            background, 1 is unlabelled) or above 65535.
    """
    if given is None or given == "":
        return ()
    if isinstance(given, (str, os.PathLike)):
        given = read_class_file(Path(given))
    if isinstance(given, Mapping) and isinstance(given.get("tables"), Sequence):  # a class file of ours
        rows = [each for table in given["tables"] for each in _rows(table)]
        given = [each for index, each in enumerate(rows) if each not in rows[:index]]
    if isinstance(given, Mapping):
        classes = [_class(name, about) for name, about in given.items()]
    elif isinstance(given, Sequence) and not isinstance(given, (str, bytes)):
        classes = [_class(each, None) for each in given]
    else:
        raise ConfigError(f"semantic_classes is {given!r}; {_FORM}.")
    _check(classes)
    return tuple(classes)


def read_class_file(path: Path) -> Any:
    """Return the content of a class file, or of the one of a dataset, in one of the forms of `semantic_classes`.

    Raises:
        ConfigError: the file cannot be read.
    """
    file = path
    try:
        file = next((each for each in (path / BESIDE / FILE, path / FILE) if each.is_file()), path)
        check_regular(str(file))
        if file.stat().st_size > MAX_BYTES:
            raise ValueError(f"it has more than {MAX_BYTES >> 20} MB")
        text = file.read_text(encoding="utf-8")
        if file.suffix == ".txt":
            return [line.strip() for line in text.splitlines() if line.strip() and not line.startswith("#")]
        return json.loads(text) if file.suffix == ".json" else yaml.safe_load(text)
    except (OSError, ValueError, LookupError, AttributeError, TypeError, RecursionError, yaml.YAMLError) as error:
        # PyYAML raises whatever the conversion of a value does, as an IndexError of `!!int ""`.
        raise ConfigError(
            f"semantic_classes: {file} cannot be read: {error}. {_FORM[0].upper()}{_FORM[1:]}."
        ) from error


def _rows(table: Any) -> Sequence[Any]:
    """Return the classes of a table of a class file of ours."""
    rows = table.get("classes") if isinstance(table, Mapping) else None
    if not isinstance(rows, Sequence) or isinstance(rows, str):
        raise ConfigError("semantic_classes: the class file has a table without classes; take the one of a dataset.")
    return rows


def _class(name: Any, about: Any) -> GivenClass:
    if isinstance(name, Mapping) and isinstance(name.get("labels"), Mapping):  # an entry of a class file of ours
        name, about = name["labels"], name
    if isinstance(about, int) and not isinstance(about, bool):
        about = {"id": about}
    about = about or {}
    color, number = (about.get("color"), about.get("id")) if isinstance(about, Mapping) else (None, None)
    if not isinstance(about, Mapping) or not isinstance(number, (int, type(None))) or isinstance(number, bool):
        raise ConfigError(f"semantic_classes: {name!r} has {about!r}; {_FORM}.")
    if number is not None and not FIRST_ID <= number <= MAX_ID:
        raise ConfigError(
            f"semantic_classes: {name!r} has the id {number}; expected {FIRST_ID} to {MAX_ID}, since 0 is the "
            "background and 1 is what has no label."
        )
    return GivenClass(_labels(name), number, _color(name, color))


def _labels(name: Any) -> tuple[tuple[str, str], ...]:
    if isinstance(name, str) and name.strip():
        kind, colon, label = name.partition(":")
        pairs = {kind.strip(): label.strip()} if colon else {"class": name.strip()}
    else:
        pairs = name
    if not isinstance(pairs, Mapping) or not all(
        isinstance(text, str) and text for pair in pairs.items() for text in pair
    ):
        raise ConfigError(f"semantic_classes: {name!r} is not a class; {_FORM}.")
    return tuple(sorted((kind, label.lower()) for kind, label in pairs.items()))


def _color(name: Any, color: Any) -> tuple[int, int, int, int] | None:
    if color is None:
        return None
    channels = list(color) if isinstance(color, Sequence) and not isinstance(color, str) else []
    if len(channels) not in (3, 4) or not all(isinstance(each, int) and 0 <= each <= 255 for each in channels):
        raise ConfigError(f"semantic_classes: the color of {name!r} is {color!r}; expected [r, g, b], 0 to 255.")
    if not any(channels[:3]):
        raise ConfigError(f"semantic_classes: the color of {name!r} is black, which is the background's; give another.")
    red, green, blue, alpha = (*channels, 255)[:4]
    return red, green, blue, alpha


def _check(classes: Sequence[GivenClass]) -> None:
    for what, values in (
        ("are the same class", [str(each.labels) for each in classes]),
        ("have one id", [str(each.id) for each in classes if each.id is not None]),
        ("have one color", [str(each.color) for each in classes if each.color is not None]),
    ):
        twice = next((value for value, count in Counter(values).items() if count > 1), None)
        if twice is not None:
            raise ConfigError(f"semantic_classes: two entries {what}, {twice}; give each its own.")
