"""Prims that are searched anew at each execution, as `rep.get` finds them with `cache_result=False`.

A search is plain data, so that a saved graph has it: the name of a function that `search` registers, and its arguments.
"""

from __future__ import annotations

import importlib
import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

Search = Callable[..., tuple[str, ...]]

_SEARCHES: dict[str, Search] = {}


def search(kind: str) -> Callable[[Search], Search]:
    """Register the function that finds paths for searches of type `kind`, by their keyword arguments."""

    def register(function: Search) -> Search:
        _SEARCHES[kind] = function
        return function

    return register


class LivePrims(tuple[str, ...]):
    """Paths as they were found last, with the parts by which they are found again: fixed paths, or a search."""

    parts: tuple[Any, ...]

    def __new__(cls, parts: Sequence[Any]) -> LivePrims:
        """Search, and keep how."""
        made = super().__new__(cls, (path for part in parts for path in _found(part)))
        made.parts = tuple(parts)
        return made

    def again(self) -> LivePrims:
        """Return what is there now."""
        return LivePrims(self.parts)

    def renamed(self, renamed: Callable[[str], str]) -> LivePrims:
        """Return these prims with `renamed` of each fixed path; searches stay as they are."""
        return LivePrims([renamed(part) if isinstance(part, str) else part for part in self.parts])

    @property
    def depend_on_labels(self) -> bool:
        """Whether a search looks at labels."""
        searches = [part["arguments"] for part in self.parts if not isinstance(part, str)]
        return any(name.startswith("semantics") for arguments in searches for name in arguments)

    def text(self) -> str:
        """Return the parts as JSON."""
        return json.dumps(self.parts, default=str)


def from_text(text: str) -> LivePrims:
    """Return the prims of `LivePrims.text`."""
    # The module that registers the searches of rep.get.
    importlib.import_module("usdsdg.get")
    return LivePrims(json.loads(text))


def joined(groups: Sequence[tuple[str, ...]]) -> tuple[str, ...]:
    """Return the paths of all groups in order; they are searched anew if those of one are."""
    if any(isinstance(each, LivePrims) for each in groups):
        return LivePrims([p for each in groups for p in (each.parts if isinstance(each, LivePrims) else each)])
    return tuple(path for each in groups for path in each)


def _found(part: str | Mapping[str, Any]) -> tuple[str, ...]:
    if isinstance(part, str):
        return (part,)
    return _SEARCHES[part["kind"]](**part["arguments"])
