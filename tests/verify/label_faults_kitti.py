"""Kinds of label faults of KITTI."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.verify.label_faults import edit_image, edit_text, kind


def _kitti(folder: Path, change: Callable[[list[str]], list[str]]) -> None:
    for path in [*folder.glob("*/object_detection/*.txt"), *folder.glob("training/label_2/*.txt")]:
        lines = [" ".join(change(line.split(" "))) for line in path.read_text().splitlines()]
        path.write_text("".join(f"{line}\n" for line in lines))


@kind("uint8 overflow of ids", "kitti")
def _(folder: Path) -> None:
    for path in folder.glob("Left/instance_segmentation/*.png"):
        edit_image(path, lambda ids: (ids & 0xFF).astype(ids.dtype))


@kind("length, width, height for height, width, length", "kitti")
def _(folder: Path) -> None:
    _kitti(folder, lambda fields: [*fields[:8], *fields[10:7:-1], *fields[11:]])


@kind("center for the bottom's center", "kitti")
def _(folder: Path) -> None:
    def raise_(fields: list[str]) -> list[str]:
        fields[12] = f"{float(fields[12]) - float(fields[8]) / 2:.6g}"
        return fields

    _kitti(folder, raise_)


@kind("rotation to the other side", "kitti")
def _(folder: Path) -> None:
    def turn(fields: list[str]) -> list[str]:
        fields[3], fields[14] = f"{-float(fields[3]):.6g}", f"{-float(fields[14]):.6g}"
        return fields

    _kitti(folder, turn)


@kind("nothing is occluded", "kitti")
def _(folder: Path) -> None:
    _kitti(folder, lambda fields: [*fields[:2], "0", *fields[3:]])


@kind("steps of a millimeter in depth images", "kitti")
def _(folder: Path) -> None:
    for path in folder.glob("Left/depth/*.png"):
        edit_image(path, lambda depth: (depth.astype(float) / 256 * 1000).astype(np.uint16))


@kind("stale semantic ids", "kitti")
def _(folder: Path) -> None:
    for name in ("semantic", "semantic_segmentation"):
        shutil.copy(folder / f"Left/{name}/0.png", folder / f"Left/{name}/1.png")


@kind("boxes as x, y, width, height in KITTI", "kitti_plain")
def _(folder: Path) -> None:
    def sizes(fields: list[str]) -> list[str]:
        left, top, right, bottom = map(int, fields[4:8])
        return [*fields[:6], str(right + 1 - left), str(bottom + 1 - top), *fields[8:]]

    _kitti(folder, sizes)


@kind("boxes of KITTI counted from 1", "kitti_plain")
def _(folder: Path) -> None:
    _kitti(folder, lambda fields: [*fields[:4], *(str(int(each) + 1) for each in fields[4:8]), *fields[8:]])


@kind("truncated in percent", "kitti_plain")
def _(folder: Path) -> None:
    _kitti(folder, lambda fields: [fields[0], f"{100 * float(fields[1]):g}", *fields[2:]])


@kind("rotation_y for alpha", "kitti_plain")
def _(folder: Path) -> None:
    _kitti(folder, lambda fields: [*fields[:3], fields[14], *fields[4:]])


@kind("angles in degrees", "kitti_plain")
def _(folder: Path) -> None:
    def degrees(fields: list[str]) -> list[str]:
        fields[3], fields[14] = (f"{np.degrees(float(fields[place])):.6g}" for place in (3, 14))
        return fields

    _kitti(folder, degrees)


@kind("y up and z back in KITTI", "kitti_plain")
def _(folder: Path) -> None:
    def turn(fields: list[str]) -> list[str]:
        fields[12:14] = (f"{-float(each):.6g}" for each in fields[12:14])
        return fields

    _kitti(folder, turn)


@kind("centimeters in KITTI", "kitti_plain")
def _(folder: Path) -> None:
    _kitti(folder, lambda fields: [*fields[:8], *(f"{100 * float(each):.6g}" for each in fields[8:14]), fields[14]])


@kind("two decimals in KITTI", "kitti_plain")
def _(folder: Path) -> None:
    _kitti(folder, lambda fields: [*fields[:8], *(f"{float(each):.2f}" for each in fields[8:])])


@kind("classes of two objects swapped in KITTI", "kitti_plain")
def _(folder: Path) -> None:
    swapped = {"mug": "can", "can": "mug"}
    _kitti(folder, lambda fields: [swapped.get(fields[0], fields[0]), *fields[1:]])


@kind("a line of KITTI dropped", "kitti_plain")
def _(folder: Path) -> None:
    edit_text(folder, "training/label_2/*.txt", lambda text: text[: text.rstrip().rfind("\n") + 1])


@kind("sixteen fields with a score", "kitti_plain")
def _(folder: Path) -> None:
    _kitti(folder, lambda fields: [*fields, "1.00"])


@kind("labels of the other camera", "kitti_plain")
def _(folder: Path) -> None:
    shutil.copy(folder / "training/label_2/000000.txt", folder / "training/label_2/000001.txt")


@kind("pixels from the corner in P2", "kitti_plain")
def _(folder: Path) -> None:
    def move(found: re.Match) -> str:
        values = np.array(found[1].split(), float)
        values[[2, 6]] += 0.5
        return f"{found[0][:2]}: " + " ".join(f"{value:.12e}" for value in values)

    edit_text(folder, "training/calib/*.txt", lambda text: re.sub(r"P\d: (.*)", move, text))


@kind("a focal length of half the size in P2", "kitti_plain")
def _(folder: Path) -> None:
    def halve(found: re.Match) -> str:
        values = np.array(found[1].split(), float)
        values[[0, 5]] /= 2
        return f"{found[0][:2]}: " + " ".join(f"{value:.12e}" for value in values)

    edit_text(folder, "training/calib/*.txt", lambda text: re.sub(r"P\d: (.*)", halve, text))


@kind("pictures of KITTI in both parts", "kitti_plain")
def _(folder: Path) -> None:
    edit_text(folder, "ImageSets/val.txt", lambda text: text + (folder / "ImageSets/train.txt").read_text())


@kind("a picture of KITTI in no part", "kitti_plain")
def _(folder: Path) -> None:
    edit_text(folder, "ImageSets/train.txt", lambda text: text[7:])


@kind("a picture in a part of KITTI that is not there", "kitti_plain")
def _(folder: Path) -> None:
    edit_text(folder, "ImageSets/val.txt", lambda text: text + "000099\n")
