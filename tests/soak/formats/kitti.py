"""KITTI, read by Datumaro, which the Python that USDSDG_READERS_PYTHON names may have, and by the rules of KITTI's
development kit (see `readers/kitti.py`)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tests.soak.formats.records import rows_of
from tests.soak.formats.scene import Wanted, make

SIZE = (320, 240)
_LOWEST = 5  # rows of a box
_LOW = {"bbox_height_threshold": _LOWEST}
WANTED = {
    "plain": Wanted("KittiWriter", {**_LOW, "splits": {"train": 0.8, "val": 0.2}}, 2),
    "replicator": Wanted("KittiWriter", {**_LOW, "omit_semantic_type": True}, 2),
    "kitti_dir_names": Wanted("KittiWriter", {**_LOW, "omit_semantic_type": True, "use_kitti_dir_names": True}),
}


def rows(folder: Path, frames: int) -> Iterator[tuple[str, str, bool]]:
    """Yield what Datumaro, the development kit's rules and `usdsdg verify` say of the scene."""
    make(folder, WANTED, frames=frames, size=SIZE, upright=True)
    yield from rows_of("kitti", folder, {name: [_LOWEST] for name in WANTED})
