"""The configuration file of commands with --map: maps that hold for every script, job and stage of a folder, or a user.

    [map]
    "omniverse://localhost/Projects" = "~/projects"
    "C:/assets" = "assets"

It is `usdsdg.toml` in the working folder or beside the script, job or stage, and `~/.config/usdsdg/config.toml`.
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Collection
from pathlib import Path
from typing import Any

from usdsdg.errors import ConfigError
from usdsdg.operating_system import home_folder
from usdsdg.stage.assets import PathMap

NAME = "usdsdg.toml"
SECTIONS = ("map",)


def maps_of_files(script: Path, *, taken: Collection[str] = ()) -> list[PathMap]:
    """Return the maps of all configuration files; of maps with the same prefix, the first file's.

    Folders are relative to their file. `taken` are prefixes that are mapped otherwise, so that these are left out.

    Raises:
        ConfigError: a file is not TOML, has other keys, or maps to something that is not a folder.
    """
    found: dict[str, PathMap] = {}
    for file in _files(script):
        for prefix, folder in _maps(file).items():
            if prefix not in found and prefix not in taken:
                found[prefix] = _map(file, prefix, folder)
    return list(found.values())


def _files(script: Path) -> list[Path]:
    files = [Path(NAME).absolute(), script.resolve().parent / NAME]
    if given := os.environ.get("XDG_CONFIG_HOME"):
        files.append(Path(given) / "usdsdg" / "config.toml")
    elif (home := home_folder()) is not None:
        files.append(home / ".config" / "usdsdg" / "config.toml")
    # That of a folder which this user may not enter, as HOME after `sudo -u`, is another user's.
    return [file for file in dict.fromkeys(files) if os.path.isfile(file)]


def _maps(file: Path) -> dict[str, Any]:
    try:
        values = tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ConfigError(f"{file} cannot be read: {error}") from error
    if unknown := [key for key in values if key not in SECTIONS]:
        raise ConfigError(f"{file} has the unknown key {unknown[0]!r}; it takes the table [map]")
    maps = values.get("map", {})
    if not isinstance(maps, dict):
        raise ConfigError(f'{file}: map is {maps!r}; expected a table [map] with lines "PREFIX" = "FOLDER"')
    return maps


def _map(file: Path, prefix: str, folder: Any) -> PathMap:
    if not isinstance(folder, str):
        raise ConfigError(f"{file}: {prefix!r} is mapped to {folder!r}; expected a folder")
    try:
        return PathMap.checked(prefix, file.parent / Path(os.path.expanduser(folder)))
    except ConfigError as error:
        raise ConfigError(f"{file}: {error}") from None
