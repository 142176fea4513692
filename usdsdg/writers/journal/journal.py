"""The journal of a dataset: a line for every frame that is whole on disk, with the sizes and hashes of its files.

`.usdsdg/journal.jsonl` has, in the order of frames, {"frame": number, "files": {path: [size, sha256]}}, also with
"state" where a writer has one. While a run goes on, {"shared": {path: [size, sha256]}} tells of files that belong to
no frame, beside "facts" that the recipe gets in the end. `close` leaves one such line, the last one, with "frames", how
many there are, and "complete"; "lines", the SHA-256 of the lines before it, and "recipe", that of the recipe, tell
whether these are as the run wrote them. A run that goes on appends to it, until it is closed again.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from usdsdg.errors import WriterError
from usdsdg.stores.whole_file import not_writable, synced, write_whole
from usdsdg.writers.journal.facts import Facts, joined
from usdsdg.writers.journal.frames import FileFacts
from usdsdg.writers.journal.lines import COMPLETE, FACTS, FRAME, FRAMES, LINES, RECIPE, SHARED, STATE, parsed
from usdsdg.writers.journal.place import JOURNAL

NAME = JOURNAL


@dataclass
class Contents:
    """What a journal tells, apart from the files of its frames."""

    frames: set[int] = field(default_factory=set)
    states: dict[str, Any] = field(default_factory=dict)  # of the writers after the last frame, by their names
    shared: dict[str, FileFacts] = field(default_factory=dict)
    facts: Facts = field(default_factory=dict)
    is_complete: bool = False
    size: int = 0  # bytes up to the end of the last whole line

    @property
    def first_missing(self) -> int:
        """The first frame that is not whole."""
        return next(number for number in range(len(self.frames) + 1) if number not in self.frames)


class Journal:
    """Appends to the journal in one folder."""

    def __init__(self, path: Path) -> None:
        """path: of the journal, of which a line is dropped that a dying process has left unfinished."""
        self.path = path
        self.contents = read(path) if path.exists() else Contents()
        if path.exists() and path.stat().st_size > self.contents.size:
            os.truncate(path, self.contents.size)
        self.was_complete, self.contents.is_complete = self.contents.is_complete, False
        self._appended = 0  # frames, beside those of the contents

    def append(
        self,
        frames: Iterable[Mapping[str, Any]],
        shared: Mapping[str, FileFacts],
        facts: Mapping[str, Mapping[str, Any]] | None = None,
    ) -> None:
        """Append lines of frames and shared files, and facts for the recipe, and wait until they are on the disk.

        Raises:
            OutputNotWritable: the disk is full, or the folder was removed.
        """
        of_all = {SHARED: dict(shared), **({FACTS: facts} if facts else {})}
        lines = [*([of_all] if shared or facts else []), *frames]
        self.contents.shared.update(shared)
        self.contents.facts = joined([self.contents.facts, facts or {}])
        self._appended += sum(FRAME in line for line in lines)
        try:
            with open(self.path, "ab") as file:
                start = file.tell()
                try:
                    file.write(b"".join(encoded(line) for line in lines))
                    synced(file)
                except BaseException:
                    os.truncate(self.path, start)
                    raise
        except OSError as error:
            raise not_writable(self.path, error) from error

    @property
    def count(self) -> int:
        """The number of frames."""
        return len(self.contents.frames) + self._appended

    def close(
        self, *, complete: bool, recipe: str | None = None, spools: Mapping[str, FileFacts] | None = None
    ) -> None:
        """Write the journal as it stays, with its closing line; errors are those of `append`.

        complete: all frames of the run, or of this part of it, are there.
        recipe: the SHA-256 of the recipe; None: of a part, which has none of its own.
        spools: what is kept for going on with aggregate files, by its path.
        """
        self.contents.shared.update(spools or {})
        frames = (line for line in lines(self.path) if FRAME in line) if self.path.exists() else ()
        closing = {SHARED: dict(sorted(self.contents.shared.items())), FRAMES: self.count, COMPLETE: complete}
        closing |= {FACTS: self.contents.facts} if self.contents.facts else {}
        closing |= {RECIPE: recipe} if recipe is not None else {}
        write_whole(self.path, _sealed(map(encoded, in_order(frames)), closing))


def _sealed(data: Iterable[bytes], closing: Mapping[str, Any]) -> Iterator[bytes]:
    """Yield lines, and a closing line with their SHA-256."""
    digest = hashlib.sha256()
    for line in data:
        digest.update(line)
        yield line
    yield encoded({**closing, LINES: digest.hexdigest()})


def read(path: Path) -> Contents:
    """Return what a journal tells; a last line that a dying process has left unfinished is not there.

    Raises:
        WriterError: another line is damaged.
    """
    found = Contents()
    for line, end in _placed(path):
        if FRAMES in line:
            found.is_complete = bool(line.get(COMPLETE))
            found.shared.update({name: tuple(facts) for name, facts in line[SHARED].items()})
            found.facts, found.size = joined([found.facts, line.get(FACTS, {})]), end
            continue
        found.is_complete, found.size = False, end  # of a run that went on after its closing line
        if FRAME in line:
            found.frames.add(line[FRAME])
            found.states.update(line.get(STATE, {}))
        found.shared.update({name: tuple(facts) for name, facts in line.get(SHARED, {}).items()})
        if FACTS in line:
            found.facts = joined([found.facts, line[FACTS]])
    return found


def lines(path: Path) -> Iterator[dict[str, Any]]:
    """Yield the lines of a journal; errors are those of `read`."""
    for line, _ in _placed(path):
        yield line


def _placed(path: Path) -> Iterator[tuple[dict[str, Any], int]]:
    """Yield each line with the byte at which it ends."""
    place = 0
    with open(path, "rb") as file:
        for data in file:
            line = parsed(data)
            if line is None:
                if file.read(1):
                    raise WriterError(
                        f"{path}: the line at byte {place} is damaged. `usdsdg verify` tells which files are whole; "
                        "--overwrite makes all of them again."
                    )
                return
            place += len(data)
            yield line, place


def encoded(line: Mapping[str, Any]) -> bytes:
    """Return a line of a journal."""
    return json.dumps(line, ensure_ascii=False, separators=(",", ":")).encode() + b"\n"


def in_order(frames: Iterable[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield the lines of frames, which are in their order.

    Raises:
        WriterError: they are not.
    """
    last = -1
    for line in frames:
        if line[FRAME] <= last:
            raise WriterError(f"the journal has frame {line[FRAME]} after frame {last}.")
        last = line[FRAME]
        yield line
