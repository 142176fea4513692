"""Locks of files between processes, which end with the process that holds them, however it ends."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Any

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]


class Locked(OSError):
    """Another process holds the lock."""


class FileLock:
    """A lock of a file, which is created if it does not exist; with `shared` several processes may hold it at once."""

    def __init__(self, path: Path, *, shared: bool = False) -> None:
        """Take the lock.

        Raises:
            Locked: another process has it.
            OSError: the file cannot be opened.
        """
        self._path, self._descriptor = path, -1
        while self._descriptor < 0:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666)
            try:
                _lock(descriptor, shared=shared)
            except OSError as error:
                os.close(descriptor)
                raise Locked(str(path)) from error
            if _is_at(descriptor, path):
                self._descriptor = descriptor
            else:
                os.close(descriptor)  # the file was replaced before the lock was had

    def release(self) -> None:
        """Give the lock back; nothing happens the second time."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1


def _is_at(descriptor: int, path: Path) -> bool:
    with suppress(FileNotFoundError):
        return os.path.samestat(os.fstat(descriptor), os.stat(path))
    return False


def _lock(descriptor: int, *, shared: bool) -> None:
    if fcntl is not None:
        fcntl.flock(descriptor, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    elif not shared:
        # A byte far behind the end, so that the file can be read meanwhile.
        import msvcrt

        locking: Any = msvcrt
        os.lseek(descriptor, 1 << 40, os.SEEK_SET)
        locking.locking(descriptor, locking.LK_NBLCK, 1)
        os.lseek(descriptor, 0, os.SEEK_SET)
