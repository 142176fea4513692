"""Folders that Python code of this process has copied, as `shutil.move` does to another disk."""

from __future__ import annotations

import os
import sys
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any

_MOST = 1000
_copies: deque[tuple[Path, Path]] = deque(maxlen=_MOST)  # real paths of folders and of their copies, the latest first
_is_watched = False


def watch() -> None:
    """Note which folders are copied from now on."""
    global _is_watched
    if not _is_watched:
        sys.addaudithook(_note)
        _is_watched = True


def copies_of(folder: Path) -> Iterator[Path]:
    """Yield the places of the copies of a folder, and of what it is in, the latest first; they need not be there."""
    for source, copy in tuple(_copies):
        if folder.is_relative_to(source):
            yield copy / folder.relative_to(source)


def _note(event: str, arguments: tuple[Any, ...]) -> None:
    if event == "shutil.copytree":
        source, copy = (Path(os.path.realpath(os.fsdecode(each))) for each in arguments[:2])
        _copies.appendleft((source, copy))
