"""The sizes and hashes of the spools of a dataset, by which a spool is found that has lost lines since it was written.

Each aggregate has a file of records below `aggregates`, its spool, that is appended to as frames are made; see
`usdsdg.writers.spool`.
"""

from __future__ import annotations

import hashlib
import os
import threading
from collections.abc import Iterator, Mapping, Set
from pathlib import Path

from usdsdg.errors import WriterError
from usdsdg.stores.whole_file import facts_of
from usdsdg.writers.journal import lines
from usdsdg.writers.journal.frames import FileFacts
from usdsdg.writers.journal.places.place import JOURNAL

AGGREGATES, SUFFIX = "aggregates", ".jsonl"
ONCE = "samples"  # the folder of spools that are removed when the run is complete


class SpoolHashes:
    """The spools of a dataset, or of a part of one, by their paths below their folder.

    Threads may append to spools meanwhile.
    """

    def __init__(self, folder: Path) -> None:
        """folder: of the spools; it need not exist."""
        self.folder = folder
        self._written: dict[str, tuple[int, hashlib._Hash]] = {}  # bytes, and their SHA-256
        self._lock = threading.Lock()

    def add(self, spool: Path, data: bytes, *, begins: bool) -> None:
        """Tell what was appended to a spool; begins: it replaces what was there."""
        name = self._name(spool)
        with self._lock:
            size, digest = (0, hashlib.sha256()) if begins or name not in self._written else self._written[name]
            digest.update(data)
            self._written[name] = size + len(data), digest

    def facts(self) -> dict[str, FileFacts]:
        """Return the sizes and hashes of the spools as far as they were written until now."""
        with self._lock:
            return {name: (size, digest.hexdigest()) for name, (size, digest) in sorted(self._written.items())}

    def facts_of_files(self) -> dict[str, FileFacts]:
        """Return the sizes and hashes of the spools that are there; nothing may be appended meanwhile."""
        known = self.facts()
        return {name: known.get(name) or facts_of(self.folder / name) for name in sorted(map(self._name, self.files()))}

    def files(self) -> Iterator[Path]:
        """Yield the spools that are there."""
        return (each for each in self.folder.rglob(f"*{SUFFIX}") if each.is_file())

    def go_on(self, told: Mapping[str, FileFacts], frames: Set[int]) -> None:
        """Begin with the records that an earlier process has left of `frames`; `shorten` drops the others.

        told: how each spool began when that process told of it last. Nothing is known of spools that it lacks.

        Raises:
            WriterError: a spool does not begin so, or a frame is not whole though a later one is.
        """
        there = {self._name(each) for each in self.files()}
        for name in sorted(there | told.keys()):
            size, sha256 = told.get(name, (0, ""))
            if name not in there and size:
                raise _damaged(self.folder / name, "is missing")
            found = _Beginning(self.folder / name, size, frames) if name in there else None
            if found is not None and found.lost is not None:
                raise WriterError(
                    f"{self.folder.parent / JOURNAL} has lost the line of frame {found.lost}, after which there are "
                    "frames that are not made again. Put a copy of the journal back as it was, or begin again with "
                    "--overwrite."
                )
            if found is not None and size and found.told != sha256:
                raise _damaged(self.folder / name, "was changed after it was written, or has lost lines")
            self._written[name] = (found.size, found.digest) if found is not None else (0, hashlib.sha256())

    def shorten(self) -> None:
        """Cut off what `go_on` has not kept."""
        for path in self.files():
            size = self._written[self._name(path)][0]
            os.truncate(path, size) if size else path.unlink()

    def _name(self, spool: Path) -> str:
        return spool.relative_to(self.folder).as_posix()


class _Beginning:
    """The beginning of a spool that a run resumes.

    Attributes:
        size: bytes up to the first record of a frame that is not whole, or cut off.
        digest: SHA-256 of these.
        told: SHA-256 of as many bytes as were told of; "" where no line ends there.
        lost: a frame that is not whole though a later one is; None: there is none.
    """

    def __init__(self, path: Path, told: int, frames: Set[int]) -> None:
        self.size, self.digest, self.told = 0, hashlib.sha256(), ""
        self.lost: int | None = None
        digest, place, is_kept, dropped = hashlib.sha256(), 0, True, None
        with open(path, "rb") as file:
            for data in file:
                line = lines.parsed_record(data)
                number = line.get(lines.FRAME) if line is not None else None
                is_whole = lines.is_count(number) and number in frames
                place += len(data)
                digest.update(data)
                is_kept = is_kept and line is not None and (number is None or is_whole)
                if is_kept and is_whole:
                    self.size, self.digest = place, digest.copy()
                if place == told:
                    self.told = digest.hexdigest()
                if is_whole and dropped is not None:
                    self.lost = dropped
                    return
                if dropped is None and lines.is_count(number) and not is_whole:
                    dropped = number


def check_whole(folder: Path, told: Mapping[str, FileFacts]) -> None:
    """Check that the spools of a finished part are those that it has made.

    folder: of the spools, in that of the part. told: as in its journal.

    Raises:
        WriterError: one is missing or was changed.
    """
    remedy = f"remove the folder {folder.parent} and make that part again."
    for name, facts in told.items():
        found = facts_of(folder / name) if (folder / name).is_file() else None
        if facts[0] and found is None:
            raise _damaged(folder / name, "is missing", remedy)
        if facts[0] and found != facts:
            raise _damaged(folder / name, "was changed after it was written", remedy)


def _damaged(spool: Path, what: str, remedy: str = "begin again with --overwrite.") -> WriterError:
    return WriterError(
        f"{spool} {what}: it has the labels of frames that were made before, which are not made again. Put it back as "
        f"it was, or {remedy}"
    )
