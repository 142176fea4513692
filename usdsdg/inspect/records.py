"""The content of a dataset, independent of the writer that made it."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

# Order of a cuboid's points in this package, and its edges as pairs of indices; the first four edges are those of the
# face with the smallest local x.
CORNERS = ("LDB", "LDF", "LUB", "LUF", "RDB", "RDF", "RUB", "RUF")
KEYPOINTS = ("Center", *CORNERS)
EDGES = ((1, 2), (2, 4), (4, 3), (3, 1), (5, 6), (6, 8), (8, 7), (7, 5), (1, 5), (2, 6), (3, 7), (4, 8))


@dataclass
class SeenObject:
    """One object in one image. Pixel coordinates are continuous: the center of the first pixel is (0.5, 0.5).

    box, loose   (x_min, y_min, x_max, y_max) of the visible part, of the whole object
    cuboid       (9, 2) pixels in the order of KEYPOINTS; None if unknown
    edges        (n, 4) pixels of the parts in front of the camera, if the cuboid extends behind it
    axes         (4, 2) pixels: center, then the centers of the faces toward local +x, +y, +z
    distance     meters from the camera; visibility and truncation are fractions 0…1
    """

    label: str
    prim_path: str = ""
    box: tuple[float, float, float, float] | None = None
    loose: tuple[float, float, float, float] | None = None
    cuboid: np.ndarray | None = None
    edges: np.ndarray | None = None
    axes: np.ndarray | None = None
    distance: float | None = None
    visibility: float | None = None
    truncation: float | None = None

    @property
    def size(self) -> float | None:
        """Side [px] of a square with the area of the visible box, or else of the amodal one."""
        box = self.box or self.loose
        return None if box is None else float(np.sqrt(max(0.0, box[2] - box[0]) * max(0.0, box[3] - box[1])))


@dataclass
class Frame:
    """One image with its labels. `labeled` is False if no label file could be read."""

    view: str
    number: str
    picture: Path | None = None
    layers: dict[str, Path] = field(default_factory=dict)
    objects: list[SeenObject] = field(default_factory=list)
    labeled: bool = False

    @property
    def name(self) -> str:
        return f"{self.view}/{self.number}" if self.view else self.number


@dataclass(frozen=True)
class Problem:
    """Something wrong or odd: `kind` is the group, `text` names the file; `frame` is the frame to show."""

    kind: str
    text: str
    frame: str | None = None


@dataclass
class Dataset:
    """Everything found below a folder. `unshown` counts the files that the page does not draw, by kind."""

    folder: Path
    writers: list[str] = field(default_factory=list)
    frames: list[Frame] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    metadata: dict[str, Any] = field(default_factory=dict)
    unshown: dict[str, int] = field(default_factory=dict)
