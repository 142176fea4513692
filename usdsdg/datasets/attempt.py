"""Reading that goes on whatever a file holds: any error of it becomes a fault that names the file."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import TypeVar

from PIL import UnidentifiedImageError

from usdsdg.datasets.faults import Fault
from usdsdg.errors import UsdsdgError

T = TypeVar("T")
UNREADABLE, UNLIKE = "cannot be read", "is not as its format has it"
# What is no fault of a file, but of an option, a missing package or a place that does not answer.
_OF_OTHERS = (UsdsdgError, ImportError)
# What an error means whose own words are those of a program.
_SAID = {
    AttributeError: "a value is of another kind",
    MemoryError: "it is larger than the memory",
    RecursionError: "it is nested too deeply",
    StopIteration: "a part of it is missing",
    UnidentifiedImageError: "it is no picture of a format that is read",
}


def attempt(
    faults: list[Fault], file: str | Callable[[], str], frame: str, what: str, make: Callable[[], T]
) -> T | None:
    """Return what `make` makes of a file; None, and a fault, where it raises anything.

    Decoders of damaged files raise whatever they meet, of which no list is complete.

    file: which is named; a function is asked after the error. what: begins the fault.

    Raises:
        UsdsdgError, ImportError: no file is to blame.
    """
    try:
        return make()
    except _OF_OTHERS:
        raise
    except Exception as error:  # noqa: BLE001 - see above
        faults.append(fault_of(error, file if isinstance(file, str) else file(), frame, what))
        return None


def attempt_each(
    faults: list[Fault], file: str | Callable[[], str], frame: str, what: str, items: Iterator[T]
) -> Iterator[T]:
    """Yield what an iterator has, none of which is None; where that raises anything, a fault is the end of it."""
    while (item := attempt(faults, file, frame, what, lambda: next(items, None))) is not None:
        yield item


def fault_of(error: Exception, file: str, frame: str, what: str) -> Fault:
    """Return an error of reading a file as a fault."""
    if isinstance(error, (FileNotFoundError, NotADirectoryError)):
        return Fault(file, frame, "is missing")
    if isinstance(error, json.JSONDecodeError):
        return Fault(file, frame, f"is not valid JSON at line {error.lineno}: {error.msg}")
    return Fault(file, frame, f"{what}: {said(error)}")


def said(error: Exception) -> str:
    """Return what an error says, in one line."""
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    if isinstance(error, KeyError):
        return f"{error} is missing"
    known = next((text for kind, text in _SAID.items() if isinstance(error, kind)), None)
    return known or next((line for line in str(error).splitlines() if line.strip()), type(error).__name__)
