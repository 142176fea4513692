"""What came of a repair, or would: lines to print, and values for JSON."""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from usdsdg.datasets.faults import Fault
from usdsdg.datasets.printable import printable
from usdsdg.errors import counted
from usdsdg.repair.plan import Plan
from usdsdg.repair.replaced import Repair
from usdsdg.stores.addresses import is_url

_SHOWN = 12  # frames of a line
FOREIGN = "; it is left, remove it if nothing needs it"
FAILED = (
    "; it is left as it is, since no journal tells which files it would have. Correct the writer, and make the dataset "
    "anew with --overwrite"
)


@dataclass
class Summary:
    """One dataset.

    Attributes:
        name: as the user gave it.
        is_dry: nothing was to be made.
        is_ended: its frames were made, or no one had to be.
    """

    name: str
    repair: Repair
    plan: Plan
    is_dry: bool = False
    is_ended: bool = False
    notes: list[str] = field(default_factory=list)

    @property
    def path(self) -> Path:
        """The folder of the dataset."""
        return self.repair.damage.folder

    @property
    def is_clean(self) -> bool:
        """Whether every file is as the run has written it."""
        damage = self.repair.damage
        return not (self.repair.left or damage.foreign or damage.listing.failed)

    def named(self, text: str) -> str:
        """Return a text with the URL of a dataset in place of the folder with a copy of it."""
        return text.replace(str(self.path), self.name) if is_url(self.name) else text

    def lines(self, most: int) -> Iterator[str]:
        """Yield what is damaged, or left so, at most so many of them, and what was done."""
        damage, shown = self.repair.damage, list(self._faults())
        yield from (fault.line() for fault in shown[:most])
        if 0 < most < len(shown):
            yield f"... and {len(shown) - most} more (--limit)"
        for note in dict.fromkeys(self.notes):
            yield printable(f"note: {note}")
        foreign = f", {len(damage.foreign)} that no run wrote" if damage.foreign else ""
        if self.is_dry:
            what = f"{counted(len(damage.files), 'damaged file')}{foreign}{self._made('would be made again')}"
        elif damage.files:
            what = f"{counted(len(self.repair.repaired), 'file')} repaired, {len(self.repair.left)} left{foreign}"
            what += self._made("made again") if self.is_ended else ""
        else:
            what = f"no file is damaged{foreign}"
        if failed := len(damage.listing.failed):
            what += f"; {counted(failed, 'frame')} at which a writer failed {'is' if failed == 1 else 'are'} left"
        yield printable(f"{self.name}: {what}")

    def values(self) -> dict[str, Any]:
        """Return everything as values for JSON."""
        return {
            "folder": self.name,
            "clean": self.is_clean,
            "dry_run": self.is_dry,
            "frames": "all" if self.plan.whole else sorted(self.plan.numbers),
            "of_records": sorted(self.plan.spools),
            "repaired": self.repair.repaired,
            "left": [{"file": each.file, "frame": each.frame, "what": each.what} for each in self._faults()],
            "notes": self.notes,
        }

    def _faults(self) -> Iterator[Fault]:
        damage = self.repair.damage
        for name, why in self.repair.left.items():
            fault = damage.files[name]
            yield fault if self.is_dry else Fault(name, fault.frame, why)
        for fault in damage.foreign:
            yield Fault(fault.file, fault.frame, f"{fault.what}{FOREIGN}")
        for fault in damage.listing.failed:
            yield Fault(fault.file, fault.frame, f"{fault.what}{FAILED}")

    def _made(self, how: str) -> str:
        """Return which frames and files are made, as the end of a line."""
        parts = []
        if self.plan.whole:
            parts.append(f"all frames {how}, for {self.plan.whole[0]}")
        elif self.plan.numbers:
            parts.append(f"{numbered(self.plan.numbers)} {how}")
        if spooled := [name for name in self.plan.spools if self.is_dry or name not in self.repair.left]:
            parts.append(f"{counted(len(spooled), 'file')} {how} of the records of labels beside the data")
        return "".join(f"; {part}" for part in parts)


def numbered(frames: Set[int]) -> str:
    """Return numbers of frames in words, with runs of them as 3-7."""
    ordered, runs = sorted(frames), []
    for number in ordered:
        if runs and number == runs[-1][1] + 1:
            runs[-1][1] = number
        else:
            runs.append([number, number])
    texts = [str(a) if a == b else f"{a}-{b}" for a, b in runs]
    more = f" and more, {len(ordered)} in all" if len(texts) > _SHOWN else ""
    return f"frame{'s' * (len(ordered) > 1)} {', '.join(texts[:_SHOWN])}{more}"
