"""Syncing a whole file system, which only some systems can."""

import ctypes
import os
import sys
from functools import cache
from pathlib import Path
from typing import Any


def sync_file_system(folder: Path) -> bool:
    """Wait until all that was written to the file system of a folder is on the disk; False where that is not known.

    Raises:
        OSError: the disk failed.
    """
    syncfs = _syncfs()
    if syncfs is None:
        return False
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        if syncfs(descriptor):
            number = ctypes.get_errno()
            raise OSError(number, os.strerror(number))
    finally:
        os.close(descriptor)
    return True


@cache
def _syncfs() -> Any:
    """Return the call of Linux, which Python does not have; None on other systems."""
    if not sys.platform.startswith("linux"):
        return None
    return getattr(ctypes.CDLL(None, use_errno=True), "syncfs", None)
