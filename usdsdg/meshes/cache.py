"""Converted meshes in the user's cache, by the content of the files that they were made of."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Iterable
from pathlib import Path

from usdsdg.errors import warn_once
from usdsdg.meshes.conversion import Options, convert
from usdsdg.mirror.locks import locked
from usdsdg.stage.assets import cache_folder

# Part of each key: another number converts everything again.
VERSION = 1


def converted(source: str | os.PathLike[str], options: Options) -> str:
    """Return the path of the USD file of a mesh file, converting it if its content is new; repairs are warnings.

    Raises:
        AssetUnreadable, Unsupported, OutputNotWritable: as `convert`.
    """
    file = Path(source).resolve()
    folder = cache_folder() / "meshes"
    start = _digest([file], f"{VERSION} {file.name} {options!r}")
    with locked(folder / f"{start}.lock"):
        noted = folder / f"{start}.json"
        done = _known(noted, folder)
        if done is None:
            done = _convert(file, folder, noted, options)
    return str(done)


def _known(noted: Path, folder: Path) -> Path | None:
    """Return the converted file if all that it was made of is as it was."""
    try:
        note = json.loads(noted.read_text(encoding="utf-8"))
        found = folder / note["usd"]
        same = note["digest"] == _digest(map(Path, note["files"]), "")
    except (OSError, ValueError, KeyError):
        return None
    return found if same and found.is_file() else None


def _convert(file: Path, folder: Path, noted: Path, options: Options) -> Path:
    made = folder / noted.stem / "new" / f"{file.stem}.usdc"
    shutil.rmtree(made.parent, ignore_errors=True)
    report, mesh = convert(file, made, options)
    for line in [*report.repairs, *report.notes]:
        warn_once(f"{file}: {line}")
    files = sorted(mesh.files)
    digest = _digest(map(Path, files), "")
    # A place of its own for each content: open stages may refer to the one before.
    asset = made.parents[1] / digest / made.name
    if not asset.is_file():
        shutil.rmtree(asset.parent, ignore_errors=True)
        made.parent.replace(asset.parent)
    note = {"usd": str(asset.relative_to(folder)), "files": files, "digest": digest}
    temporary = noted.with_suffix(".part")
    temporary.write_text(json.dumps(note), encoding="utf-8")
    temporary.replace(noted)
    return asset


def _digest(files: Iterable[Path], more: str) -> str:
    """Return a hash of some files' content; one that is missing counts as such."""
    digest = hashlib.blake2b(more.encode(), digest_size=16)
    for file in files:
        try:
            with file.open("rb") as stream:
                digest.update(hashlib.file_digest(stream, "blake2b").digest())
        except OSError:
            digest.update(b"missing")
    return digest.hexdigest()
