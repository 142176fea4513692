"""Reading of all images of a folder, whatever their formats."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Protocol

from usdsdg.datasets.attempt import UNREADABLE, attempt, attempt_each
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.formats import (
    basic,
    bop,
    coco,
    cosmos,
    cvat,
    dope,
    drawn,
    kitti,
    parquet,
    pose,
    voc,
    webdataset,
    ycb_video,
    yolo,
)  # fmt: skip
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.seen_object import SeenObject


class Format(Protocol):
    """What a module of `usdsdg.datasets.formats` has: the reading that both `usdsdg verify` and `inspect` use."""

    @property
    def NAME(self) -> str:
        """The name of the writer."""
        ...

    def read(self, folder: Folder, files: list[str], /) -> Iterator[Seen]:
        """Yield what the files of each image say. `files` are those that belong to no other format.

        What needs pixels is read by `Seen.later`.
        """
        ...

    def objects(self, seen: Seen, /) -> list[SeenObject]:
        """Return the objects of an image, as its labels have them, without looking at pixels."""
        ...


# COCO's and Cosmos's names contain those of BasicWriter, and DOPE's are those of PoseWriter, so they come first.
FORMATS: tuple[Format, ...] = (
    coco, voc, cvat, cosmos, bop, yolo, webdataset, parquet, kitti, ycb_video, drawn, basic, dope, pose,
)  # fmt: skip


def images(folder: Folder, read: set[str]) -> Iterator[Seen]:
    """Yield every image of every format; a file belongs to the first format that knows it.

    read: gets the files of the images.
    """
    for each in FORMATS:
        found = each.read(folder, [file for file in folder.files if file not in read])
        what = f"{UNREADABLE} as a file of {each.NAME}"
        for seen in attempt_each(folder.faults, lambda: folder.in_hand, "?", what, found):
            read.update(seen.files)
            seen.steps = [partial(_attempted, folder, step) for step in seen.steps]
            yield seen


def _attempted(folder: Folder, step: Callable[[Seen], None], seen: Seen) -> None:
    """Do a step of the reading, which may meet anything in files."""
    what = f"{UNREADABLE} as a file of {seen.format}"
    attempt(folder.faults, lambda: folder.in_hand, seen.name, what, lambda: step(seen))


def objects_of(seen: Seen) -> list[SeenObject]:
    """Return the objects of an image of any format."""
    return next(each for each in FORMATS if seen.format == each.NAME).objects(seen)
