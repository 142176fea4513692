"""The parts of a dataset that are still to be made, so that several processes can make them."""

from __future__ import annotations

import itertools
import os
import re
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from usdsdg.errors import DatasetError
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.stores.whole_file import write_whole
from usdsdg.writers.journal import journal
from usdsdg.writers.journal.folders import AGGREGATES
from usdsdg.writers.journal.journal import NAME, Journal
from usdsdg.writers.journal.merge import parts_of
from usdsdg.writers.journal.places.place import JOINED, PARTS, Place
from usdsdg.writers.journal.recipe import CLASS_FILE, CLASSES

_FRAMES = re.compile(r"(\d+)-(\d+)")


@dataclass(frozen=True)
class Part:
    """The frames from `first` up to `last`, without `last`."""

    first: int
    last: int

    @property
    def frames(self) -> str:
        """The value of --frames."""
        return f"{self.first}:{self.last}"


def plan(places: Sequence[Place], frames: int, count: int, *, unit: int = 1) -> list[Part]:
    """Return the parts that are not complete in every place, in the order of frames.

    frames: of the dataset. count: into how many parts what no process has begun is cut. unit: frames
    that are best made by one process.

    Raises:
        DatasetError: a place has shards that are no frames in a row, or parts with frames that the dataset lacks.
    """
    begun: dict[Part, bool] = {}  # whether it is complete
    for place in places:
        place.pull()
    places = [place for place in places if not _is_joined(place.path)]
    _keep_as_parts(places)
    for place in places:
        place.push(whole=True)
    folders = [place.path for place in places if not _is_whole(place.path / PARTS / f"0-{frames}" / NAME)]
    if not folders:
        return []
    where = places[0].name
    names = {part.name for folder in folders for part in parts_of(folder)}
    for name in names:
        match = _FRAMES.fullmatch(name)
        if match is None or int(match[2]) > frames:
            raise DatasetError(f"{where} has the part {name}, which is none of --workers; merge it or --overwrite")
        files = [folder / PARTS / name / NAME for folder in folders]
        is_complete = all(map(_is_whole, files))
        begun[Part(int(match[1]), int(match[2]))] = is_complete
    gaps, end = [], 0
    for part in sorted(begun, key=lambda each: each.first):
        if part.first < end:
            raise DatasetError(f"{where} has parts that overlap at frame {part.first}; begin again with --overwrite")
        gaps.append(Part(end, part.first))
        end = part.last
    gaps.append(Part(end, frames))
    new = [piece for gap in gaps for piece in _cut(gap, count, frames, unit)]
    return sorted(
        [*new, *(part for part, is_complete in begun.items() if not is_complete)], key=lambda each: each.first
    )


def _cut(gap: Part, count: int, frames: int, unit: int) -> list[Part]:
    """Cut frames into parts as large as if the whole dataset were cut into `count`."""
    first, last = -(-gap.first // unit), -(-gap.last // unit)  # in units
    pieces = min(last - first, max(1, round(count * (gap.last - gap.first) / max(frames, 1))))
    if gap.first >= gap.last:
        return []
    inner = [(first + (last - first) * place // pieces) * unit for place in range(1, pieces)] if pieces > 0 else []
    edges = [gap.first, *(each for each in inner if gap.first < each < gap.last), gap.last]
    return [Part(first, last) for first, last in itertools.pairwise(edges)]


def _keep_as_parts(places: Sequence[Place]) -> None:
    """Make the frames of one process that died a part, so that others can make the rest.

    It ends at the same frame in each place; where a journal ends before, the part is one to be resumed.
    """
    ends = [(place, end) for place in places if (end := _end_of_one_process(place.path))]
    last = max((end for _, end in ends), default=0)
    for place, end in ends:
        own, home = place.path / BESIDE / NAME, place.path / PARTS / f"0-{last}"
        home.mkdir(parents=True, exist_ok=True)
        if (place.path / BESIDE / AGGREGATES).is_dir():
            shutil.move(place.path / BESIDE / AGGREGATES, home / AGGREGATES)
        if (classes := place.read(CLASSES)) is not None:
            write_whole(home / CLASS_FILE, classes)
        shutil.copyfile(own, home / NAME)
        if end == last:
            Journal(home / NAME).close(complete=True)
        os.truncate(own, 0)


def _end_of_one_process(folder: Path) -> int:
    """Return the frame after the last one that a process without parts has left; 0: there is none."""
    own = folder / BESIDE / NAME
    if not own.is_file():
        return 0
    contents = journal.read(own)
    in_parts = {frame for part in parts_of(folder) for frame in journal.read(part / NAME).frames}
    if contents.frames and contents.frames == in_parts:
        shutil.rmtree(folder / BESIDE / AGGREGATES, ignore_errors=True)  # of a process that died while it joined them
        os.truncate(own, 0)
        return 0
    if contents.frames > in_parts:
        shutil.rmtree(folder / PARTS, ignore_errors=True)  # of one that died while it removed those that it had joined
    return contents.end


def drop_others(place: Place, frames: int) -> None:
    """Remove what processes have made for other datasets' sake in a place of which all `frames` were there before."""
    place.pull()
    parts = place.path / PARTS
    others = [each for each in parts_of(place.path) if each.name != f"0-{frames}"]
    if others and ((place.path / JOINED).is_dir() or _is_whole(parts / f"0-{frames}" / NAME)):
        for each in [parts] if (place.path / JOINED).is_dir() else others:
            shutil.rmtree(each, ignore_errors=True)
        place.push()


def _is_joined(folder: Path) -> bool:
    """Return whether a process died that had joined the parts, and not closed the journal yet."""
    return (folder / JOINED).is_dir() and not parts_of(folder)


def _is_whole(file: Path) -> bool:
    """Return whether the journal of a part is there and complete."""
    return file.is_file() and journal.read(file).is_complete
