"""Of what each damaged file of a dataset is made again: of frames, or of the records beside the data."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from usdsdg.datasets.attempt import UNREADABLE, attempt
from usdsdg.errors import WriterError
from usdsdg.record import FRAMES, STAGES, frame_record
from usdsdg.repair.damage import Damage
from usdsdg.verify.integrity.listing import SPOOLS
from usdsdg.writers import aggregates
from usdsdg.writers.formats.shards.remade import ShardedFolder
from usdsdg.writers.journal.portion import Portion
from usdsdg.writers.journal.recipe import SOURCE


@dataclass
class Plan:
    """What is to be made.

    Attributes:
        frames: by damaged file, those that make it.
        spools: by damaged file about all frames, the spool of which it is made.
        source: the copy of the script or configuration, if it is damaged.
        whole: the damaged files for which all frames are made.
    """

    frames: dict[str, frozenset[int]] = field(default_factory=dict)
    spools: dict[str, Path] = field(default_factory=dict)
    source: str = ""
    whole: list[str] = field(default_factory=list)

    @property
    def needs_frames(self) -> bool:
        """Whether any frame is made."""
        return bool(self.frames or self.whole)

    @property
    def numbers(self) -> frozenset[int]:
        """The frames that are made, unless all are."""
        return frozenset().union(*self.frames.values())


def plan(damage: Damage) -> Plan:
    """Return what makes the damaged files of a dataset again, at the least cost that is known."""
    made = Plan()
    is_shared = any(not damage.listing.files[name].frame.isdigit() for name in damage.files)
    spools = _whole_spools(damage) if is_shared else []
    of_spools = {name: spool for spool in spools for name in _paths_of(spool)}
    shared = []
    for name in damage.files:
        frame = damage.listing.files[name].frame
        if frame.isdigit():
            made.frames[name] = frozenset([int(frame)])
        elif name in of_spools:
            made.spools[name] = of_spools[name]
        elif name.startswith(f"{SOURCE}/"):
            made.source = name
        else:
            shared.append(name)
    shards = sharded(damage).frames()
    for name in shared:
        frames = shards.get(name)
        if frames is not None:
            made.frames[name] = frames
        elif name in shards or name.startswith(SPOOLS):
            made.whole.append(name)
        elif name.startswith(f"{STAGES}/"):
            _plan_stage(damage, name, made)
        elif damage.listing.frames:
            # Some are written at the first frame; some grow with the frames, and are as the last one leaves them.
            made.frames[name] = frozenset([min(damage.listing.frames), max(damage.listing.frames)])
    return made


def sharded(damage: Damage) -> ShardedFolder:
    """Return the shards of a dataset."""
    return ShardedFolder(damage.folder, damage.listing.files.keys(), damage.files.keys(), damage.listing.frames)


def joined(plans: list[Plan]) -> Portion | None:
    """Return the frames that are made for several datasets of one run; None: all of them."""
    numbers = frozenset().union(*(each.numbers for each in plans))
    if any(each.whole for each in plans):
        return None
    return Portion(min(numbers), max(numbers) + 1, numbers=numbers)


def _whole_spools(damage: Damage) -> list[Path]:
    listed = damage.listing.files
    return [damage.folder / name for name in listed if name.startswith(SPOOLS) and name not in damage.files]


def _paths_of(spool: Path) -> list[str]:
    """Return the files that are made of a spool; none where this version does not know how, or it is damaged.

    Then they are made again as what belongs to no frame is: with all frames.
    """
    with suppress(WriterError):
        return aggregates.paths_of(spool)
    return []


def _plan_stage(damage: Damage, name: str, made: Plan) -> None:
    """Plan a recorded stage: it is written at each frame whose record refers to it."""
    for file, number in _records(damage):
        if _stage_of(damage.folder / file) == name:
            made.frames[name] = frozenset([number])
            return
    again = {number for file, numbers in made.frames.items() if file.startswith(f"{FRAMES}/") for number in numbers}
    if again:  # one of them refers to it
        made.frames[name] = frozenset(again)
    else:
        made.whole.append(name)


def _stage_of(record: Path) -> str | None:
    """Return the file of the stage that a record refers to; None where there is none, or it cannot be read."""
    found = attempt([], record.name, "?", UNREADABLE, lambda: frame_record.decode(record.read_bytes()))
    return found.stage.get("file") if found is not None else None


def _records(damage: Damage) -> Iterator[tuple[str, int]]:
    """Yield the undamaged records of frames, with the numbers of the frames."""
    for name, listed in damage.listing.files.items():
        if name.startswith(f"{FRAMES}/") and listed.frame.isdigit() and name not in damage.files:
            yield name, int(listed.frame)
