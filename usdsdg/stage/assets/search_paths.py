"""Folders in which relative paths of assets are looked for, next to the working folder and the assets root."""

import os
from urllib.parse import unquote, urlsplit

from pxr import Ar

from usdsdg.stage.assets import url

_folders: list[str] = []


def add_search_path(folder: str) -> None:
    """Look for relative paths in this folder too, also for those that stages refer to; the first one added wins."""
    if (path := _path(folder)) not in _folders:
        _folders.append(path)
        Ar.DefaultResolver.SetDefaultSearchPath(_folders)


def remove_search_path(folder: str) -> None:
    """Take a folder back that `add_search_path` has added."""
    if (path := _path(folder)) in _folders:
        _folders.remove(path)
        Ar.DefaultResolver.SetDefaultSearchPath(_folders)


def candidates(relative: str) -> list[str]:
    """Return where a relative path may be; nowhere for those that begin with `./` or `../`, as in USD."""
    first = relative.replace("\\", "/").partition("/")[0]
    return [] if first in (".", "..") else [os.path.join(folder, relative) for folder in _folders]


def _path(folder: str) -> str:
    return os.path.abspath(unquote(urlsplit(folder).path) if url.scheme_of(folder) == "file" else folder)
