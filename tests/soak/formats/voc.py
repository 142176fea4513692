"""Pascal VOC, read by Datumaro and scored as its development kit scores, in the Python that USDSDG_READERS_PYTHON names
(see `readers/voc.py`)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tests.soak.formats.records import LIMITS, rows_of
from tests.soak.formats.scene import Wanted, make

_SPLITS = {"splits": {"train": 0.8, "val": 0.2}}
WANTED = {
    "plain": Wanted("VocWriter", _SPLITS),
    "limits": Wanted(
        "VocWriter", {**_SPLITS, "min_visibility": 0.4, "min_pixels": 20, "image_output_format": "png"}, 2
    ),
}


def rows(folder: Path, frames: int) -> Iterator[tuple[str, str, bool]]:
    """Yield what Datumaro, the development kit's rules and `usdsdg verify` say of the scene."""
    make(folder, WANTED, frames=frames)
    limits = {name: [each.options.get(f"min_{limit}", 0) for limit in LIMITS] for name, each in WANTED.items()}
    yield from rows_of("voc", folder, limits)
