"""Temporary folders, of which also processes that are killed leave none; and where they are made."""

from __future__ import annotations

import os
import platform
import shutil
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from usdsdg.errors import OutputNotWritable
from usdsdg.operating_system import hold_folder, removed_with

_PREFIX = "usdsdg-"


def temporary_root() -> str:
    """Return the folder in which temporary files are made.

    Raises:
        OutputNotWritable: none can be written to, as where the disk of the system is full, or all but the output
            folder is read-only.
    """
    try:
        return tempfile.gettempdir()
    except FileNotFoundError as error:
        raise OutputNotWritable(
            f"Temporary files are needed, and no folder for them can be written to: {error.strerror}. Free space "
            "there, or name another: export TMPDIR=FOLDER."
        ) from None


class TemporaryFolder:
    """A folder that is removed with this object, or at the end of a `with` block.

    A process that is killed leaves its folders; the next one on the same machine that needs a folder removes them. A
    lock tells them from those that are in use.

    Attributes:
        path: of the folder.
    """

    def __init__(self, kind: str) -> None:
        """Make it. kind: what its name begins with.

        Raises:
            OutputNotWritable: as `temporary_root`.
        """
        root = temporary_root()
        _remove_left(root)
        self.path, held = _made(kind, root)
        self.remove = removed_with(self, self.path, held)

    def __enter__(self) -> Path:
        return self.path

    def __exit__(self, *_: Any) -> None:
        self.remove()


def _made(kind: str, root: str) -> tuple[Path, int | None]:
    """Return a new folder, and the descriptor that holds it; None where folders cannot be locked."""
    while True:
        folder = Path(tempfile.mkdtemp(_suffix(), f"{_PREFIX}{kind}-", root))
        try:
            held = hold_folder(folder, wait=True)
        except FileNotFoundError:  # removed before it was locked, by a process that took it for one that was left
            continue
        except OSError:
            return folder, None
        if folder.is_dir():
            return folder, held
        os.close(held)


@cache
def _remove_left(root: str) -> None:
    """Remove what processes of this machine have left that were killed; looked for once in a process."""
    try:
        names = os.listdir(root)
    except PermissionError:  # files can be made there, but not listed
        return
    for name in names:
        if not (name.startswith(_PREFIX) and name.endswith(_suffix())):
            continue
        folder = Path(root, name)
        try:
            held = hold_folder(folder, wait=False)
        except OSError:
            continue  # in use, of another user, or on a file system that does not tell
        shutil.rmtree(folder, ignore_errors=True)
        os.close(held)


def _suffix() -> str:
    # Locks may hold on one machine only, where several see the root.
    return f".{platform.node()}"
