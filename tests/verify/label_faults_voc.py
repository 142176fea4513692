"""Kinds of label faults of Pascal VOC."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

from tests.verify.label_faults import edit_text, kind, stale


def _shifted(found: re.Match) -> str:
    return f"{found[1]}{int(found[2]) - 1}{found[3]}"


@kind("boxes counted from 0", "voc")
def _(folder: Path) -> None:
    edit_text(folder, "Annotations/*.xml", lambda text: re.sub(r"(<[xy](?:min|max)>)(\d+)(<)", _shifted, text))


@kind("truncated and occluded swapped", "voc")
def _(folder: Path) -> None:
    edit_text(
        folder,
        "Annotations/*.xml",
        lambda text: text.replace("truncated", "?").replace("occluded", "truncated").replace("?", "occluded"),
    )


@kind("no object is difficult", "voc")
def _(folder: Path) -> None:
    edit_text(
        folder, "Annotations/*.xml", lambda text: text.replace("<difficult>1</difficult>", "<difficult>0</difficult>")
    )


@kind("names of two classes swapped in the XML", "voc")
def _(folder: Path) -> None:
    edit_text(
        folder,
        "Annotations/*.xml",
        lambda text: text.replace(">mug<", ">?<").replace(">can<", ">mug<").replace(">?<", ">can<"),
    )


@kind("stale segments of objects", "voc")
def _(folder: Path) -> None:
    first, second, *_ = sorted(folder.glob("SegmentationObject/Replicator_0*.png")) or sorted(
        folder.glob("SegmentationObject/*.png")
    )
    shutil.copy(first, second)


@kind("indices of classes counted from 0", "voc")
def _(folder: Path) -> None:
    for path in folder.glob("SegmentationClass/*.png"):
        with Image.open(path) as image:
            palette, indices = image.getpalette(), np.array(image)
        made = Image.fromarray(np.where(indices > 0, indices - 1, 0).astype(np.uint8), "P")
        made.putpalette(palette)
        made.save(path)


@kind("segments without a palette", "voc")
def _(folder: Path) -> None:
    for path in folder.glob("SegmentationClass/*.png"):
        with Image.open(path) as image:
            indices = np.array(image)
        Image.fromarray(indices).save(path)


@kind("pictures that are in both parts", "voc")
def _(folder: Path) -> None:
    edit_text(folder, "ImageSets/Main/val.txt", lambda text: text + (folder / "ImageSets/Main/train.txt").read_text())


@kind("lists of classes of others", "voc")
def _(folder: Path) -> None:
    edit_text(folder, "ImageSets/Main/mug_*.txt", lambda text: text.replace(" 1", " -1"))


def _objects(folder: Path, change: Callable[[list[str]], list[str]]) -> None:
    """Change the objects of every XML, in their order."""

    def edit(text: str) -> str:
        first, *found = re.split(r"(?=\t<object>)", text.removesuffix("</annotation>\n"))
        return first + "".join(change(found)) + "</annotation>\n"

    edit_text(folder, "Annotations/*.xml", edit)


def _recolor(folder: Path, pattern: str, change: Callable[[np.ndarray], np.ndarray]) -> None:
    """Change the palettes of pictures, (256, 3)."""
    for path in folder.glob(pattern):
        with Image.open(path) as image:
            palette, made = np.array(image.getpalette(), np.uint8).reshape(-1, 3), image.copy()
        made.putpalette(change(palette).ravel().tolist())
        made.save(path)


@kind("an object dropped from the XML", "voc")
def _(folder: Path) -> None:
    _objects(folder, lambda found: found[:-1])


@kind("an object twice in the XML", "voc")
def _(folder: Path) -> None:
    _objects(folder, lambda found: [*found, *found[:1]])


@kind("objects in another order than their segments", "voc")
def _(folder: Path) -> None:
    _objects(folder, lambda found: found[::-1])


@kind("last column and row behind the box", "voc")
def _(folder: Path) -> None:
    edit_text(
        folder,
        "Annotations/*.xml",
        lambda text: re.sub(r"(<[xy]max>)(\d+)(<)", lambda found: f"{found[1]}{int(found[2]) + 1}{found[3]}", text),
    )


@kind("width and height swapped in the XML", "voc")
def _(folder: Path) -> None:
    edit_text(
        folder,
        "Annotations/*.xml",
        lambda text: text.replace("width>", "?>").replace("height>", "width>").replace("?>", "height>"),
    )


@kind("the file of another picture in the XML", "voc")
def _(folder: Path) -> None:
    edit_text(folder, "Annotations/*1.xml", lambda text: text.replace("1.png<", "0.png<"))


@kind("colors of indices as BGR", "voc")
def _(folder: Path) -> None:
    _recolor(folder, "SegmentationObject/*.png", lambda palette: palette[:, ::-1])


@kind("classes of indices in another order", "voc")
def _(folder: Path) -> None:
    def turn(text: str) -> str:
        head, background, *rows = text.splitlines(keepends=True)
        names = [row.partition(":") for row in rows]
        return head + background + "".join(f"{other[0]}:{row[2]}" for row, other in zip(names, names[::-1]))

    edit_text(folder, "labelmap.txt", turn)


@kind("another color of a class in the table", "voc")
def _(folder: Path) -> None:
    edit_text(folder, "labelmap.txt", lambda text: text.replace("128,128,0:", "128,129,0:"))


@kind("XML of the picture before", "voc")
def _(folder: Path) -> None:
    stale(folder, "Annotations/*0{}.xml")


@kind("a list without the last picture", "voc")
def _(folder: Path) -> None:
    edit_text(folder, "ImageSets/Segmentation/train.txt", lambda text: text[: text.rstrip().rfind("\n") + 1])


@kind("a list with a picture that is not there", "voc")
def _(folder: Path) -> None:
    edit_text(folder, "ImageSets/Main/val.txt", lambda text: text + "Replicator_000099\n")
