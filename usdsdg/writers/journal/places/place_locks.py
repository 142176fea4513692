"""The locks of a dataset's place, taken or refused in words for the user."""

from __future__ import annotations

from pathlib import Path

from usdsdg.errors import DatasetInTheWay, StoreError
from usdsdg.stores.locks import Locked
from usdsdg.stores.whole_file import not_writable
from usdsdg.writers.journal.places.place import FolderPlace, Lock, Place
from usdsdg.writers.journal.portion import Portion

# Of what works on a dataset where it is, and is given no output_dir.
COPY = "work on a copy of the dataset"


def shared_lock(place: Place) -> Lock:
    """Take the lock of a process that lets others make parts.

    Raises:
        DatasetInTheWay: a process makes all frames there.
        OutputNotWritable, StoreError: the place cannot be locked.
    """
    try:
        return place.shared_lock()
    except Locked as held:
        raise in_use(place, held) from None
    except OSError as error:
        raise not_locked(place.path, error) from error


def whole_locks(place: Place) -> list[Lock]:
    """Take the locks of a process that changes files of any frames; errors are those of `shared_lock`."""
    try:
        return place.locks(None)
    except Locked as held:
        raise in_use(place, held) from None
    except OSError as error:
        raise not_locked(place.path, error, elsewhere=COPY) from error


def not_locked(path: Path, error: OSError, **remedy: str) -> StoreError:
    """Return the error of a place that cannot be locked; that of a store names the store, and says what to do.

    remedy: as in `not_writable`.
    """
    return error if isinstance(error, StoreError) else not_writable(path, error, **remedy)


def in_use(place: Place, held: Locked) -> DatasetInTheWay:
    """Return the error of a lock that another process has."""
    return DatasetInTheWay(f"{place.name}: another process is writing to this dataset ({held}).")


def check_unused(place: Place, portion: Portion | None) -> None:
    """Check that no other process writes to a folder; of a store, where it takes long, that is found when it is locked.

    Raises:
        DatasetInTheWay: one does.
    """
    if isinstance(place, FolderPlace):
        try:
            for lock in place.locks(portion):
                lock.release()
        except Locked as held:
            raise in_use(place, held) from None
        except OSError:  # no journal is there yet, or the file system has no locks: nothing is known of others
            return
