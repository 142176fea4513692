"""Locks between processes and threads: one file each. The system drops a lock where its process ends."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def locked(file: Path) -> Iterator[None]:
    """Hold the lock of a file, which is made, while the body runs; others wait."""
    file.parent.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(file, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        _lock(descriptor)
        yield
    finally:
        os.close(descriptor)


@contextmanager
def locked_file(file: Path) -> Iterator[None]:
    """Hold the lock of a file that exists while the body runs, which may replace or remove it.

    Raises:
        FileNotFoundError: there is no such file, or none any more.
    """
    if sys.platform == "win32":
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
            _lock(descriptor)
            # While this process waited, the file may have been replaced by another, which has a lock of its own.
            if os.path.samestat(os.fstat(descriptor), os.stat(file)):
                yield
                return
        finally:
            os.close(descriptor)


def _lock(descriptor: int) -> None:
    if sys.platform == "win32":
        import msvcrt

        msvcrt.locking(descriptor, msvcrt.LK_LOCK, 1)
    else:
        import fcntl

        fcntl.flock(descriptor, fcntl.LOCK_EX)
