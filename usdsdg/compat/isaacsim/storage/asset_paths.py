"""Paths and URLs of assets as text; nothing is opened."""

from __future__ import annotations

import os
import posixpath
from collections.abc import Iterable
from urllib.parse import urlsplit

_SCHEMES = ("omniverse://", "file://", "http://", "https://")
_USD_SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")


def path_join(base: str, name: str) -> str:
    """Return a path or URL below another; below a URL, `./` and `../` at the beginning of the name are followed."""
    if not _is_url(base):
        return os.path.join(base, name)
    base, parts = base.rstrip("/"), name.replace("\\", "/").removeprefix("./").split("/")
    while parts[0] == ".." and len(parts) > 1:
        base, parts = base.rsplit("/", 1)[0], parts[1:]
    return "/".join([base, *parts])


def path_dirname(path: str) -> str:
    """Return the folder of a path or URL, with a separator at its end."""
    if _is_url(path):
        return f"{path.rsplit('/', 1)[0]}/"
    return os.path.join(os.path.dirname(os.path.normpath(path)), "")


def path_relative(path: str, start: str) -> str:
    """Return a path, or a URL, as seen from a folder.

    Raises:
        ValueError: `path` is a URL, and `start` is none of the same server.
    """
    if not _is_url(path):
        return os.path.relpath(path, start)
    whole, folder = urlsplit(path), urlsplit(start)
    if (whole.scheme, whole.netloc) != (folder.scheme, folder.netloc):
        raise ValueError(f"{path} and {start} are not on the same server")
    return posixpath.relpath(whole.path, folder.path or "/")


def is_absolute_path(path: str) -> bool:
    """Return whether a path begins at the root, or is a URL."""
    return not is_local_path(path) or os.path.isabs(path)


def is_local_path(path: str) -> bool:
    """Return whether a path is not a URL; one without text is local."""
    return not path.strip().lower().startswith(_SCHEMES)


def is_path_external(path: str, base_path: str) -> bool:
    """Return whether the text of a path does not hold that of a folder."""
    return base_path not in path


def is_valid_usd_file(item: str, excludes: Iterable[str]) -> bool:
    """Return whether a path ends as those of USD files do, and holds none of `excludes`."""
    return item.endswith(_USD_SUFFIXES) and not any(each in item for each in excludes)


def is_mdl_file(item: str) -> bool:
    """Return whether a path ends in .mdl."""
    return item.endswith(".mdl")


def _is_url(path: str) -> bool:
    return "://" in path
