"""Reader of YoloWriter's folders."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import PurePosixPath
from typing import Any

import numpy as np
import yaml

from usdsdg.datasets.folder import Folder
from usdsdg.datasets.matching import truth_of
from usdsdg.datasets.seen import Color, Seen
from usdsdg.datasets.seen_object import SeenObject
from usdsdg.writers.formats.yolo.yolo_files import DESCRIPTION, IMAGES, LABELS, NAME

LOOKED_FOR = "YoloWriter's data.yaml with images/train/000000.png"
_BOX = 4  # numbers of a box


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the files of each image say."""
    if not folder.has(DESCRIPTION):
        return
    text = folder.text(DESCRIPTION, "all")
    described = None if text is None else folder.parsed(DESCRIPTION, "all", lambda t=text: yaml.safe_load(t) or {})
    names = dict((described or {}).get("names") or {})
    found: dict[tuple[str, str], dict[str, str]] = {}
    for file in files:
        path = PurePosixPath(file)
        if len(path.parts) == 3 and path.parts[0] in (IMAGES, LABELS):
            found.setdefault((path.stem, path.parts[1]), {})[path.parts[0]] = file
    for (stem, split), parts in sorted(found.items()):
        view, _, number = stem.rpartition("_")
        mine = list(parts.values())
        seen = Seen(NAME, f"{split}/{number}", view, mine, truth_of(folder, mine, view))
        seen.extra["names"] = {int(key): str(name) for key, name in names.items()}
        seen.extra["keypoints"] = int(((described or {}).get("kpt_shape") or [0])[0])
        seen.picture, seen.labels = parts.get(IMAGES, ""), parts.get(LABELS, "")
        if seen.picture:
            seen.size = folder.image_size(seen.picture, seen.name)
            seen.later(lambda made: _read_image(folder, made))
        if LABELS in parts and (text := folder.text(parts[LABELS], seen.name)) is not None:
            seen.lines.append((parts[LABELS], [line.split(" ") for line in text.splitlines()]))
        else:
            seen.extra["unlabeled"] = mine[0]
        yield seen


def _read_image(folder: Folder, seen: Seen) -> None:
    if (image := folder.image(seen.picture, seen.name)) is not None:
        seen.colors.append(Color(seen.picture, image, exact=seen.picture.endswith(".png")))


def objects(seen: Seen) -> list[SeenObject]:
    """Return the objects of the lines: boxes, outlines or keypoints."""
    lines = [fields for _, each in seen.lines for fields in each]
    return [] if seen.size is None else [_object(fields, seen.extra, seen.size) for fields in lines]


def _object(fields: list[str], described: Mapping[str, Any], size: tuple[int, int]) -> SeenObject:
    made = SeenObject(described["names"].get(int(fields[0]), fields[0]))
    numbers = np.array(fields[1:], np.float64)
    box, rest = (numbers[:_BOX], numbers[_BOX:]) if described["keypoints"] else (numbers, numbers[:0])
    if box.size == _BOX:
        center, half = box[:2] * size, box[2:] * size / 2
        low, high = center - half, center + half
    else:
        polygon = box.reshape(-1, 2) * size
        made.outline = [polygon]
        # Corners of an oriented box may be outside of the picture.
        low, high = polygon.min(axis=0).clip(0, size), polygon.max(axis=0).clip(0, size)
    made.box = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
    if rest.size:
        made.keypoints = rest.reshape(described["keypoints"], -1) * (*size, 1)
    return made
