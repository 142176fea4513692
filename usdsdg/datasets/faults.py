"""Something wrong in a file of a dataset."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass


@dataclass(frozen=True)
class Fault:
    """Something wrong in one file: `what` in words, with what was expected and what was found instead."""

    file: str
    frame: str
    what: str
    expected: str = ""
    found: str = ""

    def line(self) -> str:
        """Return the fault as a line of text."""
        compared = f": expected {self.expected}, found {self.found}" if self.expected or self.found else ""
        where = "all frames" if self.frame == "all" else f"frame {self.frame}"
        return f"{self.file}: {where}: {self.what}{compared}"


Faults = Iterator[Fault]
