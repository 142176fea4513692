"""`rep.open_dataset`: a folder of labeled pictures, as a notebook looks at it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from PIL import ImageColor

from usdsdg.datasets.seen_object import SeenObject
from usdsdg.errors import counted
from usdsdg.inspect import statistics
from usdsdg.inspect.dataset import read_dataset
from usdsdg.inspect.records import Frame
from usdsdg.notebook import html
from usdsdg.pictures.overlays import LINE, written_names
from usdsdg.pictures.picture import Picture
from usdsdg.writers.formats.shapes.drawing import Canvas, Color

# Thumbnails of a page, and their width.
_THUMBNAILS, _WIDTH = 6, 260


class OpenedDataset:
    """The images of a dataset in any format that a writer makes, in the order of their names.

    `dataset[3]` is the fourth picture with its labels drawn in; a notebook shows counts and thumbnails.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self._read = read_dataset(Path(folder))
        self._classes = {each["name"]: each for each in statistics.classes(self._read)}

    @property
    def path(self) -> Path:
        """The folder."""
        return self._read.path

    @property
    def formats(self) -> list[str]:
        """The names of the writers that made it."""
        return list(self._read.writers)

    @property
    def counts(self) -> dict[str, int]:
        """How many objects there are of each label, the most frequent first."""
        return {name: each["objects"] for name, each in self._classes.items()}

    @property
    def problems(self) -> list[str]:
        """What is broken or odd; `usdsdg verify` tells more."""
        return [each.text for each in self._read.problems]

    def objects(self, index: int) -> list[SeenObject]:
        """Return what the labels of an image say about its objects."""
        return list(self._read.frames[index].objects)

    def __len__(self) -> int:
        return len(self._read.frames)

    def __getitem__(self, index: int) -> Picture:
        """Return an image with its labels drawn in; gray where the dataset has no picture.

        Raises:
            IndexError: there is no such image.
        """
        frame = self._read.frames[index]
        return Picture(self._drawn(frame))

    def __iter__(self) -> Iterator[Picture]:
        return (self[index] for index in range(len(self)))

    def __repr__(self) -> str:
        return f"OpenedDataset({str(self.path)!r}, {counted(len(self), 'image')}, {self._objects})"

    def _repr_html_(self) -> str:
        about = f"{counted(len(self), 'image')} of {', '.join(self.formats)}, {self._objects}"
        rows = [(name, each["objects"], each["frames"]) for name, each in self._classes.items()]
        chosen = np.unique(np.linspace(0, len(self) - 1, _THUMBNAILS).astype(int)).tolist()
        shown = [
            html.image(np.asarray(self[i].thumbnail(_WIDTH))) + html.note(self._read.frames[i].name) for i in chosen
        ]
        count = counted(len(self.problems), "problem")
        problems = html.note(f"{count}: {'; '.join(self.problems[:3])}") if self.problems else ""
        table = html.table(("label", "objects", "images"), rows) if rows else html.note("no objects")
        return html.title(str(self.path), about) + html.row([table, *shown]) + problems

    @property
    def _objects(self) -> str:
        return counted(sum(self.counts.values()), "object")

    def _drawn(self, frame: Frame) -> np.ndarray:
        seen = frame.seen.complete()
        if seen.colors:
            pixels = _colored(seen.colors[0].image)
        else:
            width, height = seen.size or (640, 480)
            pixels = np.full((height, width, 3), 96, np.uint8)
        canvas = Canvas(pixels)
        places: list[tuple[float, float] | None] = []
        colors = [self._color(each.label) for each in frame.objects]
        for each, color in zip(frame.objects, colors):
            lines = list(_lines(each))
            for start, end in lines:
                canvas.line(start, end, color, width=LINE)
            places.append((min(a[0] for a, _ in lines), min(a[1] for a, _ in lines)) if lines else None)
        return written_names(canvas.image(), places, [each.label for each in frame.objects], colors)

    def _color(self, label: str) -> Color:
        red, green, blue = ImageColor.getrgb(self._classes[label]["color"])[:3]
        return red, green, blue


def open_dataset(folder: str | os.PathLike[str]) -> OpenedDataset:
    """Open a dataset in any format that a writer makes, to look at its images with their labels drawn in.

    Raises:
        DatasetError: the folder is missing, or nothing in it is recognized; lists what was looked for.
    """
    return OpenedDataset(folder)


def _colored(image: np.ndarray) -> np.ndarray:
    if image.ndim == 2:
        image = np.repeat(image[..., None], 3, axis=2)
    return np.ascontiguousarray(image[..., :3])


def _lines(seen: SeenObject) -> Iterator[tuple[Any, Any]]:
    """Yield the lines [pixels] that show an object: its outline, else its solid, else its box."""
    if seen.outline:
        for polygon in seen.outline:
            yield from zip(polygon, np.roll(polygon, -1, axis=0))
    elif seen.edges is not None:
        for x0, y0, x1, y1 in seen.edges:
            yield np.array([x0, y0]), np.array([x1, y1])
    elif (box := seen.box or seen.loose) is not None:
        corners = np.array([(box[0], box[1]), (box[2], box[1]), (box[2], box[3]), (box[0], box[3])])
        yield from zip(corners, np.roll(corners, -1, axis=0))
