"""Names of the files of a COCO dataset: plain ones, as COCO's own downloads have them, and those of Replicator.

Writer, verification and inspection ask here.
"""

from __future__ import annotations

import hashlib
import re
import string
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

_ID_LENGTH = 8
_JSON = re.compile(r"^(?:.+/)?(?:coco_annotations_.+|annotations/instances_(?P<split>[^/]+))\.json$")


@dataclass(frozen=True)
class ImageFiles:
    """Paths of the files of one image below the output folder, and how the JSON files name them."""

    picture: str
    panoptic: str  # ids of segments
    picture_name: str
    panoptic_name: str
    classes: str | None = None  # Replicator's picture in the colors of the categories


@dataclass(frozen=True)
class PlainNames:
    """`train/000000.png`, `annotations/instances_train.json`, `annotations/panoptic_train/000000.png`."""

    split: str
    root: str = ""  # folder of the dataset below the output folder, with a slash at its end

    @property
    def instances(self) -> str:
        """The JSON of boxes, masks and keypoints."""
        return f"{self.root}annotations/instances_{self.split}.json"

    @property
    def panoptic(self) -> str:
        """The JSON of segments."""
        return f"{self.root}annotations/panoptic_{self.split}.json"

    def image(self, name: str) -> ImageFiles:
        """Return the files of the image whose picture the JSON calls `name`."""
        ids = f"{PurePosixPath(name).stem}.png"
        folder = f"{self.root}annotations/panoptic_{self.split}"
        return ImageFiles(f"{self.root}{self.split}/{name}", f"{folder}/{ids}", name, ids)

    def has_picture(self, path: str) -> bool:
        """Return whether a picture at `path` is named as one of this dataset is."""
        return path.startswith(f"{self.root}{self.split}/")


@dataclass(frozen=True)
class ReplicatorNames:
    """`<product>/rgb_<stem>.png`, `<product>/panoptic_<stem>.png` and `coco_annotations_<dataset>.json`."""

    dataset: str
    root: str = ""

    @property
    def instances(self) -> str:
        return f"{self.root}coco_annotations_{self.dataset}.json"

    @property
    def panoptic(self) -> str:
        return f"{self.root}coco_panoptic_{self.dataset}.json"

    def image(self, name: str) -> ImageFiles:
        path = PurePosixPath(name)
        classes = path.with_name(path.name.replace("rgb_", "panoptic_", 1)).with_suffix(".png").as_posix()
        ids = path.with_name(path.name.replace("rgb_", "panoptic_ids_", 1)).with_suffix(".png").as_posix()
        return ImageFiles(f"{self.root}{name}", f"{self.root}{ids}", name, ids, f"{self.root}{classes}")

    def has_picture(self, path: str) -> bool:
        """Return whether a picture at `path` is named as one of this dataset is."""
        name = PurePosixPath(path).name
        return path.startswith(self.root) and re.match(rf"rgb_.*_{re.escape(self.dataset)}\.", name) is not None


Names = PlainNames | ReplicatorNames


def names_of(path: str) -> Names | None:
    """Return the names of the dataset whose JSON of instances is `path`; None if it is another file."""
    found = _JSON.match(path)
    if found is None:
        return None
    file = PurePosixPath(path)
    if found["split"] is not None:
        return PlainNames(found["split"], _root(file.parent.parent))
    return ReplicatorNames(file.stem.removeprefix("coco_annotations_"), _root(file.parent))


def id_of_seed(seed: int | None) -> str:
    """Return eight letters that depend on the seed only."""
    digest = hashlib.blake2b(str(seed).encode(), digest_size=_ID_LENGTH).digest()
    return "".join(string.ascii_lowercase[byte % len(string.ascii_lowercase)] for byte in digest)


def sequence_of(trigger_outputs: Mapping[str, Any]) -> str:
    """Return the part of Replicator's image names that counts how often on_time triggers have fired."""
    prefix = ""
    for name, count in trigger_outputs.items():
        if "on_time" in name:
            prefix = f"{count}_{prefix}_"
    return prefix


def _root(folder: PurePosixPath) -> str:
    return "" if folder.as_posix() == "." else f"{folder.as_posix()}/"
