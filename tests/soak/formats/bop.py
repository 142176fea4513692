"""BOP, read and scored by bop_toolkit, which the Python that USDSDG_READERS_PYTHON names may
have (see `readers/bop.py`)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tests.soak.formats import readers
from tests.soak.formats.scene import SIZE, Wanted, make
from usdsdg.verify import verify

# Steps of a fifth of a millimeter reach beyond the floor: where there is no depth, BOP counts objects as visible.
WANTED = {"bop": Wanted("BopWriter", {"depth_scale": 0.2}, 2)}


def rows(folder: Path, frames: int) -> Iterator[tuple[str, str, bool]]:
    """Yield what bop_toolkit and `usdsdg verify` say of the scene."""
    make(folder, WANTED, frames=frames)
    yield from readers.rows_of("bop", folder / "bop", "train_pbr", *SIZE)
    faults = verify(folder / "bop").faults
    yield "usdsdg verify", f"{len(faults)} faults{faults[:1] or ''}", not faults
