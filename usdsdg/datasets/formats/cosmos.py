"""Reader of CosmosWriter's clips."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import PurePosixPath

from usdsdg.datasets.folder import Folder
from usdsdg.datasets.matching import truth_of
from usdsdg.datasets.seen import Color, Ids, Seen, packed
from usdsdg.datasets.seen_object import SeenObject

NAME = "CosmosWriter"
_COLORED = ("rgb", "segmentation", "shaded_seg")
_CLIP, _FILE = re.compile(r"^clip_\d+$"), re.compile(r"^(?P<kind>[a-z_]+)_(?P<number>\d{4,})\.png$")


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the files of each image say."""
    found: dict[tuple[str, str], dict[str, str]] = {}
    for file in files:
        path = PurePosixPath(file)
        match = _FILE.match(path.name)
        if match and len(path.parts) > 2 and path.parent.name == match["kind"] and _CLIP.match(path.parent.parent.name):
            found.setdefault((path.parent.parent.as_posix(), match["number"]), {})[match["kind"]] = file
    for (clip, number), parts in sorted(found.items()):
        seen = Seen(NAME, number, clip, list(parts.values()), truth_of(folder, list(parts.values()), clip))
        seen.picture = parts.get("rgb", "")
        seen.later(lambda made, parts=parts: _read_images(folder, made, parts))
        yield seen


def objects(_seen: Seen) -> list[SeenObject]:
    """Return nothing: clips have no objects."""
    return []


def _read_images(folder: Folder, seen: Seen, parts: dict[str, str]) -> None:
    images = {
        kind: (folder.color if kind in _COLORED else folder.image)(file, seen.name) for kind, file in parts.items()
    }
    if (image := images.get("rgb")) is not None:
        seen.colors.append(Color(parts["rgb"], image))
    if (image := images.get("segmentation")) is not None:
        template = (seen.truth.record.annotators if seen.truth else {}).get("segmentation", {}).get("template", "")
        kind = (
            "gprim"
            if template.startswith("instance_id")
            else "class"
            if template.startswith("semantic")
            else "instance"
        )
        chosen = bool(seen.truth and seen.truth.parameter("segmentation", "mapping"))
        key = seen.truth.filter_of("segmentation") if seen.truth else ""
        seen.ids.append(Ids(parts["segmentation"], kind, packed(image), None, "", True, key, chosen))
    for kind in ("depth", "edges", "shaded_seg"):
        if (image := images.get(kind)) is not None:
            seen.extra[kind] = (parts[kind], image)
