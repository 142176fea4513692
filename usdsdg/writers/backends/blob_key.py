"""Keys of blobs: relative paths that stay below what a backend writes to."""

import os
import re
from pathlib import Path, PurePosixPath

from usdsdg.errors import WriterError

_DRIVE = re.compile(r"[A-Za-z]:")


def checked_key(path: str | os.PathLike, where: str) -> str:
    """Return the key that a path stands for: relative, with slashes, without empty parts and single dots.

    where: what the backend writes to, for the message.

    Raises:
        WriterError: the path is empty, absolute, has a part `..`, or a character that no file name has.
    """
    text = os.fspath(path)
    parts = [part for part in re.split(r"[/\\]" if os.sep == "\\" else "/", text) if part not in ("", ".")]
    if not parts or "\0" in text:
        raise WriterError(f"{text!r} is no name of a file below {where}.")
    if text.startswith(("/", "\\")) or (os.name == "nt" and _DRIVE.match(text)) or ".." in parts:
        raise WriterError(f"{text!r} would leave {where}; give a path below it, without '..'.")
    return str(PurePosixPath(*parts))


def path_below(folder: Path, path: str | os.PathLike) -> Path:
    """Return the path of a file below an absolute folder; an absolute path is accepted where it is below as well.

    The folder itself may be a symbolic link. Links below it must not lead out of it: a file is written where its name
    says, or not at all.

    Raises:
        WriterError: the path leaves the folder.
    """
    text = os.fspath(path)
    if os.path.isabs(text) and ".." not in Path(text).parts and Path(text).is_relative_to(folder):
        text = os.path.relpath(text, folder)
    file = folder / checked_key(text, str(folder))
    real, root = os.path.realpath(file.parent), os.path.realpath(folder)
    if os.path.commonpath([real, root]) != root:
        raise WriterError(
            f"{file.parent} is outside of {folder} by a symbolic link, and no file is written there. Remove the link, "
            f"or write to {real} with an output_dir of its own."
        )
    return file
