"""COCO: the annotation files list every picture that is there. What is in no file would be lost to a training."""

from __future__ import annotations

from collections.abc import Set
from pathlib import PurePosixPath

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.folder import Folder
from usdsdg.writers.formats.coco.files import Names, names_of

_PICTURES = (".png", ".jpg", ".jpeg")


def check(folder: Folder, listed: Set[str]) -> Faults:
    """Check the pictures in the folders of annotation files. listed: those that annotation files list."""
    broken = {fault.file for fault in folder.faults}  # of which it is not known what they list
    for file in folder.files:
        names = names_of(file)
        if names is None or file in broken:
            continue
        for picture in folder.files:
            if picture not in listed and _is_picture(names, picture):
                yield Fault(file, PurePosixPath(picture).stem, f"{picture} is not in `images`")


def _is_picture(names: Names, file: str) -> bool:
    return PurePosixPath(file).suffix.lower() in _PICTURES and names.has_picture(file)
