"""Search for files in a folder."""

import json
import os
import re
from collections.abc import Sequence
from pathlib import Path

from usdsdg.arguments import asset_folders
from usdsdg.errors import ArgumentError, warn_once
from usdsdg.stage import assets


def get_usd_files(path: str | os.PathLike, recursive: bool = False, path_filter: str | None = None) -> list[str]:
    """Return the sorted paths of the USD files in a folder that match the regular expression `path_filter`.

    Of a USD file the path of that file is returned.

    Raises:
        AssetNotFound: there is no such folder or file, or it is a file of another kind.
        ArgumentError: `path_filter` is not a regular expression.
    """
    path = os.fspath(path)
    if path.lower().endswith(asset_folders.USD_SUFFIXES) and os.path.isfile(file := assets.resolve(path)):
        return [file]
    return asset_folders.usd_files(path, recursive=recursive, path_filter=path_filter)


def get_files_group(
    folder_path: str, file_suffixes: Sequence[str] | None = None, ignore_case: bool = True, file_type: str = "png"
) -> list[str] | None:
    """Group the files of a folder that belong together, as `Wood_D.png` and `Wood_O.png`.

    Such groups are textures for `create.mesh_decal` and `modify.projection_material`.

    Args:
        file_suffixes: ends of the names before the extension, such as "_D", as regular expressions.
        ignore_case: whether suffixes in other cases count too.
        file_type: the extension.

    Returns:
        sorted JSON texts of one group each, {"Wood": {"_D": path, "_O": path}}, without the suffixes that no file has.
        None, with a warning, where there is no such folder or no suffix is given.

    Raises:
        ArgumentError: a suffix is not a regular expression.
    """
    folder = _folder(folder_path)
    if folder is None or not file_suffixes:
        problem = f"{folder_path} is not a folder" if folder is None else "file_suffixes is empty; give at least one"
        warn_once(f"utils.get_files_group: {problem}. The result is None.")
        return None
    names = [path.name for path in sorted(folder.iterdir()) if re.fullmatch(rf".*\.({file_type})", path.name)]
    groups: dict[str, dict[str, str]] = {}
    for suffix in file_suffixes:
        pattern = _pattern(suffix, re.IGNORECASE if ignore_case else 0)
        for name in names:
            if found := pattern.fullmatch(name.rpartition(".")[0]):
                groups.setdefault(found[1], {})[suffix] = (folder / name).as_posix()
    return sorted(json.dumps({stem: files}) for stem, files in groups.items())


def _folder(path: str) -> Path | None:
    """Return a folder of this machine or below the assets root; None if there is no such folder."""
    # Not `resolve`, which has the run end for what is missing.
    folder = path if Path(path).is_dir() else assets.locate_or_none(path)
    return Path(folder) if folder is not None and Path(folder).is_dir() else None


def _pattern(suffix: str, flags: int) -> re.Pattern[str]:
    try:
        return re.compile(f"(.*)({suffix})", flags)
    except re.error as error:
        raise ArgumentError(f"utils.get_files_group: {suffix!r} is not a regular expression: {error}") from None
