"""Checks of numbers of frames that a user chose, against those that a dataset has."""

from __future__ import annotations

from collections.abc import Set
from itertools import islice
from pathlib import Path

from usdsdg.errors import BadValue
from usdsdg.verify.integrity.listing import read_listing
from usdsdg.writers.journal.portion import Portion

_SHOWN = 8


def check_portion(folder: Path, portion: Portion) -> None:
    """Check that the journal of a dataset lists the frames of a portion.

    Raises:
        BadValue: it does not have some of them; the message names them.
    """
    listing = read_listing(folder)
    known = listing.frames if listing is not None else set()
    if portion.numbers is not None:
        wanted = portion.numbers
    elif portion.last is not None:
        wanted = range(portion.first, portion.last)
    else:  # up to the end, whichever that is
        wanted = range(portion.first, portion.first + (portion.first > max(known, default=-1)))
    check_numbers(str(folder), wanted, known)


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
    has = f"{len(known)} frames, from {min(known)} to {max(known)}" if known else "no frames"
    raise BadValue(f"--frames: {dataset} does not have frame{'s' * (missing > 1)} {named}{more}; it has {has}")
