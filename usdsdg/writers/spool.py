"""The spool: records of frames for the files that are about all of them, in a file beside the data, not in memory."""

from __future__ import annotations

import contextlib
import json
import os
import weakref
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from threading import Lock
from typing import Any

from usdsdg.errors import WriterError
from usdsdg.operating_system import BINARY
from usdsdg.session.session import current
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.stores.addresses import is_url
from usdsdg.stores.paths import path_below
from usdsdg.stores.temporary import TemporaryFolder
from usdsdg.stores.whole_file import not_writable
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.disk import DiskBackend
from usdsdg.writers.backends.group import BackendGroup
from usdsdg.writers.backends.store import StoreBackend
from usdsdg.writers.files import plain
from usdsdg.writers.journal.folders import DatasetFolder
from usdsdg.writers.journal.run import get_run
from usdsdg.writers.journal.spool_hashes import ONCE

FOLDER, SUFFIX = f"{BESIDE}/aggregates", ".jsonl"
FRAME, ABOUT, KIND = "frame", "about", "kind"
_APPEND = os.O_WRONLY | os.O_APPEND | BINARY
_AT_A_TIME = 1 << 18  # bytes that are read


class OpenFile:
    """A file that is read at any place by several threads, also after another one has replaced it."""

    def __init__(self, path: Path) -> None:
        self._descriptor, self._lock = os.open(path, os.O_RDONLY | BINARY), Lock()
        weakref.finalize(self, os.close, self._descriptor)

    def read(self, place: int, size: int) -> bytes:
        """Return up to `size` bytes from the byte `place` on."""
        with self._lock:
            os.lseek(self._descriptor, place, os.SEEK_SET)
            return os.read(self._descriptor, size)


@dataclass(frozen=True)
class Records:
    """The records of a spool up to a moment, in the order of the frames; they may be gone over several times.

    A record is a dictionary with "frame", the number of its frame, and what the writer has of it.
    """

    file: OpenFile | None  # None if there are no records
    size: int  # bytes that belong to it
    count: int
    about: dict[str, Any]  # what was said last of all frames
    keeps: object = None  # what keeps the file
    start: int = 0  # byte at which they begin

    def __iter__(self) -> Iterator[dict[str, Any]]:
        for _, text in self._lines():
            line = json.loads(text)
            if FRAME in line:
                yield line

    def ordered_by(self, key: str) -> Iterator[dict[str, Any]]:
        """Yield the records in the order of their values of `key`; of all of them only these are in memory."""
        parsed = ((place, len(text), json.loads(text)) for place, text in self._lines())
        places = sorted((line[key], place, size) for place, size, line in parsed if FRAME in line)
        for _, place, size in places:
            assert self.file is not None
            yield json.loads(self.file.read(place, size))

    def runs(self, begins: Callable[[dict[str, Any]], bool]) -> Iterator[Records]:
        """Yield the records in runs of one or more. begins: returns whether a record, not the first, begins a run."""
        start, count = self.start, 0
        for place, text in self._lines():
            line = json.loads(text)
            if FRAME not in line:
                continue
            if begins(line) and count:
                yield replace(self, start=start, size=place, count=count)
                start, count = place, 0
            count += 1
        if count:
            yield replace(self, start=start, count=count)

    def _lines(self) -> Iterator[tuple[int, bytes]]:
        """Yield each line with the byte at which it begins."""
        place, rest = self.start, b""
        while self.file is not None and (left := self.size - place - len(rest)) > 0:
            data = self.file.read(place + len(rest), min(left, _AT_A_TIME))
            if not data:
                return
            *lines, rest = (rest + data).split(b"\n")
            for line in lines:
                yield place, line
                place += len(line) + 1


class Spool:
    """Appends records of frames to `.usdsdg/aggregates/<name>.jsonl`; every append is in the file when it returns.

    A line is {"frame": number, ...} for a picture of a frame, or {"about": {...}} for what is true of all frames, of
    which the last one counts. The first append replaces the spool of an earlier run. For a bucket without a journal the
    file is a temporary one, which ends with this object and its records.
    """

    def __init__(self, backend: BaseBackend, name: str, kind: str = "", *, once: bool = False) -> None:
        """name: of the file, with slashes. kind: of what is made of it, for its first line.

        once: it is large, and removed when the run is complete; where no journal is kept, it is a temporary file.
        """
        self._backend, self._name, self._kind, self._once = backend, f"{ONCE}/{name}" if once else name, kind, once
        self._temporary: TemporaryFolder | None = None
        self._claimed: DatasetFolder | None = None
        self._size = self._count = 0
        self._about = "{}"

    @cached_property
    def path(self) -> Path:
        """The file. Its folder is claimed at the first use, since not every writer that is made writes something."""
        place = place_of(self._backend)
        self._claimed = claimed = None if place is None else get_run().claim(place)
        if claimed is None and (self._once or place is None or is_url(place)):
            self._temporary = TemporaryFolder("spool")
            place = str(self._temporary.path)
        folder = Path(place or "")
        path = path_below(folder / FOLDER if claimed is None else claimed.aggregates, f"{self._name}{SUFFIX}")
        if claimed is not None and claimed.goes_on and path.exists():
            # What an earlier process has left.
            records = read(path)
            self._size, self._count, self._about = records.size, records.count, json.dumps(records.about, default=plain)
        return path

    def append(self, frame: int, records: Mapping[str, Any]) -> None:
        """Append what a picture of a frame adds. frame: how many frames the writer has received before; where a
        journal is kept, the record has the number of the capture instead.

        Raises:
            OutputNotWritable: the file cannot be written, or was removed.
            WriterError: another writer has written to the file.
        """
        in_hand = current().io_queue.files_in_hand()
        self._write({FRAME: frame if in_hand is None else in_hand.number, **records})
        self._count += 1

    def note(self, about: Mapping[str, Any]) -> None:
        """Append what is true of all frames, if it has changed; errors are those of `append`."""
        text, _ = json.dumps(about, default=plain), self.path  # which may tell it already
        if text != self._about:
            self._write({ABOUT: about})
            self._about = text

    @property
    def size(self) -> int:
        """How many bytes have been appended."""
        return self._size

    @property
    def goes_on(self) -> bool:
        """Whether the journal of an earlier process is resumed, so that its records are here, too."""
        place = place_of(self._backend)
        claimed = get_run().claim(place) if place is not None else None
        return claimed is not None and claimed.goes_on

    @property
    def is_temporary(self) -> bool:
        """Whether no journal is kept, so that records need not last until the end of the run."""
        return self.path is not None and self._temporary is not None

    def so_far(self) -> Records:
        """Return what has been appended until now.

        Raises:
            OutputNotWritable: the file was removed.
        """
        try:
            file = OpenFile(self.path) if self._size else None
        except OSError as error:
            raise not_writable(self.path, error) from error
        return Records(file, self._size, self._count, json.loads(self._about), keeps=self._temporary)

    def _write(self, line: Mapping[str, Any]) -> None:
        path = self.path
        lines = [line] if self._size or not self._kind else [{KIND: self._kind}, line]
        data = b"".join(json.dumps(each, default=plain).encode() + b"\n" for each in lines)
        flags = _APPEND if self._size else _APPEND | os.O_CREAT
        try:
            if not self._size:
                path.parent.mkdir(parents=True, exist_ok=True)
                # A new file: another writer's records may still be read from the one that was here.
                path.unlink(missing_ok=True)
            descriptor = os.open(path, flags, 0o666)
            try:
                self._append(descriptor, data)
            finally:
                os.close(descriptor)
        except OSError as error:
            raise not_writable(path, error) from error
        if self._claimed is not None:
            self._claimed.spools.add(path, data, begins=not self._size)
        self._size += len(data)

    def _append(self, descriptor: int, data: bytes) -> None:
        if os.fstat(descriptor).st_size != self._size:
            raise WriterError(f"{self.path} is written to by another writer, too. Give each an output_dir of its own.")
        left = memoryview(data)
        try:
            while left:
                left = left[os.write(descriptor, left) :]
        except BaseException:
            # So that the next line does not continue this one.
            with contextlib.suppress(OSError):
                os.ftruncate(descriptor, self._size)
            raise


def kind_of(path: Path) -> str:
    """Return of which kind the files are that are made of a spool; "" if it does not tell."""
    with open(path, "rb") as file:
        line = _parsed(file.readline())
    return str((line or {}).get(KIND, ""))


def read(path: Path) -> Records:
    """Return the records of a spool that a process has left, which may have died while it wrote the last line.

    Raises:
        FileNotFoundError: there is none.
        WriterError: a line other than the last one is damaged.
    """
    size = count = 0
    about: dict[str, Any] = {}
    with open(path, "rb") as file:
        for data in file:
            line = _parsed(data)
            if line is None:
                if file.read(1):
                    raise WriterError(f"{path}: the line at byte {size} is damaged; labels from there on are lost.")
                break
            size, count = size + len(data), count + (FRAME in line)
            about = line.get(ABOUT, about)
    return Records(OpenFile(path), size, count, about)


def _parsed(data: bytes) -> dict[str, Any] | None:
    """Return a line, or None if it is none: without its end, or no JSON."""
    with contextlib.suppress(ValueError, RecursionError):
        line = json.loads(data) if data.endswith(b"\n") else None
        return line if isinstance(line, dict) else None
    return None


def place_of(backend: BaseBackend) -> str | None:
    """Return the folder or URL of the dataset that a backend writes, of a group the first of them; None without one."""
    if isinstance(backend, DiskBackend) or (isinstance(backend, StoreBackend) and backend.keeps_journal):
        return backend.output_dir
    if isinstance(backend, BackendGroup):
        return next((place for each in backend.backends if (place := place_of(each)) is not None), None)
    return None
