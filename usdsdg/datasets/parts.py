"""The datasets below a folder: each has a folder of its own, as where several writers wrote side by side."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from usdsdg.datasets.listing import MAX_DEPTH, files_below
from usdsdg.record import CLASSES

# Of what writers put beside a dataset, and files that are in the root of one of their format.
_BESIDE = PurePosixPath(CLASSES).parts[0]
_IN_ROOT = re.compile(r"^(data\.yaml|coco_annotations_.+\.json)$")
_BOP_SCENE = "scene_gt.json"  # two folders below the root
_ANNOTATIONS, _COCO_TABLE = "annotations", re.compile(r"^instances_.+\.json$")


def parts(folder: Path) -> list[tuple[str, list[str]]]:
    """Return the datasets below a folder: each with its path, "" for the folder itself, and its files relative to it.

    A file belongs to the innermost dataset that it is in.
    """
    roots = sorted({"", *_roots(folder)})
    found = [(root, list(_own_files(folder, root, roots))) for root in roots]
    return [(root, files) for root, files in found if files]


def _own_files(folder: Path, root: str, roots: list[str]) -> Iterator[str]:
    """Yield the files of a dataset that are in no other one inside of it."""
    inner = {Path(other).relative_to(root) for other in roots if other != root and Path(root) in Path(other).parents}
    for path in files_below(folder / root):
        if inner.isdisjoint(path.parents):
            yield path.as_posix()


def _roots(folder: Path) -> Iterator[str]:
    for where, folders, names in os.walk(folder):
        inside = Path(where).relative_to(folder)
        is_root = _BESIDE in folders or any(_IN_ROOT.match(name) for name in names)
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        if len(inside.parts) >= MAX_DEPTH:
            folders.clear()
        if is_root and inside.parts:
            yield inside.as_posix()
        if _BOP_SCENE in names and len(inside.parts) > 2:
            yield inside.parent.parent.as_posix()
        if inside.name == _ANNOTATIONS and len(inside.parts) > 1 and any(_COCO_TABLE.match(name) for name in names):
            yield inside.parent.as_posix()
