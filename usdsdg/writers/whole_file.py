"""Atomic writing of files, with errors that name the cause."""

import contextlib
import errno
import itertools
import os
import shutil
from collections.abc import Iterable
from pathlib import Path

from usdsdg.errors import OutputNotWritable

_part_numbers = itertools.count()


def write_whole(path: Path, data: bytes | Iterable[bytes | memoryview]) -> None:
    """Write a file, of bytes or of chunks, atomically: it appears with all its bytes or not at all.

    Raises:
        OutputNotWritable: it could not be written; no partial file is left behind.
    """
    part = path.with_name(f".{path.name[:100]}.{os.getpid()}-{next(_part_numbers)}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            _write(part, [data] if isinstance(data, bytes) else data)
            part.replace(path)
        except BaseException:
            with contextlib.suppress(OSError):
                part.unlink()
            raise
    except OSError as error:
        raise not_writable(path, error) from error


def _write(part: Path, chunks: Iterable[bytes | memoryview]) -> None:
    with open(part, "wb") as file:
        for chunk in chunks:
            file.write(chunk)


def check_writable(folder: Path) -> None:
    """Create a folder if needed and check that files can be created in it.

    Raises:
        OutputNotWritable: they cannot.
    """
    probe = folder / f".{os.getpid()}-{next(_part_numbers)}.part"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise not_writable(folder, error) from error


_REASONS = {
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the disk quota is used up",
    errno.EFBIG: "the file would be larger than this process may write",
    errno.EACCES: "this user may not write there",
    errno.EPERM: "this user may not write there",
    errno.EROFS: "the file system is read-only",
    errno.ENOTDIR: "a part of the path is a file, not a folder",
    errno.EEXIST: "a file of that name is in the way",
    errno.ENOENT: "it or its folder was removed",
    errno.EISDIR: "a folder of that name is in the way",
}


def not_writable(path: Path, error: OSError) -> OutputNotWritable:
    """Return the error, with cause and remedy, that an error of the system at a file is."""
    reason = _REASONS.get(error.errno or 0, error.strerror or str(error))
    if error.errno == errno.ENOSPC:
        with contextlib.suppress(OSError):
            reason += f" ({shutil.disk_usage(path.parent).free / 1e6:.0f} MB free)"
        remedy = "Free space or choose another output_dir; the files written so far are whole."
    else:
        remedy = "Choose another output_dir, or make this one writable."
    return OutputNotWritable(f"{path} cannot be written: {reason}. {remedy}")
