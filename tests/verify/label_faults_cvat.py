"""Kinds of label faults of CVAT for images."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.verify.label_faults import edit_json, edit_text, kind


def _cvat(folder: Path, pattern: str, change: Callable[[re.Match], str]) -> None:
    edit_text(folder, "annotations.xml", lambda text: re.sub(pattern, change, text))


@kind("masks one pixel lower", "cvat")
def _(folder: Path) -> None:
    _cvat(folder, r'top="(\d+)"', lambda found: f'top="{max(int(found[1]) - 1, 0)}"')


@kind("run lengths that begin inside", "cvat")
def _(folder: Path) -> None:
    def turn(found: re.Match) -> str:
        lengths = [int(each) for each in found[1].split(",")]
        return f'rle="{", ".join(map(str, [0, *lengths] if lengths[0] else lengths[1:]))}"'

    _cvat(folder, r'rle="([^"]+)"', turn)


@kind("labels of shapes that the task has not", "cvat")
def _(folder: Path) -> None:
    _cvat(folder, r'label="mug"', lambda found: 'label="cup"')


@kind("occluded flags turned", "cvat")
def _(folder: Path) -> None:
    _cvat(folder, r'occluded="(\d)"', lambda found: f'occluded="{1 - int(found[1])}"')


@kind("instances of the next object", "cvat")
def _(folder: Path) -> None:
    _cvat(folder, r'name="instance">(\d+)<', lambda found: f'name="instance">{int(found[1]) + 1}<')


@kind("shapes of the picture before", "cvat")
def _(folder: Path) -> None:
    names = iter(
        sorted(path.name for path in (folder / "images").iterdir())[-1:]
        + sorted(path.name for path in (folder / "images").iterdir())
    )
    _cvat(folder, r'(<image id="\d+" name=)"[^"]+"', lambda found: f'{found[1]}"{next(names)}"')


@kind("polygons with y before x", "cvat_polygons")
def _(folder: Path) -> None:
    def swap(found: re.Match) -> str:
        return 'points="' + ";".join(",".join(pair.split(",")[::-1]) for pair in found[1].split(";")) + '"'

    _cvat(folder, r'points="([^"]+)"', swap)


@kind("a shape dropped", "cvat_polygons")
def _(folder: Path) -> None:
    edit_text(
        folder, "annotations.xml", lambda text: re.sub(r"    <polygon.*?</polygon>\n", "", text, count=1, flags=re.S)
    )


@kind("run lengths down the columns", "cvat")
def _(folder: Path) -> None:
    def turn(found: re.Match) -> str:
        lengths, size = [int(each) for each in found[1].split(",")], (int(found[4]), int(found[3]))
        pixels = np.repeat(np.arange(len(lengths)) % 2, lengths).reshape(size).T.ravel()
        ends = np.flatnonzero(np.diff(pixels, append=2)) + 1
        runs = np.diff(ends, prepend=0).tolist()
        return f'rle="{", ".join(map(str, [0, *runs] if pixels[0] else runs))}"{found[2]}'

    _cvat(folder, r'rle="([^"]+)"( left="\d+" top="\d+" width="(\d+)" height="(\d+)")', turn)


@kind("a shape twice", "cvat")
def _(folder: Path) -> None:
    edit_text(
        folder,
        "annotations.xml",
        lambda text: re.sub(r"    <mask.*?</mask>\n", lambda found: found[0] * 2, text, count=1, flags=re.S),
    )


@kind("labels of the task in another order", "cvat")
def _(folder: Path) -> None:
    edit_json(folder / "labels.json", lambda values: values[::-1])


@kind("pictures numbered in another order than their names", "cvat")
def _(folder: Path) -> None:
    count = len(list((folder / "images").iterdir()))
    _cvat(folder, r'<image id="(\d+)"', lambda found: f'<image id="{count - 1 - int(found[1])}"')


@kind("a picture that is not in the task", "cvat")
def _(folder: Path) -> None:
    edit_text(folder, "annotations.xml", lambda text: re.sub(r"  <image.*?</image>\n", "", text, count=1, flags=re.S))


@kind("last column and row for the edges of boxes", "cvat_boxes")
def _(folder: Path) -> None:
    _cvat(folder, r'([xy]br)="([\d.]+)"', lambda found: f'{found[1]}="{float(found[2]) - 1:.2f}"')


@kind("boxes with y before x", "cvat_boxes")
def _(folder: Path) -> None:
    _cvat(folder, r' ([xy])(tl|br)="', lambda found: f' {"y" if found[1] == "x" else "x"}{found[2]}="')


@kind("boxes of objects that are left out", "cvat_boxes")
def _(folder: Path) -> None:
    more = """    <box label="mug" source="file" occluded="1" xtl="3.00" ytl="3.00" xbr="4.00" ybr="4.00" z_order="0">
      <attribute name="instance">99</attribute>
    </box>
"""
    edit_text(folder, "annotations.xml", lambda text: text.replace("  </image>", more + "  </image>", 1))


@kind("polygons from center to center", "cvat_polygons")
def _(folder: Path) -> None:
    def inside(found: re.Match) -> str:
        corners = np.array([pair.split(",") for pair in found[1].split(";")], float)
        corners -= corners == corners.max(axis=0)
        return 'points="' + ";".join(f"{x:.2f},{y:.2f}" for x, y in corners.tolist()) + '"'

    _cvat(folder, r'points="([^"]+)"', inside)
