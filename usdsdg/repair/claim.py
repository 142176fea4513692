"""A dataset that is repaired: locked against runs, with what is damaged, and what makes that again."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from usdsdg.datasets.folder import check_folder
from usdsdg.errors import DatasetError
from usdsdg.repair.damage import check_repairable, find
from usdsdg.repair.plan import plan
from usdsdg.repair.replaced import Repair
from usdsdg.repair.summary import Summary
from usdsdg.session.progress import report as progress
from usdsdg.stores.addresses import is_url
from usdsdg.writers.journal.earlier_files import remove_unfinished
from usdsdg.writers.journal.folders import whole_locks
from usdsdg.writers.journal.place import FolderPlace, place_of


@contextmanager
def claimed(name: str, *, is_dry: bool) -> Iterator[Summary]:
    """Find what is damaged in a dataset, while no run writes there. is_dry: nothing will be, and no lock is needed.

    Raises:
        DatasetError: it cannot be repaired; the message says why, and what to do.
        DatasetInTheWay: a process is writing there.
        OutputNotWritable: this user may not write there.
    """
    place = place_of(name)
    if not isinstance(place, FolderPlace):
        raise DatasetError(
            f"{name} is in a store, and only datasets in folders are repaired. Copy it to a folder, repair that, and "
            "copy the files back that `usdsdg repair --json` lists."
        )
    folder = place.path if is_url(name) else Path(name).absolute()
    check_folder(folder if is_url(name) else Path(name))
    check_repairable(folder, name)  # first, as a lock makes a journal where there is none
    locks = [] if is_dry else whole_locks(place)
    try:
        if not is_dry:
            remove_unfinished(folder)
        damage = find(folder, name, progress)
        yield Summary(name, Repair(damage), plan(damage), is_dry=is_dry)
    finally:
        for lock in locks:
            lock.release()
