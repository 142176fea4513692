"""The XML of a picture of Pascal VOC."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape

_SOURCE = "usdsdg"


@dataclass(frozen=True)
class VocObject:
    """One object of a picture."""

    instance: int
    name: str
    box: tuple[int, int, int, int]  # first and last column and row, counted from 1
    truncated: bool
    occluded: bool
    difficult: bool

    def lines(self) -> list[str]:
        """Return its part of the XML."""
        flags = {name: int(getattr(self, name)) for name in ("truncated", "occluded", "difficult")}
        sides = dict(zip(("xmin", "ymin", "xmax", "ymax"), self.box))
        return [
            "\t<object>",
            f"\t\t<name>{escape(self.name)}</name>",
            "\t\t<pose>Unspecified</pose>",
            *(f"\t\t<{name}>{value}</{name}>" for name, value in flags.items()),
            "\t\t<bndbox>",
            *(f"\t\t\t<{side}>{value}</{side}>" for side, value in sides.items()),
            "\t\t</bndbox>",
            "\t</object>",
        ]


def text(folder: str, file: str, size: tuple[int, int], objects: Sequence[VocObject]) -> str:
    """Return the XML of a picture. folder: name of the dataset; file: of the picture; size: width and height."""
    lines = [
        "<annotation>",
        f"\t<folder>{escape(folder)}</folder>",
        f"\t<filename>{escape(file)}</filename>",
        "\t<source>",
        *(f"\t\t<{name}>{_SOURCE}</{name}>" for name in ("database", "annotation", "image")),
        "\t</source>",
        "\t<size>",
        f"\t\t<width>{size[0]}</width>",
        f"\t\t<height>{size[1]}</height>",
        "\t\t<depth>3</depth>",
        "\t</size>",
        "\t<segmented>1</segmented>",
        *(line for each in objects for line in each.lines()),
        "</annotation>",
    ]
    return "\n".join(lines) + "\n"
