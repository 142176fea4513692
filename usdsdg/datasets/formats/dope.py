"""Reader of DOPEWriter's files."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

import numpy as np

from usdsdg.datasets import cuboids
from usdsdg.datasets.color_images import read_color
from usdsdg.datasets.cuboids import KEYPOINTS
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.matching import truth_of
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.seen_object import SeenObject

NAME = "DOPEWriter"
# Of the keypoints, in the names of `cuboids.KEYPOINTS`.
ORDER = ("RDF", "LDF", "LUF", "RUF", "RDB", "LDB", "LUB", "RUB", "Center")
_FILE = re.compile(r"^(?P<number>\d{6})\.(?P<kind>png|jpe?g|json)$", re.IGNORECASE)
_PICTURES = "rgb"  # folder of the images of several render products


@dataclass(frozen=True)
class Posed:
    """One object of an image."""

    name: str  # of its class, as the file has it
    visibility: float
    location: np.ndarray  # (3,)
    quaternion: np.ndarray  # (4,) w x y z
    pixels: np.ndarray  # (9, 2) in ORDER


@dataclass(frozen=True)
class Poses:
    """The objects of an image. Exact files have a camera."""

    file: str
    objects: list[Posed]
    camera: Mapping[str, Any]

    @property
    def exact(self) -> bool:
        """Whether the numbers are those of `exact=True`."""
        return bool(self.camera)


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the files of each image say."""
    found: dict[tuple[str, str], dict[str, str]] = {}
    known = set(files)
    for file in files:
        path = PurePosixPath(file)
        if match := _FILE.match(path.name):
            is_json = match["kind"].lower() == "json"
            # A render product may be called as the folder of pictures is: it has the labels, too.
            apart = path.parent.name == _PICTURES and path.with_suffix(".json").as_posix() not in known
            where = path.parent.parent if apart else path.parent
            view = where.as_posix() if where.parts else ""
            found.setdefault((view, match["number"]), {})["json" if is_json else "picture"] = file
    if _is_mine(folder, [parts["json"] for parts in found.values() if "json" in parts]):
        for (view, number), parts in sorted(found.items()):
            yield _seen(folder, view, number, parts)


def _is_mine(folder: Folder, tables: list[str]) -> bool:
    """Return whether JSON files are of DOPEWriter; PoseWriter's name the order of keypoints."""
    for file in tables:
        values = folder.json(file, "?") if folder.has(file) else None
        if isinstance(values, dict):
            return {"camera_data", "objects"} == set(values)
    return False


def _seen(folder: Folder, view: str, number: str, parts: dict[str, str]) -> Seen:
    files = list(parts.values())
    seen = Seen(NAME, number, view, files, truth_of(folder, files, view))
    seen.picture, seen.labels = parts.get("picture", ""), parts.get("json", "")
    if seen.picture:
        seen.size = folder.image_size(seen.picture, seen.name)
        seen.later(lambda made: read_color(folder, made, made.picture))
    values = folder.mapping(seen.labels, seen.name) if seen.labels else None
    poses = None if values is None else folder.parsed(seen.labels, seen.name, lambda: _poses(seen.labels, values))
    if poses is not None:
        seen.extra["poses"] = poses
        seen.variant = "exact" if poses.exact else ""
    return seen


def _poses(file: str, values: Mapping[str, Any]) -> Poses:
    listed = [
        Posed(
            str(each["class"]),
            float(each["visibility"]),
            np.array(each["location"], np.float64).reshape(3),
            np.array(each["quaternion_wxyz"], np.float64).reshape(4),
            np.array(each["projected_cuboid"], np.float64).reshape(9, 2),
        )
        for each in values["objects"]
    ]
    return Poses(file, listed, dict(values["camera_data"]))


def objects(seen: Seen) -> list[SeenObject]:
    """Return the objects with their cuboids, whose boxes are the loose ones."""
    poses: Poses | None = seen.extra.get("poses")
    return [_object(each, seen.size) for each in poses.objects] if poses else []


def _object(posed: Posed, size: tuple[int, int] | None) -> SeenObject:
    made = SeenObject(posed.name, visibility=posed.visibility)
    made.cuboid = posed.pixels[[ORDER.index(name) for name in KEYPOINTS]]
    made.axes = cuboids.axes_of(made.cuboid)
    made.loose = cuboids.bounds(made.cuboid, size)
    made.distance = float(np.linalg.norm(posed.location)) / 100.0  # centimeters, where the stage is in meters
    return made
