"""Search for files in a folder."""

import os
from collections.abc import Sequence
from pathlib import Path

from usdsdg.arguments import asset_folders
from usdsdg.errors import AssetNotFound
from usdsdg.stage import assets


def get_usd_files(path: str, recursive: bool = False, path_filter: str | None = None) -> list[str]:
    """Return the sorted paths of the USD files in a folder that match the regular expression `path_filter`.

    Of a USD file the path of that file is returned.

    Raises:
        AssetNotFound: there is no such folder or file, or it is a file of another kind.
        ArgumentError: `path_filter` is not a regular expression.
    """
    if path.lower().endswith(asset_folders.USD_SUFFIXES) and os.path.isfile(file := assets.resolve(path)):
        return [file]
    return asset_folders.usd_files(path, recursive=recursive, path_filter=path_filter)


def get_files_group(
    folder_path: str, file_suffixes: Sequence[str] | None = None, ignore_case: bool = True, file_type: str = "png"
) -> list[dict[str, str]]:
    """Group the files of a folder by the stem before a suffix, as in `rust_diffuse.png`, `rust_normal.png`.

    Args:
        file_suffixes: ends of the names before the extension; by default diffuse, normal, roughness, metallic.
        file_type: the extension.

    Returns:
        one mapping of suffix to path per stem, sorted by stem. Suffixes without a file are missing keys.

    Raises:
        AssetNotFound: there is no such folder.
    """
    root = Path(assets.resolve(folder_path))
    if not root.is_dir():
        raise AssetNotFound(f"{folder_path} is a file, not a folder")
    suffixes = list(file_suffixes or ("diffuse", "normal", "roughness", "metallic"))
    groups: dict[str, dict[str, str]] = {}
    for path in sorted(root.iterdir()):
        if path.suffix.lower() != f".{file_type.lower().lstrip('.')}":
            continue
        for suffix in suffixes:
            stem, wanted = (path.stem.lower(), suffix.lower()) if ignore_case else (path.stem, suffix)
            if stem.endswith(wanted):
                groups.setdefault(stem.removesuffix(wanted), {})[suffix] = str(path)
    return [groups[stem] for stem in sorted(groups)]
