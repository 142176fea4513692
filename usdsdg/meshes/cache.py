"""Converted meshes in the user's cache, by the content of the files that they were made of."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from usdsdg.errors import OutputNotWritable, UsdsdgError, warn_once
from usdsdg.meshes.conversion import Options, convert
from usdsdg.stage.assets import cache_folder, replace_files
from usdsdg.stage.assets.opened import note_opened
from usdsdg.stores.locks import locked

# Part of each key: another number converts everything again.
VERSION = 7
_ELSEWHERE = "free space or permissions there, or set XDG_CACHE_HOME to a writable folder"


def converted(source: str | os.PathLike[str], options: Options) -> str:
    """Return the path of the USD file of a mesh file, converting it if its content is new or what was made is damaged.

    What was repaired or looks odd is a warning of each run.

    Raises:
        AssetUnreadable, Unsupported, OutputNotWritable: as `convert`.
    """
    file = Path(source).resolve()
    folder = cache_folder() / "meshes"
    start = _digest([file], f"{VERSION} {file.name} {options!r}")
    noted = folder / f"{start}.json"
    try:
        with locked(folder / f"{start}.lock"):
            done = _known(noted, folder) or _convert(file, folder, noted, options)
    except OutputNotWritable as error:
        raise OutputNotWritable(f"{error.cause}; {_ELSEWHERE}") from error
    except UsdsdgError:
        raise
    except OSError as error:
        # A cache that may only be read, as in the image of a container, has what was converted before.
        if (known := _known(noted, folder)) is None:
            why = error.strerror or error
            raise OutputNotWritable(f"{file} cannot be converted to USD in {folder}: {why}; {_ELSEWHERE}") from error
        done = known
    for each in (os.path.abspath(source), *done.files):
        note_opened(each)
    for line in done.lines:
        warn_once(f"{file}: {line}")
    return str(done.usd)


class _Converted(NamedTuple):
    usd: Path
    lines: list[str]  # repairs and oddities, which each run names
    files: list[str]  # others that it was made of


def _known(noted: Path, folder: Path) -> _Converted | None:
    """Return the converted file if it is as it was made, and all that it was made of as it was."""
    try:
        note = json.loads(noted.read_text(encoding="utf-8"))
        found = _Converted(folder / note["usd"], note["lines"], note["files"])
        if note["digest"] != _digest(map(Path, note["files"]), "") or not found.usd.is_file():
            return None
        if note["made"] == _digest_below(found.usd.parent):
            return found
    except (OSError, ValueError, KeyError, TypeError):
        return None
    warn_once(f"{found.usd} or a texture beside it was damaged: the mesh file is converted again.")
    return None


def _convert(file: Path, folder: Path, noted: Path, options: Options) -> _Converted:
    made = folder / noted.stem / "new" / f"{file.stem}.usdc"
    shutil.rmtree(made.parent, ignore_errors=True)
    report, mesh = convert(file, made, options)
    lines = [*report.repairs, *report.notes]
    files = sorted(mesh.files)
    digest = _digest(map(Path, files), "")
    # A place of its own for each content: open stages may refer to the one before.
    asset = made.parents[1] / digest / made.name
    replace_files(made.parent, asset.parent)
    shutil.rmtree(made.parent)
    note = {"usd": str(asset.relative_to(folder)), "files": files, "digest": digest, "lines": lines}
    note["made"] = _digest_below(asset.parent)
    temporary = noted.with_suffix(".part")
    temporary.write_text(json.dumps(note), encoding="utf-8")
    temporary.replace(noted)
    return _Converted(asset, lines, files)


def _digest(files: Iterable[Path], more: str) -> str:
    """Return a hash of some files' content; one that is missing counts as such."""
    digest = hashlib.blake2b(more.encode(), digest_size=16)
    for file in files:
        try:
            status = file.stat()
            digest.update(_digest_of(str(file), status.st_size, status.st_mtime_ns))
        except OSError:
            digest.update(b"missing")
    return digest.hexdigest()


def _digest_below(folder: Path) -> str:
    """Return a hash of the names and content of the files that were made, the USD file and its textures."""
    files = sorted(each for each in folder.rglob("*") if each.is_file())
    return _digest(files, " ".join(each.relative_to(folder).as_posix() for each in files))


@lru_cache(maxsize=1024)
def _digest_of(file: str, size: int, modified: int) -> bytes:
    """Return a hash of a file's content, which is read once for each size and time of modification."""
    with open(file, "rb") as stream:
        return hashlib.file_digest(stream, "blake2b").digest()
