"""What a recipe has of the folders that a job takes meshes and pictures from: which files are there."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from usdsdg.arguments.asset_folders import USD_SUFFIXES
from usdsdg.errors import AssetNotFound, counted
from usdsdg.scenarios.shared.pictures import PICTURES, SKIES
from usdsdg.stage import assets
from usdsdg.stage.assets.folder_files import files_in

_KEYS = ("meshes", "pictures", "skies", "table")
_SUFFIXES = tuple({*USD_SUFFIXES, *PICTURES, *SKIES})


def folder_facts(config: Any) -> dict[str, str]:
    """Return, by key of a configuration, how many files its folder has, and a hash of their names.

    One file more or less changes what all frames draw, and the ids of classes.
    """
    return dict(_facts(config.model_dump(), ""))


def _facts(values: dict[str, Any], above: str) -> Iterator[tuple[str, str]]:
    for key, value in values.items():
        if isinstance(value, dict):
            yield from _facts(value, f"{above}{key}.")
        elif key in _KEYS and isinstance(value, str) and (folder := _folder(value)) is not None:
            names = [Path(file).relative_to(folder).as_posix() for file in files_in(folder, _SUFFIXES)]
            digest = hashlib.sha256("\n".join(names).encode("utf-8", "surrogateescape")).hexdigest()
            yield f"folder of {above}{key}", f"{counted(len(names), 'file')}, names {digest[:12]}"


def _folder(value: str) -> Path | None:
    try:
        folder = Path(assets.resolve(value)) if value else None
    except AssetNotFound:
        return None
    return folder if folder is not None and folder.is_dir() else None
