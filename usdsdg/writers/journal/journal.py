"""The journal of a dataset: a line for every frame that is whole on disk, with the sizes and hashes of its files.

`.usdsdg/journal.jsonl` has, in the order of frames, {"frame": number, "files": {path: [size, sha256]}}, also with
"state" where a writer has one, and with "failed", the error of a writer after which the script went on. Lines of
{"shared": {path: [size, sha256]}} tell of files that belong to no frame, also with "facts" that the recipe gets in the
end, and with "spools", how each spool begins, by its path below its folder. `close` leaves one such line, the first
one, and a closing line, the last one, with "frames", how many there are, and "complete"; of a part also "first", the
frame at which writers are due for the first time. "lines", the SHA-256 of the lines before it, and "recipe", that of
the recipe, tell whether these are as the run wrote them. A run that goes on appends to it, until it is closed again.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from io import RawIOBase
from itertools import chain
from pathlib import Path
from typing import Any

from usdsdg.errors import WriterError
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.stores.whole_file import not_writable, synced, write_whole
from usdsdg.writers.journal.facts import Facts, joined
from usdsdg.writers.journal.frames import FileFacts
from usdsdg.writers.journal.lines import (
    COMPLETE,
    FACTS,
    FAILED,
    FIRST,
    FRAME,
    FRAMES,
    LINES,
    RECIPE,
    SHARED,
    SPOOLS,
    STATE,
    parsed,
)
from usdsdg.writers.journal.places.place import JOURNAL
from usdsdg.writers.journal.spool_hashes import AGGREGATES

NAME = JOURNAL
_FRAME = b'{"frame":'  # how lines of frames begin
_SPOOLS = f"{BESIDE}/{AGGREGATES}/"


@dataclass
class Contents:
    """What a journal tells, apart from the files of its frames."""

    frames: set[int] = field(default_factory=set)
    failed: list[int] = field(default_factory=list)  # those at which a writer failed
    states: dict[str, Any] = field(default_factory=dict)  # of the writers after the last frame, by their names
    shared: dict[str, FileFacts] = field(default_factory=dict)
    facts: Facts = field(default_factory=dict)
    spools: dict[str, FileFacts] = field(default_factory=dict)  # how they begin, by their paths below their folder
    is_complete: bool = False
    first: int | None = None  # frame at which writers are due for the first time, as a part tells when it is closed
    size: int = 0  # bytes up to the end of the last whole line

    @property
    def end(self) -> int:
        """The frame after the last one: all before it at which writers were due are whole."""
        return max(self.frames, default=-1) + 1


class Journal:
    """Appends to the journal in one folder."""

    def __init__(self, path: Path) -> None:
        """path: of the journal, of which a line is dropped that a dying process has left unfinished."""
        self.path = path
        self.contents = read(path) if path.exists() else Contents()
        if path.exists() and path.stat().st_size > self.contents.size:
            os.truncate(path, self.contents.size)
        self.was_complete, self.contents.is_complete = self.contents.is_complete, False
        self._size = self.contents.size  # bytes of the file
        self._appended: set[int] = set()  # frames, beside those of the contents

    def append(
        self,
        frames: Iterable[Mapping[str, Any]],
        shared: Mapping[str, FileFacts],
        facts: Mapping[str, Mapping[str, Any]] | None = None,
        *,
        spools: Mapping[str, FileFacts] | None = None,
    ) -> None:
        """Append lines of frames and shared files, and facts for the recipe, and wait until they are on the disk.

        spools: how they begin; what is known already is left out.

        Raises:
            OutputNotWritable: the disk is full, or the folder was removed.
            WriterError: a frame is not made for the first time, so the journal that is resumed has lost its line; or
                another program has changed the journal.
        """
        known = self.contents.spools
        new = {name: each for name, each in (spools or {}).items() if known.get(name) != each}
        lines = [*_of_all(shared, facts, new), *frames]
        numbers = [line[FRAME] for line in lines if FRAME in line]
        if numbers and numbers[0] < max(self._appended, default=self.contents.end - 1):
            raise _damaged(self.path, f"it has lost the line of frame {numbers[0]}")
        self._check_unchanged()
        try:
            # Without a buffer, which would be written when the file is closed, also after it was cut off.
            with open(self.path, "ab", buffering=0) as file:
                start = file.tell()
                try:
                    _write_all(file, b"".join(encoded(line) for line in lines))
                    synced(file)
                    self._appended.update(numbers)
                    self._size = file.tell()
                except BaseException:
                    os.truncate(self.path, start)
                    self._appended.difference_update(numbers)
                    self._size = start
                    raise
        except OSError as error:
            raise not_writable(self.path, error) from error
        self.contents.shared.update(shared)
        self.contents.facts = joined([self.contents.facts, facts or {}])
        self.contents.spools.update(new)

    @property
    def count(self) -> int:
        """The number of frames."""
        return len(self.contents.frames) + len(self._appended)

    def has(self, frame: int) -> bool:
        """Return whether a frame is in it."""
        return frame in self.contents.frames or frame in self._appended

    def close(
        self,
        *,
        complete: bool,
        recipe: str | None = None,
        first: int | None = None,
        kept: Mapping[str, FileFacts] | None = None,
        spools: Mapping[str, FileFacts] | None = None,
    ) -> None:
        """Write the journal as it stays, with its closing line; errors are those of `append`.

        complete: all frames of the run, or of this part of it, are there.
        recipe: the SHA-256 of the recipe; None: of a part, which has none of its own.
        first: of a part, the frame at which writers are due for the first time; None: not known.
        kept: of the spools those that are files of the dataset, as in `spools`.
        spools: those that a run can resume.
        """
        self._check_unchanged()
        shared = {name: each for name, each in self.contents.shared.items() if not name.startswith(_SPOOLS)}
        shared |= {f"{_SPOOLS}{name}": each for name, each in (kept or {}).items()}
        frames = (line for line in lines(self.path) if FRAME in line) if self.path.exists() else ()
        # All that the closing line alone would tell can be told again by a run that goes on, if that line is damaged.
        told = map(encoded, _of_all(dict(sorted(shared.items())), self.contents.facts, spools or {}))
        closing: dict[str, Any] = {SHARED: {}, FRAMES: self.count, COMPLETE: complete}
        closing |= {RECIPE: recipe} if recipe is not None else {}
        closing |= {FIRST: first} if first is not None else {}
        write_whole(self.path, _sealed(chain(told, map(encoded, in_order(frames))), closing))

    def _check_unchanged(self) -> None:
        """Check that the file has all that was appended: what is there in its place would seem to be all of it."""
        try:
            size = self.path.stat().st_size
        except OSError as error:
            if self._size:
                raise not_writable(self.path, error) from error
            return
        if size != self._size:
            raise WriterError(
                f"{self.path} was changed by another program while the run wrote there: it has {size} bytes in place "
                f"of {self._size}. Make all frames again with --overwrite."
            )


def _write_all(file: RawIOBase, data: bytes) -> None:
    left = memoryview(data)
    while left:
        left = left[file.write(left) or 0 :]


def _of_all(
    shared: Mapping[str, FileFacts], facts: Mapping[str, Any] | None, spools: Mapping[str, FileFacts]
) -> list[dict[str, Any]]:
    """Return the line of what belongs to no frame; none if there is nothing."""
    line: dict[str, Any] = {SHARED: dict(shared)}
    line |= {FACTS: facts} if facts else {}
    line |= {SPOOLS: dict(spools)} if spools else {}
    return [line] if shared or len(line) > 1 else []


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
    is_closed_by_shared = False  # as earlier versions closed journals
    last, count = -1, 0  # frame, and how many
    for line, end in _placed(path):
        if is_closed_by_shared:  # what that version has then told of spools ended with the run that goes on here
            found.spools, is_closed_by_shared = {}, False
        found.is_complete, found.size = FRAMES in line and bool(line.get(COMPLETE)), end
        found.first = line.get(FIRST)
        if FRAME in line:
            if line[FRAME] <= last:
                raise _damaged(path, f"the line of frame {line[FRAME]} comes after that of frame {last}")
            last, count = line[FRAME], count + 1
            found.frames.add(last)
            found.failed += [last] * bool(line.get(FAILED))
            found.states.update(line.get(STATE, {}))
        elif line.get(FRAMES, count) != count:
            raise _damaged(path, f"it has the lines of {count} frames, and {line[FRAMES]} were written")
        found.shared.update(_files(line.get(SHARED, {})))
        found.spools.update(_files(line.get(SPOOLS, {})))
        if FACTS in line:
            found.facts = joined([found.facts, line[FACTS]])
        if FRAMES in line and line[SHARED]:
            is_closed_by_shared, shared = True, _files(line[SHARED])
            found.spools = {
                name.removeprefix(_SPOOLS): facts for name, facts in shared.items() if name.startswith(_SPOOLS)
            }
    _check_closing_line(path, found)
    return found


def _check_closing_line(path: Path, found: Contents) -> None:
    """Check that no closing line of an earlier version is cut off, which alone has what belongs to no frame."""
    if found.frames and not found.shared and not found.facts:
        with open(path, "rb") as file:
            file.seek(found.size)
            rest = file.read(len(_FRAME))
        if rest and rest != _FRAME[: len(rest)]:
            raise WriterError(
                f"{path}: its closing line is damaged, which alone has the files of all frames, the settings and the "
                "assets; --overwrite makes all frames again."
            )


def _files(values: Mapping[str, Any]) -> dict[str, FileFacts]:
    return {name: tuple(facts) for name, facts in values.items()}


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
                    raise _damaged(path, f"the line at byte {place} is damaged")
                return
            place += len(data)
            yield line, place


def _damaged(path: Path, what: str) -> WriterError:
    return WriterError(
        f"{path}: {what}. `usdsdg verify` tells which files are whole; put a copy of the journal back as it was, or "
        "make all of them again with --overwrite."
    )


def encoded(line: Mapping[str, Any]) -> bytes:
    """Return a line of a journal."""
    try:
        return json.dumps(line, ensure_ascii=False, separators=(",", ":")).encode() + b"\n"
    except UnicodeEncodeError:  # names of files may have bytes that are no UTF-8, which JSON has as escapes only
        return json.dumps(line, separators=(",", ":")).encode() + b"\n"


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
