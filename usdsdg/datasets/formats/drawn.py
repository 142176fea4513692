"""Reader of DataVisualizationWriter's pictures."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import PurePosixPath

from usdsdg.datasets.folder import Folder
from usdsdg.datasets.matching import truth_of
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.seen_object import SeenObject

NAME = "DataVisualizationWriter"
_FILE = re.compile(r"^(?P<kind>bounding_box_(?:2d_tight|2d_loose|3d)_fast)_(?P<number>\d+)\.png$")


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the files of each image show."""
    found: dict[tuple[str, str], dict[str, str]] = {}
    for file in files:
        path = PurePosixPath(file)
        if match := _FILE.match(path.name):
            found.setdefault((path.parent.as_posix(), match["number"]), {})[match["kind"]] = file
    for (view, number), parts in sorted(found.items()):
        seen = Seen(NAME, number, view, list(parts.values()), truth_of(folder, list(parts.values()), view))
        seen.later(lambda made, parts=parts: _read_images(folder, made, parts))
        yield seen


def objects(_seen: Seen) -> list[SeenObject]:
    """Return nothing: the boxes are in the pictures."""
    return []


def _read_images(folder: Folder, seen: Seen, parts: dict[str, str]) -> None:
    for kind, file in parts.items():
        if (image := folder.image(file, seen.name)) is not None:
            seen.extra[kind] = (file, image)
