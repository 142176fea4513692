"""Something wrong in a file of a dataset."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from usdsdg.datasets.printable import printable


@dataclass(frozen=True)
class Fault:
    """Something wrong in one file: `what` in words, with what was expected and what was found instead."""

    file: str
    frame: str
    what: str
    expected: str = ""
    found: str = ""

    def line(self) -> str:
        """Return the fault as a line of text, whatever characters files and their values have."""
        compared = f": expected {self.expected or 'nothing'}, found {self.found or 'nothing'}"
        compared = compared if self.expected or self.found else ""
        where = "all frames" if self.frame == "all" else f"frame {self.frame}"
        return printable(f"{self.file}: {where}: {self.what}{compared}")


Faults = Iterator[Fault]
