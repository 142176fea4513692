"""Datasets that a script must leave as they are, although it removes its output folder when it starts.

Many scripts begin with `shutil.rmtree` of the folder that they write to. That is right where they make all files, and
loses files where they are run again to check a dataset, to go on with it, or to make a part of it.
"""

from __future__ import annotations

import errno
import functools
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from usdsdg.operating_system import path_of_descriptor
from usdsdg.stage.semantics.semantic_classes import BESIDE

_RECIPE = os.path.join(BESIDE, "recipe.json")
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
# Events of Python's audit hooks: what is done, and the places of paths, each with that of its dir_fd, among the
# arguments.
_CHANGES: dict[str, tuple[str, tuple[tuple[int, int | None], ...]]] = {
    "os.remove": ("remove", ((0, 1),)),
    "os.rmdir": ("remove", ((0, 1),)),
    "os.rename": ("rename", ((0, 2), (1, 3))),
    "os.truncate": ("write to", ((0, None),)),
    "open": ("write to", ((0, None),)),
}

_read_only: list[str] = []  # real paths; audit hooks cannot be removed, so the one of this module looks here
_is_watched = False


@contextmanager
def read_only(folder: Path) -> Iterator[None]:
    """Let Python code of this process neither remove, rename nor write files in a folder.

    `shutil.rmtree` of it is left out, with a note; all else is a PermissionError. Libraries that are not Python, such
    as USD, and other processes are not held back.
    """
    global _is_watched
    if not _is_watched:
        sys.addaudithook(_refuse)
        _is_watched = True
    kept = os.path.realpath(folder)
    _read_only.append(kept)
    try:
        with _removal_left_out(lambda path: kept if _is_in(path, kept) or _is_in(kept, path) else None):
            yield
    finally:
        _read_only.remove(kept)


@contextmanager
def datasets_kept() -> Iterator[None]:
    """Leave out `shutil.rmtree` of folders that are or contain datasets, with a note."""
    with _removal_left_out(_dataset_in):
        yield


@contextmanager
def _removal_left_out(kept_in: Callable[[str], str | None]) -> Iterator[None]:
    """Leave out removal of folders; kept_in: returns what is kept of the folder with a real path, None: nothing."""
    remove = shutil.rmtree

    @functools.wraps(remove)
    def rmtree(path: Any, *args: Any, **kwargs: Any) -> None:
        real = _real(path, kwargs.get("dir_fd"), is_followed=True)
        kept = kept_in(real) if real is not None else None
        if kept is None:
            return remove(path, *args, **kwargs)
        return _say(f"the script's removal of {os.fsdecode(path)} is left out, since the dataset in {kept} is kept")

    shutil.rmtree = rmtree  # type: ignore[assignment]
    try:
        yield
    finally:
        shutil.rmtree = remove


def _refuse(event: str, arguments: tuple[Any, ...]) -> None:
    """Raise PermissionError where a folder that is read-only would be changed."""
    if not _read_only or event not in _CHANGES or (event == "open" and not (arguments[2] or 0) & _WRITING):
        return
    action, places = _CHANGES[event]
    for path, folder in places:
        descriptor = arguments[folder] if folder is not None else None
        real = _real(arguments[path], descriptor, is_followed=action == "write to")
        for kept in _read_only if real is not None else ():
            assert real is not None
            if _is_in(real, kept) or (event == "os.rename" and _is_in(kept, real)):
                _say(f"the script tries to {action} {real}, which is refused: the dataset in {kept} is kept")
                raise PermissionError(errno.EACCES, f"the dataset in {kept} is kept as it is", real)


def _dataset_in(path: str) -> str | None:
    """Return the folder of a dataset that is at a path or below; None: none is there."""
    return next((folder for folder, _, _ in os.walk(path) if os.path.isfile(os.path.join(folder, _RECIPE))), None)


def _is_in(path: str, folder: str) -> bool:
    return path == folder or path.startswith(folder.rstrip(os.sep) + os.sep)


def _real(path: Any, folder: Any, *, is_followed: bool) -> str | None:
    """Return the real path; None where it is not known.

    folder: descriptor of the folder that it is relative to; None or -1: the working directory. is_followed: whether a
    link is what it points to, rather than itself.
    """
    if not isinstance(path, str | bytes | os.PathLike):
        return None  # an open file
    text = os.fsdecode(path)
    if folder not in (None, -1):
        text = os.path.join(path_of_descriptor(folder), text)
    if is_followed:
        return os.path.realpath(text)
    head, tail = os.path.split(os.path.abspath(text))
    return os.path.join(os.path.realpath(head), tail)


_said: set[str] = set()


def _say(line: str) -> None:
    if line not in _said:
        _said.add(line)
        print(f"note: {line}", file=sys.stderr)


__all__ = ["datasets_kept", "read_only"]
