"""Paths in a store: relative, with slashes, and never out of it."""

import os
import re

from usdsdg.errors import StoreError

_DRIVE = re.compile(r"[A-Za-z]:")
_CONTROL = re.compile(r"[\x00-\x1f\x7f]")


def checked_path(path: str | os.PathLike, where: str) -> str:
    """Return a path as stores take it: relative, with slashes, without empty parts and single dots.

    where: what it is relative to, for the message. On Windows backslashes are slashes; elsewhere they are letters.

    Raises:
        StoreError: the path is empty, absolute, has a part `..` or a null character.
    """
    text = os.fspath(path)
    parts = [part for part in re.split(r"[/\\]" if os.sep == "\\" else "/", text) if part not in ("", ".")]
    if not parts or "\0" in text:
        raise StoreError(f"{text!r} is no name of a file below {where}.")
    if text.startswith(("/", "\\")) or (os.name == "nt" and _DRIVE.match(text)) or ".." in parts:
        raise StoreError(f"{text!r} would leave {where}; give a path below it, without '..'.")
    return "/".join(parts)


def checked_key(path: str | os.PathLike, where: str) -> str:
    """As `checked_path`, for stores whose keys have no control characters.

    Raises:
        StoreError: as there, or the path has a control character.
    """
    key = checked_path(path, where)
    if _CONTROL.search(key):
        raise StoreError(f"{key!r} has a control character, which keys below {where} cannot have; rename the file.")
    return key
