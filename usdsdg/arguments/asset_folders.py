"""USD and mesh files of an asset folder."""

import os
import re
from pathlib import Path

from usdsdg.errors import ArgumentError, AssetError, AssetNotFound, Unsupported
from usdsdg.stage import assets
from usdsdg.stage.assets.folder_files import files_in

USD_SUFFIXES = (".usd", ".usda", ".usdc", ".usdz", *assets.MESHES)


def usd_files(folder: str | os.PathLike, *, recursive: bool = False, path_filter: str | None = None) -> list[str]:
    """Return the sorted paths of the USD and mesh files in a folder (or in a URL below the assets root).

    Where the folder is missing and assets have stand-ins, it is the one that has the name of the folder.

    Args:
        recursive: also search the subfolders.
        path_filter: regular expression that must be found in the path.

    Raises:
        AssetNotFound: there is no such folder.
        AssetUnreadable: this user may not read it, or a folder in it.
        ArgumentError: `path_filter` is not a regular expression.
    """
    folder = os.fspath(folder)
    try:
        root = Path(assets.locate(folder))
    except (AssetError, Unsupported) as error:
        return [assets.instead_of_folder(folder, error)]
    if not root.is_dir():
        raise AssetNotFound(f"{folder} is a file, not a folder")
    try:
        wanted = re.compile(path_filter or "")
    except re.error as error:
        raise ArgumentError(f"path_filter is {path_filter!r}, which is not a regular expression: {error}") from error
    return [path for path in files_in(root, USD_SUFFIXES, recursive=recursive) if wanted.search(path)]
