"""The damaged and missing files of a dataset whose journal tells what they were."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from usdsdg.datasets.faults import Fault
from usdsdg.errors import DatasetError
from usdsdg.verify.integrity import check
from usdsdg.verify.integrity.listing import JOURNAL, Listing, read_listing
from usdsdg.writers.journal import recipe
from usdsdg.writers.journal.places.place import JOINED, PARTS

Progress = Callable[[str, int, int | None], None]


@dataclass
class Damage:
    """What is wrong with a dataset in a folder."""

    folder: Path
    listing: Listing
    files: dict[str, Fault] = field(default_factory=dict)  # damaged or missing, by their paths below the folder
    foreign: list[Fault] = field(default_factory=list)  # files that no run wrote


def check_repairable(folder: Path, name: str) -> Listing:
    """Return what the journal of a dataset lists, if that can be relied on; name: of the dataset, for errors.

    Raises:
        DatasetError: it cannot, or the run has not ended; the message says what to do.
    """
    try:
        listing = read_listing(folder)
    except OSError as error:
        raise DatasetError(f"{name}: {error.filename} cannot be read: {error.strerror}. {recipe.UNREADABLE}") from None
    if listing is None or not (folder / JOURNAL).is_file():
        raise DatasetError(
            f"{name} has no journal ({JOURNAL}), so it is not known which bytes its files had. Make the dataset anew, "
            "or give the folder that a writer wrote to."
        )
    own = [fault for fault in listing.faults if fault.file not in (recipe.FILE, PARTS) and fault not in listing.failed]
    if any(fault.file == PARTS for fault in listing.faults) or (folder / JOINED).is_dir():
        raise DatasetError(f"{name} has parts that are not joined. Make the missing ones, and join them: usdsdg merge.")
    is_unfinished = any("the run is unfinished" in fault.what for fault in own)
    if is_unfinished and (listing.is_cut_off or not listing.is_damaged):
        raise DatasetError(f"{name} is of a run that has not ended. Resume it first, with --resume.")
    if own:
        raise DatasetError(
            f"{name}: the journal is damaged ({JOURNAL}: {own[0].what}), so it is not known which bytes the files had. "
            "Put a copy of it back, or make the dataset anew with --overwrite."
        )
    wrong = next((fault.what for fault in listing.faults if fault.file == recipe.FILE), None)
    if wrong is None and not (folder / recipe.FILE).is_file():
        wrong = "is missing"
    if wrong is not None:
        raise DatasetError(
            f"{name}: {recipe.FILE} {wrong}, so it is not known how the frames are made. Put a copy of it back, or "
            "make the dataset anew with --overwrite."
        )
    return listing


def find(folder: Path, name: str, progress: Progress | None = None) -> Damage:
    """Compare the files of a dataset with its journal; errors are those of `check_repairable`."""
    damage = Damage(folder, check_repairable(folder, name))
    found = check(folder, progress)
    for fault in found.faults if found is not None else ():
        if fault.file in damage.listing.files:
            damage.files[fault.file] = fault
        elif fault not in damage.listing.failed:
            damage.foreign.append(fault)
    return damage
