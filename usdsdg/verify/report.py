"""The result of a verification: faults, and how much was looked at."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from typing import Any

from usdsdg.datasets.faults import Fault
from usdsdg.datasets.printable import printable
from usdsdg.errors import counted
from usdsdg.verify.integrity import Integrity

REPAIR = "usdsdg repair makes files again that are missing or were changed, and leaves the others as they are"


@dataclass
class Report:
    """The result of a verification."""

    folder: str
    faults: list[Fault] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)  # what could not be checked, and why
    formats: Counter[str] = field(default_factory=Counter)  # images by format
    recorded: int = 0  # frames with a record
    rendered: int = 0  # frames that were rendered again
    compared: int = 0  # files that were compared with the journal
    reads_labels: bool = True  # whether images and labels are checked, too

    @property
    def is_clean(self) -> bool:
        """Whether no fault was found."""
        return not self.faults

    def add_integrity(self, found: Integrity | None) -> None:
        """Add the result of the comparison with the journal; None: there is no journal."""
        if found is not None:
            self.faults += found.faults
            self.notes += found.notes
            self.compared = found.compared
            if found.is_finished and any(fault.file in found.listed for fault in found.faults):
                self.notes.append(REPAIR)

    def lines(self, most: int) -> Iterator[str]:
        """Yield everything as lines that can be printed, of the faults at most so many."""
        yield from (fault.line() for fault in self.faults[:most])
        if len(self.faults) > most:
            yield f"... and {len(self.faults) - most} more (--limit)"
        for note in dict.fromkeys(self.notes):
            yield printable(f"note: {note}")
        yield printable(self.summary())

    def summary(self) -> str:
        """Return one line."""
        seen = ", ".join(f"{count} of {name}" for name, count in sorted(self.formats.items())) or "none"
        again = f", {self.rendered} rendered again" if self.rendered else ""
        files = f"; files: {self.compared}" if self.compared else ""
        labels = f"images: {seen}; recorded frames: {self.recorded}{again}"
        if not self.reads_labels:
            labels = "images and labels were not read"
        return f"{self.folder}: {counted(len(self.faults), 'fault')}{files}; {labels}"

    def values(self) -> dict[str, Any]:
        """Return everything as values for JSON."""
        return {
            "folder": self.folder,
            "clean": self.is_clean,
            "faults": [asdict(each) for each in self.faults],
            "notes": self.notes,
            "formats": dict(self.formats),
            "recorded": self.recorded,
            "rendered": self.rendered,
            "compared": self.compared,
        }
