"""COCO: boxes, masks, polygons, keypoints and segments."""

import os
from collections.abc import Iterator
from pathlib import Path

from tests.soak.formats.readers import rows_of
from tests.soak.formats.scene import KEYPOINTS, SKELETON, Wanted, make
from usdsdg.verify import verify

_POINTS = {name: {"keypoints": list(KEYPOINTS[name]), "skeleton": SKELETON.get(name, [])} for name in KEYPOINTS}
_SPLITS = {"train": 0.8, "val": 0.2}
_STUFF = {
    name: {"name": name, "id": number, "isthing": int(name != "ring")}
    for number, name in enumerate(("ball", "can", "crate", "figure", "ghost", "ring", "never"), 1)
}
WANTED = {
    "rle": Wanted("CocoWriter", {"splits": _SPLITS, "keypoints": _POINTS, "panoptic": True}),
    "polygon": Wanted("CocoWriter", {"plain_names": True, "segmentation": "polygon", "keypoints": True}, 2),
    "stuff": Wanted("CocoWriter", {"plain_names": True, "panoptic": True, "coco_categories": _STUFF}),
    "replicator": Wanted("CocoWriter", {"coco_categories": _STUFF, "keypoints": True, "panoptic": True}),
    "limits": Wanted("CocoWriter", {"splits": _SPLITS, "min_visibility": 0.4, "min_pixels": 20, "panoptic": True}),
}
# A checkout of cocodataset/panopticapi, where it is not installed.
PANOPTICAPI = "USDSDG_PANOPTICAPI"


def rows(folder: Path, frames: int) -> Iterator[tuple[str, str, bool]]:
    make(folder, WANTED, frames=frames)
    for name in WANTED:
        for what, found, is_right in rows_of("coco", folder / name, os.environ.get(PANOPTICAPI, "")):
            yield f"{name}: {what}", found, is_right
        report = verify(folder / name)
        yield f"{name}: usdsdg verify", report.summary(), report.is_clean and not report.notes
