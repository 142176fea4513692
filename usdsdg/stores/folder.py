"""Stores in local folders. Conditional puts hold between processes, also of several machines that share the folder."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from usdsdg.errors import StoreError
from usdsdg.stores.locks import locked_file
from usdsdg.stores.paths import path_below
from usdsdg.stores.store import Entry
from usdsdg.stores.whole_file import PART, not_writable, write_new, write_whole


class FolderStore:
    """A folder as a `Store`; it is made when the first file is put."""

    def __init__(self, folder: str | os.PathLike) -> None:
        self._folder = Path(os.path.abspath(os.path.expanduser(folder)))
        self.url = str(self._folder)

    def get(self, path: str) -> bytes:
        """Return the content of a file; see `Store`."""
        file = self._file(path)
        try:
            return file.read_bytes()
        except FileNotFoundError:
            raise
        except OSError as error:
            raise StoreError(f"{file} cannot be read: {error.strerror or error}.") from error

    def get_entry(self, path: str) -> Entry:
        """Return the content of a file with its etag; see `Store`."""
        data = self.get(path)
        return Entry(data, _etag(data))

    def size(self, path: str) -> int | None:
        """Return the size of a file; see `Store`."""
        file = self._file(path)
        return file.stat().st_size if file.is_file() else None

    def put(self, path: str, data: bytes | Iterable[bytes | memoryview]) -> None:
        """Store a file; see `Store`."""
        write_whole(self._file(path), data, durable=True)

    def put_if_absent(self, path: str, data: bytes) -> bool:
        """Store a file unless one is there; see `Store`."""
        return write_new(self._file(path), data)

    def put_if_match(self, path: str, data: bytes, etag: str) -> bool:
        """Replace a file if it has this etag; see `Store`."""
        file = self._file(path)
        try:
            with locked_file(file):
                if _etag(file.read_bytes()) != etag:
                    return False
                write_whole(file, data, durable=True)
                return True
        except FileNotFoundError:
            return False

    def delete(self, path: str) -> None:
        """Remove a file; see `Store`."""
        file = self._file(path)
        try:
            with locked_file(file):
                file.unlink()
        except FileNotFoundError:
            return
        except OSError as error:
            raise not_writable(file, error) from error

    def list(self, prefix: str = "") -> Iterator[tuple[str, int]]:
        """Go over all files below a folder of the store; see `Store`. Links to folders are not followed."""
        top = self._file(prefix) if prefix.strip("/") else self._folder
        for folder, folders, names in os.walk(top):
            folders.sort()
            for name in sorted(names):
                file = Path(folder, name)
                if not PART.fullmatch(name) and file.is_file():
                    yield file.relative_to(self._folder).as_posix(), file.stat().st_size

    def _file(self, path: str) -> Path:
        return path_below(self._folder, path)


def _etag(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
