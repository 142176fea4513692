"""Bounds on YAML and JSON text from strangers: size, nesting, keys, digits, and what aliases multiply to.

A file of 430 bytes can stand for billions of values. The text is read as a stream of events, which ends at the first
bound that is exceeded, before anything is built from it.
"""

import contextlib
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from usdsdg.errors import ConfigError
from usdsdg.stage.assets.file_checks import check_regular

MAX_BYTES = 1 << 20
MAX_DEPTH = 50  # of mappings and lists in each other
MAX_KEYS = 1000  # of one mapping
MAX_VALUES = 10_000  # of the file, with every alias written out
MAX_TEXT = 10_000  # characters of one value or key
MAX_DIGITS = 50  # of a number

# What YAML may take for a number: its conversion takes time that grows with the square of the length.
_NUMBER = re.compile(r"[-+]?[0-9.][0-9a-fA-FxXoO_.:eE+-]*")
# libyaml is ten times as fast, and not in every build of PyYAML. What it does not take, PyYAML's own parser may.
_PARSERS = (getattr(yaml, "CSafeLoader", yaml.SafeLoader), yaml.SafeLoader)


class TooLarge(ConfigError):
    """A configuration exceeds a bound; the message names the file, the line and the bound."""


def read_bounded(path: Path) -> str:
    """Return the UTF-8 text of a file that is within the bounds of `check_yaml`.

    A text that is not YAML at all is returned as it is: the parser that it is for reports what is wrong.

    Raises:
        TooLarge: it exceeds one of them.
        AssetUnreadable, OSError, UnicodeDecodeError: it cannot be read.
    """
    text = read_small(path)
    check_yaml(text, str(path))
    return text


def read_small(path: Path) -> str:
    """Return the UTF-8 text of a file of settings, without a mark of the byte order.

    Raises:
        AssetUnreadable: it is a device or a pipe, which may never end or never begin.
        TooLarge: it has more than `MAX_BYTES`.
        OSError, UnicodeDecodeError: it cannot be read.
    """
    check_regular(str(path))
    with path.open("rb") as file:
        data = file.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise TooLarge(f"{path} has more than {MAX_BYTES >> 20} MB, too much for a file of settings")
    # Editors of Windows begin files with a mark of their byte order, of which JSON knows nothing.
    return data.decode("utf-8-sig")


def check_yaml(text: str, name: str) -> None:
    """Check that YAML text is within the bounds; JSON is YAML as well, up to the first error of its syntax.

    Raises:
        TooLarge: it is not; `name` is what the message calls the text.
    """
    if len(text) > MAX_BYTES:
        raise TooLarge(f"{name} has more than {MAX_BYTES >> 20} MB, too much for a file of settings")
    for parser in _PARSERS:
        with contextlib.suppress(yaml.YAMLError):
            _check_events(yaml.parse(text, Loader=parser), name)
            return


def load_json(text: str, name: str) -> Any:
    """Return the value of JSON text.

    Raises:
        TooLarge: it exceeds a bound of `check_yaml`.
        json.JSONDecodeError: it is not JSON.
    """

    def integer(digits: str) -> int:
        _check_digits(digits, name)
        return int(digits)

    try:
        value = json.loads(text, parse_int=integer)
    except RecursionError:
        raise TooLarge(f"{name}: its mappings and lists are nested too deeply to be read") from None
    _check_value(value, name)
    return value


@dataclass
class _Collection:
    """A mapping or list that is open: its values so far, its levels below, and the anchor that names it."""

    anchor: str | None
    is_mapping: bool
    children: int = 0  # of a mapping: keys and values
    values: int = 1  # with itself and with aliases written out
    depth: int = 1


def _check_events(events: Iterator[yaml.Event], name: str) -> None:
    open_ones: list[_Collection] = []
    anchors: dict[str, tuple[int, int]] = {}  # values and depth
    for event in events:
        where = f"{name}, line {event.start_mark.line + 1}"
        if isinstance(event, yaml.CollectionStartEvent):
            open_ones.append(_Collection(event.anchor, isinstance(event, yaml.MappingStartEvent)))
            if len(open_ones) > MAX_DEPTH:
                raise TooLarge(_nested(where))
            continue
        if isinstance(event, yaml.ScalarEvent):
            if event.implicit[0]:
                _check_digits(event.value, where)
            if len(event.value) > MAX_TEXT:
                raise TooLarge(f"{where}: a text of {len(event.value)} characters; at most {MAX_TEXT} are read")
            values, depth = 1, 0
            if event.anchor:
                anchors[event.anchor] = values, depth
        elif isinstance(event, yaml.AliasEvent):
            values, depth = anchors.get(event.anchor, (1, 0))
        elif isinstance(event, yaml.CollectionEndEvent):
            done = open_ones.pop()
            values, depth = done.values, done.depth
            if done.anchor:
                anchors[done.anchor] = values, depth
        else:
            continue
        if open_ones:
            _add(open_ones, values, depth, where)


def _add(open_ones: list[_Collection], values: int, depth: int, where: str) -> None:
    """Add a finished value to the innermost open collection."""
    inside = open_ones[-1]
    inside.children += 1
    inside.values += values
    inside.depth = max(inside.depth, depth + 1)
    if len(open_ones) + depth > MAX_DEPTH:
        raise TooLarge(_nested(where))
    if inside.is_mapping and inside.children > 2 * MAX_KEYS:
        raise TooLarge(f"{where}: a mapping has more than {MAX_KEYS} keys")
    if sum(each.values for each in open_ones) > MAX_VALUES:
        raise TooLarge(f"{where}: there are more than {MAX_VALUES} values in the file, with its aliases written out")


def _check_value(value: Any, name: str) -> None:
    """Check the depth and the keys of what JSON text stands for; its size bounds the number of values."""
    level = [value]
    for _ in range(MAX_DEPTH + 1):
        if not level:
            return
        if any(isinstance(each, dict) and len(each) > MAX_KEYS for each in level):
            raise TooLarge(f"{name}: a mapping has more than {MAX_KEYS} keys")
        level = [
            below
            for each in level
            if isinstance(each, (dict, list))
            for below in (each.values() if isinstance(each, dict) else each)
        ]
    raise TooLarge(_nested(name))


def _nested(where: str) -> str:
    return f"{where}: mappings and lists are nested too deeply, more than {MAX_DEPTH} in each other"


def _check_digits(text: str, where: str) -> None:
    if len(text) > MAX_DIGITS and _NUMBER.fullmatch(text):
        raise TooLarge(f"{where}: a number of {len(text)} digits; at most {MAX_DIGITS} are read")
