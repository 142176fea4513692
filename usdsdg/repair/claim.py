"""A dataset that is repaired: locked against runs, with what is damaged, and what makes that again."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from usdsdg.datasets.folder import check_folder
from usdsdg.datasets.on_disk import OnDisk
from usdsdg.repair.damage import check_repairable, find
from usdsdg.repair.plan import plan
from usdsdg.repair.replaced import Repair
from usdsdg.repair.summary import Summary
from usdsdg.session.progress import report as progress
from usdsdg.stores.addresses import is_url
from usdsdg.stores.whole_file import not_writable
from usdsdg.writers.journal.earlier_files import remove_unfinished
from usdsdg.writers.journal.places.place import FolderPlace, Place, StorePlace, is_kept_as_data, place_of
from usdsdg.writers.journal.places.place_locks import COPY, whole_locks


def _keep(place: Place, names: Sequence[str]) -> None:
    """Make files durable that were repaired in the folder of a place; of a store, put them there."""
    if not isinstance(place, StorePlace):
        place.sync(names)
        return
    for name in filter(is_kept_as_data, names):
        place.write(name, (place.path / name).read_bytes())
    place.push(whole=True)


def _remove_unfinished(folder: Path) -> None:
    try:
        remove_unfinished(folder)
    except OSError as error:
        raise not_writable(Path(error.filename or folder), error, elsewhere=COPY) from error


@contextmanager
def claimed(name: str, *, is_dry: bool) -> Iterator[Summary]:
    """Find what is damaged in a dataset, while no run writes there. is_dry: nothing will be, and no lock is needed.

    Raises:
        DatasetError: it cannot be repaired; the message says why, and what to do.
        DatasetInTheWay: a process is writing there.
        OutputNotWritable: this user may not write there.
        StoreError: the store does not answer or denies it, or the disk has no room for its files.
    """
    place = place_of(name)
    if isinstance(place, FolderPlace):
        check_folder(place.path if is_url(name) else Path(name))
    place.pull()
    check_repairable(place.path, name)  # first, as a lock makes a journal where there is none
    locks = [] if is_dry else whole_locks(place)
    try:
        if isinstance(place, StorePlace):
            place.pull()  # what was there before the lock may have changed
            OnDisk(place.name, place.path, place.store).fetch()
        elif not is_dry:
            _remove_unfinished(place.path)
        damage = find(place.path, name, progress)
        yield Summary(name, Repair(damage, partial(_keep, place)), plan(damage), is_dry=is_dry)
    finally:
        for lock in locks:
            lock.release()
