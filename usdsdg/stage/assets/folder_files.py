"""The files of a folder of assets."""

import os
from collections.abc import Iterator
from pathlib import Path

from usdsdg.errors import AssetUnreadable
from usdsdg.stage.assets.url import check_name

MOST_FILES = 1_000_000  # below a folder that is searched


def files_in(folder: str | os.PathLike[str], suffixes: tuple[str, ...], *, recursive: bool = True) -> list[str]:
    """Return the sorted paths of the files with one of the suffixes, which are in lower case.

    Links to folders are followed, to each folder once. Links to files that are gone are files too, which readers name.
    Hidden files and folders below it are left out: previews, `._mug.obj` of macOS, what a program has left that died.

    Args:
        recursive: also search the subfolders. Those that are removed meanwhile are left out.

    Raises:
        AssetUnreadable: this user may not read the folder or one in it, of which files would be missing; USD cannot
            have the name of a file; or it is no folder of assets, but a whole disk or one with more than `MOST_FILES`
            files.
    """
    if recursive and Path(folder).resolve().parent == Path(folder).resolve():
        raise AssetUnreadable(f"{folder} is a whole disk, which is not searched: give the folder that the files are in")
    found = sorted(
        path
        for path in _paths(os.fspath(folder), recursive)
        if Path(path).suffix.lower() in suffixes and (os.path.isfile(path) or os.path.islink(path))
    )
    for path in found:
        check_name(path)
    return found


def _paths(folder: str, recursive: bool) -> Iterator[str]:
    seen, count = {os.path.realpath(folder)}, 0
    for place, folders, files in os.walk(folder, followlinks=True, onerror=_refuse):
        files, folders[:] = _shown(files), _shown(folders)
        count += len(files)
        if count > MOST_FILES:
            raise AssetUnreadable(
                f"{folder} has more than {MOST_FILES:,} files: give the folder of those that are meant"
            )
        yield from (os.path.join(place, file) for file in files)
        inside = sorted(folders) if recursive else []
        real = {name: os.path.realpath(os.path.join(place, name)) for name in inside}
        new = {path: name for name, path in reversed(real.items()) if path not in seen}
        seen.update(new)
        folders[:] = sorted(new.values())  # os.walk goes into these


def _shown(names: list[str]) -> list[str]:
    return [name for name in names if not name.startswith(".")]


def _refuse(error: OSError) -> None:
    if not isinstance(error, FileNotFoundError):
        raise AssetUnreadable(
            f"{error.filename} cannot be searched for files: {error.strerror}. Let this user read it, or take it away."
        ) from error
