"""The data files that a script reads itself, such as its parameters, which decide a dataset as its modules do."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from types import FrameType
from typing import Any

from usdsdg.errors import OWN_FILES, is_script
from usdsdg.stage.assets.opened import forget_opened, note_opened
from usdsdg.stage.semantics.semantic_classes import BESIDE

_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_CODE = (".py", ".pyc", ".so", ".pyd")  # of modules, which are noted where they are imported
# Larger files, and those of scripts that have more of them, are not compared: hashes would take longer than frames.
LARGEST, MOST = 1 << 26, 1000


class DataFiles:
    """Notes the files that a script opens to read, below its folder or the one in which it was started.

    Left out are files that it has written itself, those of datasets, and hidden ones, as of tools and secrets.
    """

    def __init__(self) -> None:
        self._tops: tuple[str, ...] = ()
        self._written: set[str] = set()
        self._noted: set[str] = set()
        self._is_watching = False

    def watch(self, script: Path) -> None:
        """Begin anew, for a script that is about to run."""
        self._written, self._noted = set(), set()
        tops = (script.absolute().parent, script.resolve().parent, sys.modules["usdsdg"]._STARTED_IN)
        self._tops = tuple({os.path.join(each, "") for each in tops if each})  # "" where that folder was removed
        if not self._is_watching:
            self._is_watching = True
            sys.addaudithook(self._see)  # for as long as the process lives

    def _see(self, event: str, arguments: tuple[Any, ...]) -> None:
        if event != "open" or len(self._noted) >= MOST or not isinstance(arguments[0], (str, bytes)):
            return
        path = self._path(os.fsdecode(arguments[0]))
        if path is None or path in self._written or not _is_called_by_script(sys._getframe(1)):
            return
        if (arguments[2] or 0) & _WRITES:
            if not _is_of_dataset(path):
                self._written.add(path)
                forget_opened(path)  # a file that keeps a state for the next run
        elif path not in self._noted and not _is_of_dataset(path) and _is_small(path):
            self._noted.add(path)
            note_opened(path)

    def _path(self, path: str) -> str | None:
        """Return the absolute path of a file that may be one of data; None if it is none."""
        if path.endswith(_CODE) or not path.isprintable():  # the latter also where it is not of UTF-8
            return None
        try:
            path = os.path.abspath(path)
        except OSError:  # the working folder was removed
            return None
        for top in self._tops:
            if path.startswith(top):
                return None if f"{os.sep}." in path[len(top) - 1 :] else path
        return None


def _is_called_by_script(frame: FrameType | None) -> bool:
    """Return whether code of the script is nearer than code of the project, apart from libraries that it calls."""
    while frame is not None:
        name = frame.f_code.co_filename
        if name.startswith(OWN_FILES):
            return False
        if is_script(name):
            return True
        frame = frame.f_back
    return False


def _is_of_dataset(path: str) -> bool:
    while (folder := os.path.dirname(path)) != path:
        if os.path.isdir(os.path.join(folder, BESIDE)):
            return True
        path = folder
    return False


def _is_small(path: str) -> bool:
    try:
        return os.path.getsize(path) <= LARGEST
    except OSError:
        return False


data_files = DataFiles()
