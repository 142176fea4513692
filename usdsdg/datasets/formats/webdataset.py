"""Reader of WebDatasetWriter's shards."""

from __future__ import annotations

import json
import tarfile
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any

from usdsdg.datasets.faults import Fault
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.formats import sharded
from usdsdg.datasets.seen import Seen
from usdsdg.writers.formats.shards.shard_files import IMAGE, INDEX, JSON, MEMBERS
from usdsdg.writers.formats.shards.shard_files import WEBDATASET as NAME

__all__ = ["NAME", "objects", "read"]
objects = sharded.objects


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what each sample of each shard says."""
    shards = [file for file in files if PurePosixPath(file).suffix == ".tar"]
    if not shards or not folder.has(INDEX):
        return
    index = folder.mapping(INDEX, "all") or {}
    counts = folder.parsed(INDEX, "all", lambda: _counts(index)) or {}
    known: dict[str, str] = {}
    for file in sorted({*shards, *counts}):
        samples = _samples(folder, file)
        if file not in counts or len(samples) != counts[file]:
            expected = str(counts.get(file, "none"))
            folder.faults.append(Fault(INDEX, "all", f"samples of {file}", expected, str(len(samples))))
        for key, members in samples.items():
            if key in known:
                folder.faults.append(Fault(file, key, f"is in {known[key]}, too"))
            known[key] = file
            seen = folder.parsed(file, key, partial(_seen, folder, file, key, members, index.get("classes", ())))
            if seen is not None:
                yield seen


def _counts(index: Mapping[str, Any]) -> dict[str, int]:
    """Return the numbers of samples of all shards, by file."""
    return {file: int(count) for each in index.get("shards", {}).values() for file, count in each.items()}


def _samples(folder: Folder, file: str) -> dict[str, dict[str, tuple[int, int]]]:
    """Return where the members of each sample are: start and size of each, by extension."""
    found: dict[str, dict[str, tuple[int, int]]] = {}

    def list_members(path: Path) -> None:
        last = ""
        with tarfile.open(path, "r:") as tar:
            for member in tar:
                key, _, extension = member.name.partition(".")
                if key != last and key in found:
                    folder.faults.append(Fault(file, key, "has members that do not follow each other"))
                if extension in found.setdefault(key, {}):
                    folder.faults.append(Fault(file, key, f"has two members {member.name}"))
                found[key][extension], last = (member.offset_data, member.size), key

    folder.opened(file, "all", list_members)
    return found


def _seen(folder: Folder, file: str, key: str, members: Mapping[str, tuple[int, int]], classes: Any) -> Seen:
    values = json.loads(_bytes(folder, file, *members[JSON]))
    if values["key"] != key:
        raise ValueError(f"key is {values['key']!r}, not that of its members")
    image = next((name for name in members if name in ("png", "jpg", "jpeg")), None)
    if image is None:
        raise ValueError("there is no picture among its members")

    def load(kind: str) -> tuple[str, bytes] | None:
        extension = image if kind == IMAGE else MEMBERS[kind]
        return (f"{key}.{extension}", _bytes(folder, file, *members[extension])) if extension in members else None

    return sharded.seen_of(folder, NAME, file, values, values["objects"], classes, load, classes_file=INDEX)


def _bytes(folder: Folder, file: str, start: int, size: int) -> bytes:
    with (folder.path / file).open("rb") as opened:
        opened.seek(start)
        return opened.read(size)
