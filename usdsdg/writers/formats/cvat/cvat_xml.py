"""The XML of CVAT for images 1.1: shapes of each picture, and the labels of the task."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from xml.sax.saxutils import quoteattr

import numpy as np

from usdsdg.writers.aggregate import Aggregate, Texts
from usdsdg.writers.formats.cvat import files
from usdsdg.writers.spool import Records

INSTANCE = "instance"  # the attribute of every shape that says which object it is of


class CvatFile(Aggregate):
    """The pictures of a task with their shapes.

    A record has the "name" of a picture as the task has it, its "size" (width and height), and the "shapes" as XML. Of
    all frames are known the "labels", with "name" and "color" #rrggbb.
    """

    @staticmethod
    def files(records: Records) -> dict[str, Texts]:
        return {files.ANNOTATIONS: partial(_texts, records)}


def _texts(records: Records) -> Iterator[str]:
    labels = "".join(
        f"        <label>\n          <name>{_text(each['name'])}</name>\n          <color>{each['color']}</color>\n"
        f"          <type>any</type>\n          <attributes>\n{_ATTRIBUTE}          </attributes>\n"
        "        </label>\n"
        for each in records.about["labels"]
    )
    yield (
        '<?xml version="1.0" encoding="utf-8"?>\n<annotations>\n  <version>1.1</version>\n  <meta>\n    <task>\n'
        f"      <name>usdsdg</name>\n      <size>{records.count}</size>\n      <mode>annotation</mode>\n"
        f"      <overlap>0</overlap>\n      <start_frame>0</start_frame>\n"
        f"      <stop_frame>{records.count - 1}</stop_frame>\n      <labels>\n{labels}      </labels>\n"
        "    </task>\n  </meta>\n"
    )
    # As CVAT numbers the pictures of a task: in the order of their names.
    for number, each in enumerate(records.ordered_by("name")):
        name, (width, height) = quoteattr(each["name"]), each["size"]
        yield f'  <image id="{number}" name={name} width="{width}" height="{height}">\n'
        yield from each["shapes"]
        yield "  </image>\n"
    yield "</annotations>\n"


_ATTRIBUTE = f"""            <attribute>
              <name>{INSTANCE}</name>
              <mutable>False</mutable>
              <input_type>text</input_type>
              <default_value></default_value>
              <values></values>
            </attribute>
"""


def box(label: str, edges: tuple[int, int, int, int], *, instance: int, occluded: bool) -> str:
    """Return a rectangle. edges: left, top, right and bottom edge [pixels]."""
    sides = " ".join(f'{name}="{value}.00"' for name, value in zip(("xtl", "ytl", "xbr", "ybr"), edges))
    return _shape("box", label, sides, instance, occluded)


def polygon(label: str, corners: np.ndarray, *, instance: int, occluded: bool, group: int) -> str:
    """Return a polygon of corners (N, 2) [pixels]; group: from 1, the same for all parts of an object; 0: none."""
    points = ";".join(f"{x:.2f},{y:.2f}" for x, y in corners.tolist())
    return _shape("polygon", label, f'points="{points}"', instance, occluded, group)


def mask(label: str, pixels: np.ndarray, corner: tuple[int, int], *, instance: int, occluded: bool) -> str:
    """Return a mask. pixels: (h, w) bool, of the object's box; corner: its first column and row."""
    flat = pixels.ravel()
    ends = np.flatnonzero(np.concatenate([flat[1:] != flat[:-1], [True]])) + 1
    lengths = np.diff(ends, prepend=0).tolist()
    # Along the rows of the box, first of pixels outside, then inside, ...
    runs = ", ".join(map(str, [0, *lengths] if flat[0] else lengths))
    (left, top), (height, width) = corner, pixels.shape
    described = f'rle="{runs}" left="{left}" top="{top}" width="{width}" height="{height}"'
    return _shape("mask", label, described, instance, occluded)


def _shape(kind: str, label: str, described: str, instance: int, occluded: bool, group: int = 0) -> str:
    grouped = f' group_id="{group}"' if group else ""
    flags = f'source="file" occluded="{int(occluded)}"'
    return (
        f'    <{kind} label={quoteattr(label)} {flags} {described} z_order="0"{grouped}>\n'
        f'      <attribute name="{INSTANCE}">{instance}</attribute>\n'
        f"    </{kind}>\n"
    )


def _text(name: str) -> str:
    return quoteattr(name)[1:-1]
