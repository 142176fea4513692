"""The user's cache folder, where demo assets, stand-ins and mirrored assets are kept."""

import filecmp
import json
import os
import shutil
import tempfile
import zlib
from collections.abc import Callable
from pathlib import Path

from usdsdg.errors import AssetError, warn_once
from usdsdg.operating_system import home_folder

_SUMS = ".checksums.json"  # in a folder that was built: the CRC-32 of each of its files, by its path
_checked: set[Path] = set()  # folders that this process has found whole


def cache_folder() -> Path:
    """Return `$XDG_CACHE_HOME/usdsdg`, by default `~/.cache/usdsdg`; it need not exist yet.

    Raises:
        AssetError: the home folder of this user is not known.
    """
    if given := os.environ.get("XDG_CACHE_HOME"):
        return Path(given) / "usdsdg"
    if (home := home_folder()) is None:
        raise AssetError(
            "There is no folder for caches, such as of assets made by code, since the home folder of this user is not "
            "known: export XDG_CACHE_HOME=FOLDER."
        )
    return home / ".cache" / "usdsdg"


def built_folder(target: Path, build: Callable[[Path], None]) -> Path:
    """Return `target`, filled by `build(folder)` if there is no such folder yet: whole, or not at all.

    Processes that build at the same time each make a copy of their own, and the first one to finish is kept. Where
    files are missing or damaged, as by a full disk or a crash, they are built again, with a warning.

    Raises:
        OSError: it cannot be written.
    """
    is_there = target.is_dir()
    if is_there and (target in _checked or _is_whole(target)):
        _checked.add(target)
        return target
    target.parent.mkdir(parents=True, exist_ok=True)
    temporary = Path(tempfile.mkdtemp(prefix=f".{target.name}-", dir=target.parent))
    try:
        build(temporary)
        (temporary / _SUMS).write_text(json.dumps(_sums(temporary)), encoding="utf-8")
        temporary.chmod(0o755)
        if is_there:
            replace_files(temporary, target)
            warn_once(f"files in {target} were damaged or missing, and are made again.")
        else:
            temporary.rename(target)
    except OSError:
        # Another process may have finished first; its folder has the same contents.
        if is_there or not target.is_dir():
            raise
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    _checked.add(target)
    return target


def replace_files(source: Path, target: Path) -> None:
    """Move the files of a folder into another one that lacks them or has others; those with the same bytes stay.

    Each takes its place at once, since other processes may be reading. Errors are those of the system.
    """
    for file in _files(source):
        there = target / file.relative_to(source)
        if not there.is_file() or not filecmp.cmp(file, there, shallow=False):
            there.parent.mkdir(parents=True, exist_ok=True)
            file.replace(there)


def _is_whole(folder: Path) -> bool:
    """Return whether a folder has all files that were built; one without checksums is taken as it is."""
    try:
        known = json.loads((folder / _SUMS).read_text(encoding="utf-8"))
        return all(zlib.crc32((folder / name).read_bytes()) == crc for name, crc in known.items())
    except FileNotFoundError:
        return not (folder / _SUMS).exists()
    except (OSError, ValueError, AttributeError):  # such as a folder in the place of a file, or another text
        return False


def _sums(folder: Path) -> dict[str, int]:
    return {each.relative_to(folder).as_posix(): zlib.crc32(each.read_bytes()) for each in _files(folder)}


def _files(folder: Path) -> list[Path]:
    return sorted(each for each in folder.rglob("*") if each.is_file())
