"""How many frames the processes of a dataset have finished, as their journals tell."""

from __future__ import annotations

import time
from contextlib import suppress
from pathlib import Path

from usdsdg.errors import StoreError
from usdsdg.session.progress import FRAMES, report
from usdsdg.writers.journal.journal import NAME
from usdsdg.writers.journal.lines import FRAME
from usdsdg.writers.journal.places.place import PARTS, Place

SECONDS = 1.0
_LINE = f'{{"{FRAME}":'.encode()


class PartsProgress:
    """Reports the frames in the journals of the parts of a dataset."""

    def __init__(self, place: Place, frames: int) -> None:
        """frames: of the dataset."""
        self._place, self._frames = place, frames
        self._read: dict[Path, tuple[int, int]] = {}  # bytes and frames, by journal
        self._reported, self._told = time.monotonic(), 0

    def tick(self) -> None:
        """Report, if it is time."""
        if time.monotonic() - self._reported >= SECONDS:
            self._report()

    def end(self) -> None:
        """Report the frames that were made since."""
        if self._told < self._frames:
            self._report()

    def _report(self) -> None:
        self._reported = time.monotonic()
        with suppress(StoreError):  # which those who make the parts meet, too
            self._place.pull()
        for path in (self._place.path / PARTS).glob(f"*/{NAME}"):
            self._count(path)
        self._told = sum(count for _, count in self._read.values())
        report(FRAMES, self._told, self._frames)

    def _count(self, path: Path) -> None:
        place, count = self._read.get(path, (0, 0))
        with suppress(OSError), open(path, "rb") as file:
            if file.seek(0, 2) < place:
                place = count = 0  # it is written anew when it is closed
            file.seek(place)
            data = file.read()
            whole = data[: data.rfind(b"\n") + 1]
            count += sum(line.startswith(_LINE) for line in whole.splitlines())
            self._read[path] = place + len(whole), count
