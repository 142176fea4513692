"""YOLO, checked and scored by ultralytics, which the Python that USDSDG_READERS_PYTHON names may
have (see `readers/yolo.py`)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tests.soak.formats import readers
from tests.soak.formats.scene import SIZE, Wanted, make
from usdsdg.verify import verify

_SPLITS = {"splits": {"train": 0.8, "val": 0.2}}
WANTED = {
    "detect": Wanted("YoloWriter", _SPLITS, 2),
    "segment": Wanted("YoloWriter", {"task": "segment", **_SPLITS}, 2),
    "obb": Wanted("YoloWriter", {"task": "obb", **_SPLITS}),
    "pose": Wanted("YoloWriter", {"task": "pose", "min_visibility": 0.05, "min_pixels": 6, **_SPLITS}),
}


def rows(folder: Path, frames: int) -> Iterator[tuple[str, str, bool]]:
    """Yield what ultralytics and `usdsdg verify` say of the scene."""
    make(folder, WANTED, frames=frames)
    yield from readers.rows_of("yolo", folder, max(SIZE), *WANTED)
    for task in WANTED:
        faults = verify(folder / task).faults
        yield f"{task}: usdsdg verify", f"{len(faults)} faults{faults[:1] or ''}", not faults
