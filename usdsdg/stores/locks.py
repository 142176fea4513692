"""Locks of files between processes and threads, which end with the process that holds them, however it ends."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from usdsdg.operating_system import BINARY, IS_WINDOWS, lock, may_open, path_of_descriptor

# What systems say of a lock that another process has.
_HELD = (errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES, errno.EDEADLK)
# Files that a process may have open beside its locks, each of which keeps one open: at least, and if that can be had.
_FEW, _MANY = 32, 256


class Locked(OSError):
    """Another process holds the lock."""


class FileLock:
    """A lock of a file, which is created if it does not exist; with `shared` several processes may hold it at once."""

    def __init__(self, path: Path, *, shared: bool = False, removed: bool = False) -> None:
        """Take the lock.

        removed: the file is removed once it is given back; that of a process that died stays, and locks nothing.

        Raises:
            Locked: another process has it.
            OSError: the file cannot be opened.
        """
        self._path, self._is_removed = path, removed
        self._descriptor = -1
        while self._descriptor < 0:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | BINARY, 0o666)
            try:
                if not stat.S_ISREG(os.fstat(descriptor).st_mode):  # such as a pipe, which may never end
                    raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path))
                # Descriptors are the lowest that are free.
                if not may_open(descriptor + _MANY) and not may_open(descriptor + _FEW):
                    raise OSError(errno.EMFILE, os.strerror(errno.EMFILE), str(path))
                lock(descriptor, shared=shared, wait=False)
            except OSError as error:
                os.close(descriptor)
                if error.errno not in _HELD:
                    raise  # such as a file system without locks
                raise Locked(str(path)) from error
            if _is_at(descriptor, path):
                self._descriptor = descriptor
            else:
                os.close(descriptor)  # the file was replaced before the lock was had

    def path_now(self) -> Path | None:
        """Return the path of the file where it, or a folder that it is in, was moved; None: it is not known."""
        path = Path(path_of_descriptor(self._descriptor))
        try:
            return path if self._descriptor >= 0 and _is_at(self._descriptor, path) else None
        except OSError:  # such as a folder that this user may not read
            return None

    def content(self) -> bytes:
        """Return what is in the file, also where it was removed; the lock is held."""
        with open(os.dup(self._descriptor), "rb") as file:
            file.seek(0)
            return file.read()

    def release(self) -> None:
        """Give the lock back; nothing happens the second time."""
        if self._descriptor >= 0:
            if self._is_removed and not IS_WINDOWS:  # while no other process can have it
                self._path.unlink(missing_ok=True)
            os.close(self._descriptor)
            self._descriptor = -1
            if self._is_removed and IS_WINDOWS:  # where an open file cannot be removed
                with suppress(OSError):
                    self._path.unlink()


@contextmanager
def locked(file: Path) -> Iterator[None]:
    """Hold the lock of a file, which is made, while the body runs; others wait."""
    file.parent.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(file, os.O_RDWR | os.O_CREAT | BINARY, 0o666)
    try:
        lock(descriptor)
        yield
    finally:
        os.close(descriptor)


@contextmanager
def locked_file(file: Path) -> Iterator[None]:
    """Hold the lock of a file that exists while the body runs, which may replace or remove it.

    Raises:
        FileNotFoundError: there is no such file, or none any more.
    """
    if IS_WINDOWS:
        # An open file cannot be replaced there, so a file beside it has the lock.
        beside = file.with_name(f".{file.name}.lock")
        file.stat()
        with locked(beside):
            file.stat()
            yield
        with suppress(OSError):  # another process has it open, and removes it
            beside.unlink()
        return
    while True:
        descriptor = os.open(file, os.O_RDWR)
        try:
            lock(descriptor)
            # While this process waited, the file may have been replaced by another, which has a lock of its own.
            if _is_at(descriptor, file, missing_ok=False):
                yield
                return
        finally:
            os.close(descriptor)


def _is_at(descriptor: int, path: Path, *, missing_ok: bool = True) -> bool:
    """Return whether a path names the file that is open."""
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(path))
    except FileNotFoundError:
        if missing_ok:
            return False
        raise
