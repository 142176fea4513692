"""The files of textures, light profiles and materials that were read in this process, for the recipe of a dataset."""

from __future__ import annotations

from pxr import Ar

_files: dict[str, None] = {}


def note_opened(path: str) -> None:
    """Note that a file was read; one in a package stands for its package."""
    _files.setdefault(Ar.SplitPackageRelativePathOuter(path)[0] if "[" in path else path)


def opened_since(count: int) -> list[str]:
    """Return the files that were read first after `count` others, oldest first."""
    return list(_files)[count:] if len(_files) > count else []
