"""Names that stand in records for the folders of assets, which are elsewhere on every machine.

`<assets>/Isaac/Props/box.usd` is below the assets root, whichever that is.
"""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any

from usdsdg import errors
from usdsdg.stage.assets import root
from usdsdg.stage.assets.cache_folder import cache_folder

ASSETS = "<assets>"  # the assets root
CACHE = "<cache>"  # the user's cache folder: demo parts, stand-ins, converted meshes, by their content
HERE = "<here>"  # the working folder of a run that has named files from there
HOME = "<home>"  # the home of a user who has named files with ~
NAMES = (ASSETS, CACHE, HERE, HOME)

# Folders from which files were named, so that what is named from there is elsewhere on another machine; the file that
# a script names by an absolute path is there on each.
_named_from: dict[str, str] = {}


def _same(value: Any) -> Any:
    return value


def note_working_folder() -> None:
    """Note that a file was named by a path from the working folder."""
    _named_from[os.getcwd()] = HERE


def note_home() -> None:
    """Note that a file was named by a path that begins with ~."""
    _named_from.setdefault(os.path.abspath(os.path.expanduser("~")), HOME)


def forget_named() -> None:
    """Forget from where files were named, as in a new process."""
    _named_from.clear()


def forget_left_folders() -> None:
    """Forget folders that are not the working folder any more: for another dataset they are folders as others.

    The working folder stays, from which files of the next stage may have been named before that is there.
    """
    here = ""
    with contextlib.suppress(OSError):  # it was removed
        here = os.getcwd()
    for folder in [folder for folder, name in _named_from.items() if name == HERE and folder != here]:
        del _named_from[folder]


def portable(text: str) -> str:
    """Return a path, or a text with paths such as that of a layer, with names in place of folders of this machine."""
    if "/" not in text and "\\" not in text:  # most arguments of writers: the folders are not looked up for them
        return text
    for folder, name in _folders(text):
        text = _replaced(text, folder, name)
    return text


def portable_below_root(text: str) -> str:
    """Return a text with the name of the assets root, where one was given, in place of that; it does so at any time."""
    if root.configured_root() is None:
        return text
    for folder in _forms(_assets_root()):
        text = _replaced(text, folder, ASSETS)
    return text


def portable_value(value: Any, *, key: Callable[[Any], Any] = _same, other: Callable[[Any], Any] = _same) -> Any:
    """Return a value in which all texts and paths, also those in lists, tuples and mappings, are `portable`.

    key: gives the keys of mappings. other: gives what is neither a text, a path nor one of these.
    """
    if isinstance(value, (str, os.PathLike)):
        return portable(str(os.fspath(value)))
    if isinstance(value, Mapping):
        return {key(name): portable_value(each, key=key, other=other) for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [portable_value(each, key=key, other=other) for each in value]
    return other(value)


def is_portable(path: str) -> bool:
    """Return whether a path begins with the name of a folder."""
    return path.startswith(NAMES)


def candidates(path: str, folders: Sequence[str]) -> list[str]:
    """Return where the file of a portable path may be on this machine, most likely first; it may not be there.

    folders: in which a run may have been that named it from its working folder, after the one of this process.
    """
    name, rest = re.split(r"(?<=>)", path, maxsplit=1)
    found = {
        ASSETS: lambda: [_assets_root()],
        CACHE: lambda: [_cache()],
        HERE: lambda: [os.getcwd(), *folders],
        HOME: lambda: [os.path.expanduser("~")],
    }[name]()
    return [f"{folder.rstrip('/')}{rest}" for folder in found if folder]


def _folders(text: str) -> Iterator[tuple[str, str]]:
    """Yield the folders that have names, in the forms in which a text may have them, the innermost first."""
    found = dict(_named_from)
    found[_cache()] = CACHE
    if here := assets_root_of(text):
        found[here] = ASSETS
    forms = {form: name for folder, name in found.items() for form in _forms(folder)}
    yield from sorted(forms.items(), key=lambda item: -len(item[0]))


def assets_root_of(text: str) -> str:
    """Return the assets root that a path, or a text with paths, may name; "" where it cannot name one.

    Demo assets are made where the root is asked for: not for a text that cannot name them.
    """
    may_name = root.configured_root() is not None or any(form in text for form in _forms(_cache()))
    return _assets_root() if may_name else ""


def _cache() -> str:
    """Return the user's cache folder; "" where there is none."""
    with contextlib.suppress(errors.AssetError):
        return os.path.abspath(cache_folder())
    return ""


def _assets_root() -> str:
    """Return the assets root; "" where there is none."""
    with contextlib.suppress(errors.AssetError, errors.Unsupported):
        return root.assets_root(announce=False)
    return ""


@lru_cache(maxsize=64)
def _forms(folder: str) -> tuple[str, ...]:
    """Return how a text may have a folder: with its links resolved, and on Windows with other or doubled slashes."""
    if not folder or os.path.dirname(folder) == folder:
        return ()  # a whole disk is no anchor
    places = (folder, os.path.realpath(folder))
    return tuple(
        dict.fromkeys(form for each in places for form in (each, each.replace("\\", "/"), each.replace("\\", "\\\\")))
    )


def _replaced(text: str, folder: str, name: str) -> str:
    """Return a text with a name in place of a folder; where the folder is but a part of a longer name it stays."""
    if folder not in text:
        return text
    return re.sub(rf"""(?<![\w./\\-]){re.escape(folder)}(?=[/\\"'@\s,)\]]|$)""", lambda _: name, text)
