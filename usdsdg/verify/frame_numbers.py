"""Checks of numbers of frames that a user chose, against those that a dataset has."""

from __future__ import annotations

import os
from collections.abc import Sequence, Set
from itertools import islice
from pathlib import Path

from usdsdg.errors import BadValue, counted
from usdsdg.verify.integrity.listing import read_listing
from usdsdg.writers.journal.portion import Portion

_SHOWN = 8


def check_portion(folders: Sequence[Path], portion: Portion) -> None:
    """Check that the journals of datasets which one run has made list the frames of a portion, each in one at least.

    In a range there may be frames between others at which no writer was due.

    Raises:
        BadValue: they do not have some of them; the message names them.
    """
    known = {number for folder in folders for number in frames_of(folder)}
    if portion.numbers is not None:
        wanted = portion.numbers
    else:
        end = max(known, default=-1) + 1
        wanted = range(portion.first, max(end, portion.first + 1) if portion.last is None else portion.last)
        if wanted.stop <= end and any(number in wanted for number in known):
            return
    check_numbers(os.path.commonpath(folders), wanted, known)


def frames_of(folder: Path) -> set[int]:
    """Return the frames that the journal of a dataset lists."""
    listing = read_listing(folder)
    return listing.frames if listing is not None else set()


def check_numbers(dataset: str, wanted: range | Set[int], known: Set[int]) -> None:
    """Check that a dataset has the frames that are wanted. dataset: its name. known: the frames that it has.

    Raises:
        BadValue: it does not have some of them; the message names them.
    """
    count = wanted.stop - wanted.start if isinstance(wanted, range) else len(wanted)
    missing = count - sum(number in wanted for number in known)
    if not missing:
        return
    ordered = wanted if isinstance(wanted, range) else sorted(wanted)
    named = ", ".join(map(str, islice((number for number in ordered if number not in known), _SHOWN)))
    more = f" and {missing - _SHOWN} more" if missing > _SHOWN else ""
    has = f"{counted(len(known), 'frame')}, from {min(known)} to {max(known)}" if known else "no frames"
    raise BadValue(f"--frames: {dataset} does not have frame{'s' * (missing > 1)} {named}{more}; it has {has}")
