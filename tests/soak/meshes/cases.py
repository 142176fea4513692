"""A mesh file of the soak, and what has to become of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Case:
    """A file with words that its report must have."""

    file: Path
    says: str = ""  # a part of the repairs, the notes, or the reason of the refusal; "" for anything
    refused: bool | None = False  # None: either is right


# Writes a file below a folder and returns the case.
Maker = Callable[[Path], Case]
MAKERS: list[Maker] = []


def makes(name: str, says: str = "", *, refused: bool | None = False) -> Callable[[Callable[[Path], object]], Maker]:
    """Register a function that writes the file of this name."""

    def register(write: Callable[[Path], object]) -> Maker:
        def make(folder: Path) -> Case:
            file = folder / name.partition(".")[0] / name
            file.parent.mkdir(parents=True, exist_ok=True)
            write(file)
            return Case(file, says, refused)

        MAKERS.append(make)
        return make

    return register
