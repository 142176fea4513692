"""CVAT for images 1.1, read by Datumaro, which the Python that USDSDG_READERS_PYTHON names may have, and as CVAT's own
import reads it (see `readers/cvat.py`)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tests.soak.formats.records import LIMITS, rows_of
from tests.soak.formats.scene import Wanted, make

WANTED = {
    "mask": Wanted("CvatWriter", {}, 2),
    "polygon": Wanted("CvatWriter", {"shape": "polygon", "image_output_format": "jpg"}),
    "box": Wanted("CvatWriter", {"shape": "box", "min_visibility": 0.4, "min_pixels": 20}),
}


def rows(folder: Path, frames: int) -> Iterator[tuple[str, str, bool]]:
    """Yield what Datumaro, CVAT's rules and `usdsdg verify` say of the scene."""
    make(folder, WANTED, frames=frames)
    limits = {name: [each.options.get(f"min_{limit}", 0) for limit in LIMITS] for name, each in WANTED.items()}
    yield from rows_of("cvat", folder, limits)
