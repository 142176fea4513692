"""The content of a dataset, independent of the writer that made it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from usdsdg.datasets.folder import Folder
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.seen_object import SeenObject


@dataclass
class Frame:
    """One image with its labels. `part` is the dataset's folder below the inspected one, "" for that itself.

    `labeled` is False if no labels could be read.
    """

    part: str
    folder: Folder
    seen: Seen
    objects: list[SeenObject] = field(default_factory=list)
    labeled: bool = False

    @property
    def name(self) -> str:
        """The name of the image below the inspected folder."""
        return self.path(self.seen.name)

    @property
    def view(self) -> str:
        """The render product, with the folder of its dataset."""
        return self.path(self.seen.view)

    def path(self, inside: str) -> str:
        """Return a path below the inspected folder."""
        return "/".join(filter(None, (self.part, inside)))


@dataclass(frozen=True)
class Problem:
    """Something wrong or odd: `kind` is the group, `text` names the file; `frame` is the frame to show."""

    kind: str
    text: str
    frame: str | None = None


@dataclass
class Dataset:
    """Everything found below a folder. `unshown` counts the files that the page does not draw, by kind."""

    path: Path
    writers: list[str] = field(default_factory=list)
    frames: list[Frame] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    metadata: dict[str, Any] = field(default_factory=dict)
    unshown: dict[str, int] = field(default_factory=dict)

    def note(self, text: str) -> None:
        """Add a note, once."""
        if text not in self.notes:
            self.notes.append(text)

    def problem(self, problem: Problem) -> None:
        """Add a problem, once."""
        if problem not in self.problems:
            self.problems.append(problem)
