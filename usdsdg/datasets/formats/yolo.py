"""Reader of YoloWriter's folders."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import PurePosixPath
from typing import Any

import numpy as np
import yaml

from usdsdg.datasets.color_images import read_color
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.matching import truth_of
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.seen_object import SeenObject
from usdsdg.writers.formats.yolo.yolo_files import DESCRIPTION, IMAGES, LABELS, NAME

_BOX = 4  # numbers of a box
_VALUES = 3  # of a keypoint: x, y and visibility
_NO_PARTS = ("names", "kpt_shape")  # what data.yaml says beside the folders of parts


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the files of each image say."""
    if not folder.has(DESCRIPTION):
        return
    names, keypoints, parts_of = _described(folder)
    found: dict[tuple[str, str], dict[str, str]] = {}
    for file in files:
        path = PurePosixPath(file)
        if len(path.parts) == 3 and path.parts[0] in (IMAGES, LABELS):
            found.setdefault((path.stem, path.parts[1]), {})[path.parts[0]] = file
    for (stem, split), parts in sorted(found.items()):
        view, _, number = stem.rpartition("_")
        mine = list(parts.values())
        seen = Seen(NAME, f"{split}/{number}", view, mine, truth_of(folder, mine, view))
        seen.extra |= {"names": names, "keypoints": keypoints, "parts": parts_of, "part": split}
        seen.picture, seen.labels = parts.get(IMAGES, ""), parts.get(LABELS, "")
        if seen.picture:
            seen.size = folder.image_size(seen.picture, seen.name)
            seen.later(lambda made: read_color(folder, made, made.picture))
        if LABELS not in parts:
            seen.extra["unlabeled"] = mine[0]
        elif (text := folder.text(parts[LABELS], seen.name)) is not None:
            seen.lines.append((parts[LABELS], [line.split(" ") for line in text.splitlines()]))
        yield seen


def _described(folder: Folder) -> tuple[dict[int, str] | None, int, dict[str, str]]:
    """Return the names of the classes, the number of keypoints, and the folder of pictures of each part.

    There are no names where data.yaml cannot be read.
    """
    values = folder.binary(DESCRIPTION, "all", _of_yaml)
    found = None if values is None else folder.parsed(DESCRIPTION, "all", lambda: (_names(values), _keypoints(values)))
    if values is None or found is None:
        return None, 0, {}
    return *found, {str(name): str(value) for name, value in values.items() if name not in _NO_PARTS}


def _of_yaml(data: bytes) -> dict[Any, Any]:
    """Return the mapping of YAML text.

    Raises:
        ValueError: it is none.
    """
    try:
        values = yaml.safe_load(data.decode("utf-8"))
    except yaml.MarkedYAMLError as error:
        where = f" at line {error.problem_mark.line + 1}" if error.problem_mark else ""
        raise ValueError(f"it is not valid YAML{where}: {error.problem or error.context}") from None
    except (yaml.YAMLError, AttributeError, RecursionError) as error:
        raise ValueError(f"it is not valid YAML: {' '.join(str(error).split())}") from None
    if not isinstance(values, dict):
        raise ValueError("it is empty" if values is None else f"it is no mapping, but a {type(values).__name__}")
    return values


def _names(values: Mapping[Any, Any]) -> dict[int, str]:
    """Return the names of the classes by their numbers; YOLO takes a list of them as well."""
    names = values.get("names") or {}
    if not isinstance(names, (dict, list)):
        raise ValueError(f"names is a {type(names).__name__}, expected a mapping from numbers to names")
    numbered = names.items() if isinstance(names, dict) else enumerate(names)
    return {int(key): str(name) for key, name in numbered}


def _keypoints(values: Mapping[Any, Any]) -> int:
    """Return the number of keypoints of an object; 0 where there are none."""
    shape = values.get("kpt_shape") or [0]
    is_one = isinstance(shape, list) and isinstance(shape[0], int) and shape[0] >= 0
    if not is_one or ("kpt_shape" in values and shape[1:] != [_VALUES]):
        raise ValueError(f"kpt_shape is {shape!r}, expected the number of keypoints, and {_VALUES} values of each")
    return shape[0]


def objects(seen: Seen) -> list[SeenObject]:
    """Return the objects of the lines: boxes, outlines or keypoints."""
    lines = [fields for _, each in seen.lines for fields in each]
    return [] if seen.size is None else [_object(fields, seen.extra, seen.size) for fields in lines]


def _object(fields: list[str], described: Mapping[str, Any], size: tuple[int, int]) -> SeenObject:
    made = SeenObject((described["names"] or {}).get(int(fields[0]), fields[0]))
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
