"""The content of a dataset, independent of the writer that made it."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from usdsdg.datasets.seen_object import SeenObject


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
