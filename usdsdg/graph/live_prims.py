"""Prims that are searched or drawn anew at each execution, as `rep.get` finds them with `cache_result=False`.

A search is plain data, so that a saved graph has it: the name of a function that `search` registers, and its arguments.
What is drawn is a `Drawn`, and in a saved graph a search by a function that gets the number of the execution, too.
"""

from __future__ import annotations

import importlib
import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

Search = Callable[..., tuple[str, ...]]

_SEARCHES: dict[str, Search] = {}
_BY_EXECUTION: set[str] = set()


def search(kind: str, *, by_execution: bool = False) -> Callable[[Search], Search]:
    """Register the function that finds paths for searches of type `kind`, by their keyword arguments.

    by_execution: it gets the number of the execution first.
    """

    def register(function: Search) -> Search:
        _SEARCHES[kind] = function
        _BY_EXECUTION.update([kind] if by_execution else [])
        return function

    return register


class Drawn(Protocol):
    """Prims that a distribution draws."""

    def paths(self, execution: int) -> tuple[str, ...]:
        """Return the prims of one execution."""
        ...

    def record(self) -> Mapping[str, Any]:
        """Return the search of a saved graph that draws the same."""
        ...


class LivePrims(tuple[str, ...]):
    """Paths as they were found last, with the parts by which they are found again: fixed paths, a search, or draws."""

    parts: tuple[Any, ...]
    execution: int

    def __new__(cls, parts: Sequence[Any], execution: int = 0) -> LivePrims:
        """Search, and keep how."""
        made = super().__new__(cls, (path for part in parts for path in _found(part, execution)))
        made.parts, made.execution = tuple(parts), execution
        return made

    def again(self, execution: int | None = None) -> LivePrims:
        """Return what is there now, for an execution; None: for the last one."""
        return LivePrims(self.parts, self.execution if execution is None else execution)

    def renamed(self, renamed: Callable[[str], str]) -> LivePrims:
        """Return these prims with `renamed` of each fixed path; searches stay as they are."""
        return LivePrims([renamed(part) if isinstance(part, str) else part for part in self.parts], self.execution)

    @property
    def depend_on_labels(self) -> bool:
        """Whether a search looks at labels."""
        searches = [part["arguments"] for part in self.parts if isinstance(part, Mapping)]
        return any(name.startswith("semantics") for arguments in searches for name in arguments)

    def text(self) -> str:
        """Return the parts as JSON."""
        return json.dumps(
            [part if isinstance(part, (str, Mapping)) else part.record() for part in self.parts], default=str
        )


def from_text(text: str) -> LivePrims:
    """Return the prims of `LivePrims.text`."""
    # The modules that register the searches of rep.get, and those that draw.
    for module in ("usdsdg.get", "usdsdg.distribution"):
        importlib.import_module(module)
    return LivePrims(json.loads(text))


def joined(groups: Sequence[tuple[str, ...]]) -> tuple[str, ...]:
    """Return the paths of all groups in order; they are searched anew if those of one are."""
    if any(isinstance(each, LivePrims) for each in groups):
        return LivePrims([p for each in groups for p in (each.parts if isinstance(each, LivePrims) else each)])
    return tuple(path for each in groups for path in each)


def _found(part: str | Mapping[str, Any] | Drawn, execution: int) -> tuple[str, ...]:
    if isinstance(part, str):
        return (part,)
    if not isinstance(part, Mapping):
        return part.paths(execution)
    found = _SEARCHES[part["kind"]]
    return found(execution, **part["arguments"]) if part["kind"] in _BY_EXECUTION else found(**part["arguments"])
