"""An earlier run in an output folder: what becomes of it, and whether another one may write there."""

from __future__ import annotations

import shlex
from enum import Enum
from pathlib import Path

from usdsdg.errors import DatasetInTheWay, WriterError
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.writers.journal import journal, recipe
from usdsdg.writers.journal.earlier_files import has_frames, is_half_removed
from usdsdg.writers.journal.growth import MoreFrames, advice
from usdsdg.writers.journal.journal import NAME, Contents
from usdsdg.writers.journal.places.place import PARTS, REMOVING, Place
from usdsdg.writers.journal.portion import Portion
from usdsdg.writers.journal.recipe import SCRIPT, Recipe


class Mode(Enum):
    """What happens to an earlier run in the output folder."""

    NEW = "new"  # it is an error, unless it is a complete one of the same recipe
    RESUME = "resume"  # a run of the same recipe is resumed
    OVERWRITE = "overwrite"  # it is removed
    REPLACE = "replace"  # so is one of the same script


def check_place(
    place: Place,
    wanted: Recipe,
    mode: Mode,
    portion: Portion | None,
    *,
    with_parts: bool = False,
    growth: MoreFrames | None = None,
) -> None:
    """Check that a run may write to a place, of which what is there is known.

    with_parts, growth: as in `DatasetFolder`.

    Raises:
        DatasetInTheWay: another run is there; the message says how to go on.
    """
    path, there = place.path, place.name
    try:
        earlier = recipe.read(path, remedy=f"Remove that run with {_overwriting(wanted)}.")
    except WriterError:
        if mode is Mode.OVERWRITE:
            return
        raise
    if earlier is None:
        if (mode is not Mode.OVERWRITE or portion is not None) and has_frames(place):
            remedy = "remove this one first" if portion is not None else f"remove that run with {_overwriting(wanted)}"
            raise DatasetInTheWay(
                f"{there} has a journal but no {recipe.FILE}, so it is not known of what run its frames are. Put a "
                f"copy of that back, choose another output_dir, or {remedy}."
            )
        if mode is Mode.RESUME and place.has_files() and not (path / BESIDE / REMOVING).is_file():
            raise DatasetInTheWay(
                f"{there} has files but no recipe, so it cannot be resumed. Choose another output_dir, or --overwrite."
            )
        return
    if mode is Mode.RESUME and portion is None and is_half_removed(place, path / BESIDE):
        return  # the earlier run is being removed and has no frame to resume, so its recipe may be another one
    differences = wanted.differences(earlier)
    if portion is not None and mode is not Mode.RESUME:
        _check_room_for_part(path, there, mode, portion, differences)
    if mode is Mode.OVERWRITE:
        return
    name = earlier.get("source", {}).get("name", "?") if isinstance(earlier.get("source"), dict) else "?"
    if mode is Mode.REPLACE and name == wanted.source["name"]:
        return
    growing = growth if mode is Mode.RESUME else None
    if differences and growing is not None and growing.obstacle(place, wanted, earlier, portion) == "":
        return
    if differences:
        listed = "\n  ".join(differences)
        raise DatasetInTheWay(
            f"{there} has a run of another recipe, of {name}:\n  {listed}\n"
            f"{advice(growth, place, wanted, earlier, portion)}Choose another output_dir, or remove that run with "
            f"{_overwriting(wanted)}."
        )
    if mode is Mode.RESUME and portion is None and not with_parts and _has_parts(path):
        raise DatasetInTheWay(
            f"{there} has parts of --workers, --frames or --shard, whose frames a process without these options would "
            "make again. Resume with --workers N --resume, or each part; `usdsdg merge` joins them once all are "
            "whole. --overwrite begins again."
        )
    if mode is Mode.NEW and not _is_complete(path, portion):
        raise DatasetInTheWay(
            f"{there} has an unfinished run of this recipe. Resume it with --resume, begin again with --overwrite, or "
            "choose another output_dir."
        )


def _overwriting(wanted: Recipe) -> str:
    """Return what the user says to have an earlier run removed: a script that Python runs has no options."""
    return f"usdsdg run --overwrite {shlex.quote(wanted.source['name'])}" if wanted.command == SCRIPT else "--overwrite"


def _check_room_for_part(path: Path, there: str, mode: Mode, portion: Portion, differences: list[str]) -> None:
    """Check that a part would not be mixed with another run: a process of a part removes that part alone."""
    journals = (each for each in (path / PARTS).glob(f"*/{NAME}") if each.stat().st_size)
    others = [each for each in journals if each.parent.name != portion.name]
    if (path / BESIDE / NAME).is_file() and journal.read(path / BESIDE / NAME).frames:
        what = "a run that is not in parts. "
    elif differences and (mode is Mode.OVERWRITE or (mode is Mode.REPLACE and others)):
        what = "parts of another recipe:\n  " + "\n  ".join(differences) + "\n"
    else:
        return
    raise DatasetInTheWay(
        f"{there} has {what}A process that makes a part of a dataset would leave its files there. Choose another "
        "output_dir, or remove this one first."
    )


def _has_parts(path: Path) -> bool:
    """Return whether there is a part with frames."""
    return any(journal.read(each).frames for each in (path / PARTS).glob(f"*/{NAME}"))


def _is_complete(path: Path, portion: Portion | None) -> bool:
    """Return whether nothing would be lost that takes long to make again: there is a whole run, or nothing at all."""
    own = path / PARTS / portion.name / NAME if portion is not None else path / BESIDE / NAME
    found = journal.read(own) if own.is_file() else Contents()
    if portion is None and any((path / PARTS).glob(f"*/{NAME}")):
        return False
    return found.is_complete or not (found.frames or found.shared)
