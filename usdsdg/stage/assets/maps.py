"""Maps from prefixes of asset URLs to folders: where the files of another machine are on this one."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import NamedTuple
from urllib.parse import unquote

from usdsdg.errors import ConfigError
from usdsdg.stage.assets import url


class PathMap(NamedTuple):
    """A prefix of URLs or paths, as scripts write it, and the folder that stands for it here."""

    prefix: str
    folder: str

    @classmethod
    def parse(cls, text: str) -> PathMap:
        """Parse `PREFIX=FOLDER`.

        Raises:
            ConfigError: there is no `=`, the prefix is empty, or the folder does not exist.
        """
        prefix, equals, folder = text.partition("=")
        if not (equals and prefix.strip() and folder.strip()):
            raise ConfigError(
                f"{text!r} is no map: expected PREFIX=FOLDER, as in omniverse://localhost/Projects=assets"
            )
        return cls.checked(prefix, folder)

    @classmethod
    def checked(cls, prefix: str, folder: str | os.PathLike[str]) -> PathMap:
        """Return the map of `prefix` to `folder`.

        Raises:
            ConfigError: there is no such folder.
        """
        here = os.path.abspath(os.path.expanduser(folder))
        if not os.path.isdir(here):
            raise ConfigError(f"{prefix} is mapped to {here}, which is not a folder")
        return cls(prefix.strip(), here)

    def rest_of(self, text: str) -> str | None:
        """Return what follows the prefix in a URL or path, without leading slash; None if it begins otherwise."""
        whole, prefix = url.normalized(text), url.normalized(self.prefix)
        if not prefix.endswith("/"):
            prefix += "/"
        return whole[len(prefix) :].lstrip("/") if whole.startswith(prefix) else None


_OPTION = "--map PREFIX=FOLDER"
_maps: tuple[PathMap, ...] = ()
_how_to_map = f"{_OPTION}, an option of usdsdg run, generate, render, simulate and view"


def set_maps(given: Iterable[PathMap]) -> None:
    """Set the maps of this process, as commands that have the option do; the longest prefix is tried first."""
    global _maps, _how_to_map
    _how_to_map = _OPTION
    _maps = tuple(sorted(given, key=lambda each: -len(url.normalized(each.prefix))))


def get_maps() -> tuple[PathMap, ...]:
    """Return the maps, longest prefix first."""
    return _maps


def how_to_map() -> str:
    """Return what a message says of how maps are given: which commands take them, unless one of them runs."""
    return _how_to_map


def candidates(text: str) -> list[str]:
    """Return the files that the maps make of a URL or path, whether they exist or not, best first."""
    found = []
    for each in _maps:
        rest = each.rest_of(text)
        if rest is not None:
            plain = rest.partition("?")[0] if url.scheme_of(text) else rest
            found += [os.path.join(each.folder, name) for name in dict.fromkeys((rest, unquote(plain)))]
    return found
