"""Download of one file to the blobs: it goes on where it ended, and counts only when it is whole."""

from __future__ import annotations

import hashlib
import itertools
import json
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from usdsdg.errors import AssetUnreadable, warn_once
from usdsdg.mirror.records import Record
from usdsdg.mirror.store import RemoteError, RemoteStore
from usdsdg.stores.locks import locked
from usdsdg.stores.retries import retry_seconds

ATTEMPTS = 5  # at least
FIRST_ANSWER_SECONDS = 10.0
_WAIT_SECONDS = 0.1  # before the second attempt; doubled before each further one
_LONGEST_WAIT_SECONDS = 5.0
QUIET_SECONDS = 1.0  # without an answer that nobody is told of

_STAGES = {".usda": (b"#usda",), ".usdc": (b"PXR-USDC",), ".usdz": (b"PK",), ".usd": (b"#usda", b"PXR-USDC")}


class Blobs:
    """Contents by their hash, and the downloads that are under way; shared by all roots and processes."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def path_of(self, record: Record) -> Path:
        """Return the file of a content, whether it exists or not."""
        return self._folder / "blobs" / record.blob

    def has(self, record: Record) -> bool:
        """Whether a content is there in full length; `damage` tells whether it is right."""
        try:
            return self.path_of(record).stat().st_size == record.size
        except OSError:
            return False

    def damage(self, record: Record) -> str:
        """Return what is wrong with a content: missing, cut off, or other bytes; "" if nothing is."""
        if not self.path_of(record).exists():
            return "missing"
        if not self.has(record):
            return f"cut off: {self.path_of(record).stat().st_size} of {record.size} bytes"
        with self.path_of(record).open("rb") as file:
            return "" if hashlib.file_digest(file, "sha256").hexdigest() == record.sha256 else "other bytes"

    def drop(self, record: Record) -> None:
        """Remove a content."""
        self.path_of(record).unlink(missing_ok=True)

    @contextmanager
    def locked(self, store: RemoteStore, path: str) -> Iterator[None]:
        """Hold the lock of one remote file, so that one process downloads it while others wait."""
        with locked(self._folder / "locks" / _key(store, path)):
            yield

    def download(self, store: RemoteStore, path: str) -> Record | None:
        """Download a file, whose lock is held, and return its record; None if the store has no such file.

        Raises:
            RemoteError: the download failed again and again; what has come is kept for the next time.
            AssetUnreadable: the server sent something else than a USD file for one.
        """
        partial = _Partial(self._folder / "partial" / _key(store, path))
        start, pause = time.monotonic(), _WAIT_SECONDS
        for attempt in itertools.count(1):
            try:
                return self._keep(store, path, partial) if _complete(store, path, partial) else None
            except RemoteError as error:
                # Nobody waits long for a server that has never answered: its address may be wrong.
                patience = retry_seconds() if store.has_answered else min(retry_seconds(), FIRST_ANSWER_SECONDS)
                waited = time.monotonic() - start
                if not error.may_pass or (attempt >= ATTEMPTS and waited >= patience):
                    raise
                if waited > QUIET_SECONDS:
                    warn_once(f"{store.url} is asked again for up to {patience:.0f} s: {error}", key=store.url)
            time.sleep(pause)
            pause = min(2 * pause, _LONGEST_WAIT_SECONDS)
        raise AssertionError("the loop returns or raises")

    def _keep(self, store: RemoteStore, path: str, partial: _Partial) -> Record:
        _check_kind(store, path, partial)
        record = Record(path, partial.digest(), partial.size, partial.etag)
        blob = self.path_of(record)
        blob.parent.mkdir(parents=True, exist_ok=True)
        if self.has(record):
            partial.restart()  # another file has the same content
        else:
            partial.file.chmod(0o444)
            partial.file.replace(blob)
        partial.forget()
        return record


def _key(store: RemoteStore, path: str) -> str:
    return hashlib.sha256(f"{store.url}/{path}".encode()).hexdigest()[:32]


class _Partial:
    """A download that is under way: the bytes so far, and what they are part of."""

    def __init__(self, file: Path) -> None:
        self.file, self._note = file, file.with_suffix(".json")
        self.size, self.etag = -1, ""
        file.parent.mkdir(parents=True, exist_ok=True)
        try:
            self.size, self.etag = json.loads(self._note.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            self.restart()

    def restart(self) -> None:
        """Drop the bytes so far."""
        self.file.unlink(missing_ok=True)
        self.size, self.etag = -1, ""

    def begin(self, size: int, etag: str) -> None:
        """Note what the bytes will be part of."""
        self.size, self.etag = size, etag
        self._note.write_text(json.dumps([size, etag]), encoding="utf-8")

    def forget(self) -> None:
        """Remove the note."""
        self._note.unlink(missing_ok=True)

    def length(self) -> int:
        """Return the number of bytes so far."""
        return self.file.stat().st_size if self.file.exists() else 0

    def digest(self) -> str:
        """Return the SHA-256 of the bytes."""
        with self.file.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()


def _complete(store: RemoteStore, path: str, partial: _Partial) -> bool:
    """Bring the rest of a file; False if the store has no such file.

    Raises:
        RemoteError: the server failed, or sent fewer or more bytes than it said.
    """
    have = partial.length()
    # Without an ETag nothing tells whether the rest belongs to the same file.
    if have and not (partial.etag and have < partial.size):
        partial.restart()
        have = 0
    try:
        content = store.read(path, offset=have, etag=partial.etag)
    except RemoteError:
        if not have:
            raise
        partial.restart()  # it has changed, or the server gives no parts
        have, content = 0, store.read(path)
    if content is None:
        partial.restart()
        partial.forget()
        return False
    partial.begin(content.size, content.etag)
    with partial.file.open("ab" if have else "wb") as file:
        for chunk in content.chunks:
            file.write(chunk)
        file.flush()
        os.fsync(file.fileno())
    if partial.length() != content.size:
        raise RemoteError(f"{store.url}/{path} ended after {partial.length()} of {content.size} bytes")
    return True


def _check_kind(store: RemoteStore, path: str, partial: _Partial) -> None:
    """Check that a USD file begins as one: servers send pages of errors, or of log-ins, in place of files."""
    beginnings = _STAGES.get(Path(path).suffix.lower())
    with partial.file.open("rb") as file:
        head = file.read(16)
    if beginnings and not head.startswith(beginnings):
        partial.restart()
        raise AssetUnreadable(f"{store.url}/{path} is no USD file: it begins with {head!r}. Is the address right?")
