"""Atomic writing of files, with errors that name the cause."""

import contextlib
import errno
import hashlib
import itertools
import os
import re
import shutil
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import IO

from usdsdg.errors import OutputNotWritable
from usdsdg.operating_system import lacks_inodes, name_if_free, process_name, sync_file, sync_file_system

# Names of files that are being written, and of locks beside files.
PART = re.compile(r"\..*\.(part|lock)")

_part_numbers = itertools.count()
_FOLDER_ATTEMPTS = 5
# Up to so many files are synced one by one.
_FEW = 8


def write_whole(path: Path | str, data: bytes | Iterable[bytes | memoryview], *, durable: bool = False) -> None:
    """Write a file, of bytes or of chunks, atomically: it appears with all its bytes or not at all.

    durable: also where the power fails right after the call.

    Raises:
        OutputNotWritable: it could not be written; no partial file is left behind.
    """
    with _part_of(path, data, durable) as part:
        os.replace(part, path)


def write_new(path: Path, data: bytes | Iterable[bytes | memoryview]) -> bool:
    """As `write_whole` and durable, unless the file is there already; return whether it was written.

    Of several processes that write it at once exactly one does.
    """
    if path.exists():
        return False
    with _part_of(path, data, durable=True) as part:
        try:
            return _named_if_free(part, path)
        finally:
            _remove(part)


@contextlib.contextmanager
def _part_of(path: Path | str, data: bytes | Iterable[bytes | memoryview], durable: bool) -> Iterator[str]:
    """Write a file under a temporary name, which the body gives its own name."""
    folder, name = os.path.split(path)
    part = os.path.join(folder, f".{name[:100]}.{_unique()}.part")
    try:
        try:
            _write(part, [data] if isinstance(data, bytes) else data)
            if durable:
                sync_file(Path(part))
            yield part
            if durable:
                sync_file(Path(path).parent)
        except BaseException:
            _remove(part)
            raise
    except OSError as error:
        raise not_writable(Path(path), error) from error


def _unique() -> str:
    return f"{process_name()}-{next(_part_numbers)}"


def _remove(part: str) -> None:
    with contextlib.suppress(OSError):
        os.unlink(part)


def write_whole_with_hash(path: Path | str, data: Iterable[bytes | memoryview]) -> tuple[int, str]:
    """As `write_whole`; return the file's size [bytes] and its SHA-256 as hexadecimal digits."""
    size, digest = 0, hashlib.sha256()

    def seen() -> Iterator[bytes | memoryview]:
        nonlocal size
        for chunk in data:
            size += memoryview(chunk).nbytes
            digest.update(chunk)
            yield chunk

    write_whole(path, seen())
    return size, digest.hexdigest()


def facts_of(path: Path, size: int | None = None) -> tuple[int, str]:
    """Return the size [bytes] of a file and its SHA-256 as hexadecimal digits; errors are those of `open`.

    size: of its beginning, where only that counts.
    """
    with open(path, "rb") as file:
        if size is not None:
            data = file.read(size)
            return len(data), hashlib.sha256(data).hexdigest()
        digest = hashlib.file_digest(file, "sha256")
        return file.tell(), digest.hexdigest()


def _write(part: str, chunks: Iterable[bytes | memoryview]) -> None:
    with _opened(part) as file:
        for chunk in chunks:
            file.write(chunk)


def _opened(part: str) -> IO[bytes]:
    """Open a new file; only where its folder is missing, make that first."""
    for _ in range(_FOLDER_ATTEMPTS):  # a process of another part may remove the folder while it is empty
        with contextlib.suppress(FileNotFoundError):
            return open(part, "wb")
        with contextlib.suppress(FileNotFoundError):
            os.makedirs(os.path.dirname(part) or ".", exist_ok=True)
    return open(part, "wb")


def synced(file: IO[bytes]) -> None:
    """Wait until what was written to an open file is on the disk."""
    file.flush()
    os.fsync(file.fileno())


def sync_all(paths: Iterable[Path]) -> None:
    """Wait until files that were written before, and their names in their folders, are on the disk.

    Raises:
        OutputNotWritable: one of them was removed, or the disk failed.
    """
    paths = list(paths)
    for path in paths:
        if not path.exists():
            raise not_writable(path, FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT)))
    try:
        # One call for many files: each sync of its own waits for the disk, some milliseconds.
        if len(paths) > _FEW and sync_file_system(paths[0].parent):
            return
        for path in (*paths, *dict.fromkeys(each.parent for each in paths)):
            sync_file(path)
    except OSError as error:
        raise not_writable(path, error) from error


def _named_if_free(part: str, path: Path) -> bool:
    """Give a part the name of a file unless that is taken; return whether it was free."""
    try:
        return name_if_free(Path(part), path)
    except OSError as error:
        if error.errno not in (errno.EPERM, errno.EOPNOTSUPP, errno.ENOSYS, errno.EMLINK):
            raise
        return _copied_if_free(part, path)


def _copied_if_free(part: str, path: Path) -> bool:
    """As `_named_if_free`, where the file system has no links: readers may see the file before its last byte."""
    try:
        with open(path, "xb") as file:
            file.write(Path(part).read_bytes())
            file.flush()
            os.fsync(file.fileno())
    except FileExistsError:
        return False
    return True


def check_writable(folder: Path) -> None:
    """Create a folder if needed and check that files can be created in it.

    Raises:
        OutputNotWritable: they cannot.
    """
    probe = folder / f".{_unique()}.part"
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
    errno.EMFILE: "this process may not have more files open",
}


def not_writable(path: Path, error: OSError, *, elsewhere: str = "choose another output_dir") -> OutputNotWritable:
    """Return the error, with cause and remedy, that an error of the system at a file is.

    elsewhere: what else the user can do than to make room or to give the right to write.
    """
    cause = reason = _REASONS.get(error.errno or 0, error.strerror or str(error))
    link = error.filename
    if error.errno in (errno.ENOENT, errno.EEXIST) and link and os.path.islink(link) and not os.path.exists(link):
        cause = reason = f"{link} is a link to {os.readlink(link)}, which is not there"
        elsewhere = f"remove the link, or {elsewhere}"
    if error.errno == errno.ENOSPC:
        with contextlib.suppress(OSError):
            free = shutil.disk_usage(path.parent).free
            if lacks_inodes(path.parent):
                cause = reason = "the disk takes no more files, of which `df -i` counts those that are left"
            reason += f" ({free / 1e6:.0f} MB free)"
        remedy = f"Free space or {elsewhere}; the files written so far are whole."
    elif error.errno == errno.EFBIG:
        remedy = "Raise the limit (ulimit -f); the files written so far are whole."
    elif error.errno == errno.EMFILE:
        remedy = (
            "Each folder that a run writes to keeps a file open until its end: raise the limit (ulimit -n), or write "
            "to fewer folders."
        )
    else:
        remedy = f"{elsewhere[0].upper()}{elsewhere[1:]}, or make this one writable."
    failure = OutputNotWritable(f"{path} cannot be written: {reason}. {remedy}")
    failure.cause = cause
    return failure
