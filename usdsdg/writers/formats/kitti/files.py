"""Names of the files of a KITTI dataset: in Replicator's layout, by default, and in KITTI's own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

NAME = "KittiWriter"
# What there is of each picture, by Replicator's name of its folder.
RGB, LABELS, CALIBRATION = "rgb", "object_detection", "calib"
CLASSES, CLASS_COLORS = "semantic", "semantic_segmentation"
INSTANCES, INSTANCE_COLORS, DEPTH = "instance_segmentation", "instance_rgb", "depth"
TEXTS = (LABELS, CALIBRATION)

TRAINING, IMAGE_SETS = "training", "ImageSets"


@dataclass(frozen=True)
class Layout:
    """Where the files of a dataset are."""

    folders: Mapping[str, str]  # those that are not called after their kind
    digits: int = 1  # at least so many in the number of a picture

    def path(self, root: str, kind: str, number: int) -> str:
        """Return the file of a kind for a picture. root: the folder above those of the kinds."""
        extension = "txt" if kind in TEXTS else "png"
        return f"{root}/{self.folders.get(kind, kind)}/{number:0{self.digits}d}.{extension}"


REPLICATOR = Layout({})
KITTI_DIR_NAMES = Layout({RGB: "image_02", LABELS: "label_02", CLASS_COLORS: "semantic_rgb", INSTANCES: "instance"})
# Of KITTI's development kits for objects and semantics: all pictures are in TRAINING, and lists name those of a part.
PLAIN = Layout({RGB: "image_2", LABELS: "label_2", CLASS_COLORS: "semantic_rgb", INSTANCES: "instance"}, digits=6)

_KINDS = (RGB, LABELS, CALIBRATION, CLASSES, CLASS_COLORS, INSTANCES, INSTANCE_COLORS, DEPTH)
_BY_FOLDER = {
    layout.folders.get(kind, kind): kind for layout in (REPLICATOR, KITTI_DIR_NAMES, PLAIN) for kind in _KINDS
}


def layout_of(options: Mapping[str, Any]) -> Layout:
    """Return the layout that options of `KittiWriter` ask for; those that are not given may be missing."""
    plain = options.get("plain_names")
    if plain or (plain is None and options.get("splits") is not None):
        return PLAIN
    return KITTI_DIR_NAMES if options.get("use_kitti_dir_names") else REPLICATOR


def kind_of(folder: str, extension: str) -> str | None:
    """Return what the files of a folder are, by its name and theirs (".png", ".txt"); None: none of KITTI's."""
    kind = _BY_FOLDER.get(folder)
    return kind if extension == (".txt" if kind in TEXTS else ".png") else None


def image_set(split: str) -> str:
    """Return the list of the pictures of a part, in KITTI's own layout."""
    return f"{IMAGE_SETS}/{split}.txt"
