"""Paths in a store: relative, with slashes, and never out of it."""

import os
import re
from pathlib import Path

from usdsdg.errors import OutputNotWritable
from usdsdg.operating_system import IS_WINDOWS

_DRIVE = re.compile(r"[A-Za-z]:")
_CONTROL = re.compile(r"[\x00-\x1f\x7f]")
# (folder, parent of a file) -> device and inode of the parent when it was found to be below the folder: resolving the
# symbolic links of a path takes longer than writing a small file, and making a `Path` of it a quarter of that.
_inside: dict[tuple[str, str], tuple[int, int]] = {}
_MOST_INSIDE = 10_000  # entries of it


def checked_path(path: str | os.PathLike, where: str) -> str:
    """Return a path as stores take it: relative, with slashes, without empty parts and single dots.

    where: what it is relative to, for the message. On Windows backslashes are slashes; elsewhere they are letters.

    Raises:
        OutputNotWritable: the path is empty, absolute, has a part `..` or a null character.
    """
    text = os.fspath(path)
    parts = [part for part in re.split(r"[/\\]" if os.sep == "\\" else "/", text) if part not in ("", ".")]
    if not parts or "\0" in text:
        raise OutputNotWritable(f"{text!r} is no name of a file below {where}.")
    if text.startswith(("/", "\\")) or (IS_WINDOWS and _DRIVE.match(text)) or ".." in parts:
        raise OutputNotWritable(f"{text!r} would leave {where}; give a path below it, without '..'.")
    return "/".join(parts)


def path_below(folder: Path, path: str | os.PathLike) -> Path:
    """Return the path of a file below an absolute folder; an absolute path is accepted where it is below as well.

    The folder itself may be a symbolic link. Links below it must not lead out of it: a file is written where its name
    says, or not at all.

    Raises:
        OutputNotWritable: the path leaves the folder.
    """
    return folder / name_below(str(folder), path)


def name_below(folder: str, path: str | os.PathLike) -> str:
    """Return `path_below` as it is relative to the folder, with slashes."""
    text = os.fspath(path)
    if os.path.isabs(text) and ".." not in Path(text).parts and Path(text).is_relative_to(folder):
        text = os.path.relpath(text, folder)
    name = checked_path(text, folder)
    place = os.path.dirname(os.path.join(folder, name))
    parent = _identity(place)
    if parent is None or _inside.get((folder, place)) != parent:
        _check_inside(folder, place)
        if parent is not None and len(_inside) < _MOST_INSIDE:
            _inside[folder, place] = parent
    return name


def _identity(folder: str) -> tuple[int, int] | None:
    """Return device and inode of a folder, links followed; None if there is no folder, or no inode numbers."""
    try:
        found = os.stat(folder)
    except OSError:
        return None
    return (found.st_dev, found.st_ino) if found.st_ino else None


def _check_inside(folder: str, parent: str) -> None:
    real, root = os.path.realpath(parent), os.path.realpath(folder)
    if os.path.commonpath([real, root]) != root:
        raise OutputNotWritable(
            f"{parent} is outside of {folder} by a symbolic link, and no file is written there. Remove the link, "
            f"or write to {real} as a folder of its own."
        )


def checked_key(path: str | os.PathLike, where: str) -> str:
    """As `checked_path`, for stores whose keys have no control characters.

    Raises:
        OutputNotWritable: as there, or the path has a control character.
    """
    key = checked_path(path, where)
    if _CONTROL.search(key):
        raise OutputNotWritable(f"{key!r} has a control character, which no key below {where} has; rename the file.")
    return key
