"""The files of textures, light profiles and materials that scenes of this process use, for the recipe of a dataset."""

from __future__ import annotations

import itertools
import threading

from pxr import Ar

_lock = threading.Lock()  # pictures are decoded on several threads
_notes = itertools.count(1)
_files: dict[str, int] = {}  # by file: the number of the last note


def note_opened(path: str) -> None:
    """Note that a file is read, or would be if it were not in a cache; one in a package stands for its package."""
    file = Ar.SplitPackageRelativePathOuter(path)[0] if "[" in path else path
    with _lock:
        _files.pop(file, None)
        _files[file] = next(_notes)


def forget_opened(path: str) -> None:
    """Undo what was noted of a file."""
    with _lock:
        _files.pop(path, None)


def last_note() -> int:
    """Return the number of the last note; 0 if there is none."""
    with _lock:
        return next(reversed(_files.values()), 0)


def opened_since(note: int) -> list[str]:
    """Return the files that were noted after a note, those noted longest ago first."""
    with _lock:
        later = itertools.takewhile(lambda item: item[1] > note, reversed(_files.items()))
        return [file for file, _ in later][::-1]
