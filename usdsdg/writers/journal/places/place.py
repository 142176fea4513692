"""Where a dataset is: in a local folder, or in a store, of which the journal and the like are mirrored in a folder."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Protocol

from usdsdg.errors import WriterError
from usdsdg.stage.assets.file_checks import check_regular
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.stores import open_store
from usdsdg.stores.addresses import is_url
from usdsdg.stores.lease import Lease
from usdsdg.stores.locks import FileLock
from usdsdg.stores.mirror import Mirror
from usdsdg.stores.store import Store
from usdsdg.stores.whole_file import PART, not_writable, sync_all, write_whole
from usdsdg.writers.journal.portion import Portion

JOURNAL = "journal.jsonl"
PARTS = f"{BESIDE}/parts"
JOINED = f"{BESIDE}/joined"  # folder of parts that have been joined, until the dataset is whole
SHARING = ".workers.lock"  # the lock of the process that lets others make parts
LATEST = "latest"  # folder of a part, with its versions of files about all frames that grow with them
REMOVING = "removing.jsonl"  # the names of files that a removal, which may be interrupted, has begun to remove
_LEASES = f"{BESIDE}/leases"
_ALL, _PART, _SHARED = f"{_LEASES}/all", f"{_LEASES}/part-", f"{_LEASES}/shared-"
_SHARING_OUT = f"{_LEASES}/sharing-out"
# What of `.usdsdg` is mirrored; the rest, such as the records of frames, is written as the data are.
_MIRRORED = (JOURNAL, REMOVING, "recipe.json", "source", "aggregates", "parts")
_PROCESS = f"{os.getpid():x}-{os.urandom(6).hex()}"


class Lock(Protocol):
    """What keeps other processes out."""

    def release(self) -> None:
        """Give it back; nothing happens the second time."""
        ...


class Place(Protocol):
    """The place of one dataset."""

    name: str  # the path of the folder, or the URL
    path: Path  # a local folder with recipe, journal, parts and spools; of a local dataset the folder itself

    def pull(self, portion: Portion | None = None) -> None:
        """Bring recipe, journal, spools and parts, or one of these, to what other processes have left."""
        ...

    def push(self, *, whole: bool = False) -> None:
        """Make what was appended to them, or written anew, durable; whole: they stay as they are now for a while."""
        ...

    def locks(self, portion: Portion | None) -> list[Lock]:
        """Take the locks of a process that makes all frames, or some; raises Locked where another has them."""
        ...

    def shared_lock(self) -> Lock:
        """Take the lock of a process that lets others make parts; raises Locked where one makes all frames."""
        ...

    def sharing_lock(self) -> Lock:
        """Take the lock of the one process that plans parts, lets others make them, and joins them; raises Locked."""
        ...

    def sync(self, names: Iterable[str]) -> None:
        """Wait until files of frames and spools are durable."""
        ...

    def remove(self, names: Iterable[str]) -> None:
        """Remove files that a journal lists, and the folders that this leaves empty."""
        ...

    def remove_beside(self) -> None:
        """Remove what is in `.usdsdg`, apart from locks and names that are being removed; the journal is empty then."""
        ...

    def has_files(self) -> bool:
        """Return whether there is a file, apart from `.usdsdg` and from datasets in folders below."""
        ...

    def read(self, name: str) -> bytes | None:
        """Return the content of a file; None if there is none; raises WriterError where it cannot be read."""
        ...

    def write(self, name: str, data: bytes) -> None:
        """Write a file, in place of one that may be there."""
        ...

    def exists(self) -> bool:
        """Return whether it was not removed."""
        ...


def place_of(name: str | os.PathLike[str]) -> Place:
    """Return the place with a path, relative to the working directory, or with a URL.

    Raises:
        StoreError: the URL names no store.
    """
    if not is_url(name):
        return FolderPlace(Path(name).absolute())
    store = open_store(name)
    return StorePlace(store) if is_url(store.url) else FolderPlace(Path(store.url))


class FolderPlace:
    """A local folder as a `Place`."""

    def __init__(self, path: Path) -> None:
        self.path, self.name = path, str(path)

    def pull(self, portion: Portion | None = None) -> None:
        """Nothing is to be brought; see `Place`."""

    def push(self, *, whole: bool = False) -> None:
        """Nothing is to be sent; see `Place`."""

    def locks(self, portion: Portion | None) -> list[Lock]:
        """Take the locks of journals; see `Place`."""
        found: list[Lock] = [FileLock(self.path / BESIDE / JOURNAL, shared=portion is not None)]
        if portion is not None:
            found.append(FileLock(self.path / PARTS / portion.name / JOURNAL))
        return found

    def shared_lock(self) -> Lock:
        """Take the lock of the journal; see `Place`."""
        return FileLock(self.path / BESIDE / JOURNAL, shared=True)

    def sharing_lock(self) -> Lock:
        """Take the lock of a file of its own; see `Place`."""
        return FileLock(self.path / BESIDE / SHARING, removed=True)

    def sync(self, names: Iterable[str]) -> None:
        """Sync files and folders; see `Place`."""
        sync_all(self.path / name for name in names)

    def remove(self, names: Iterable[str]) -> None:
        """Remove files; see `Place`."""
        top = self.path.resolve()
        folders: set[Path] = set()
        for name in names:
            parent = (self.path / name).parent.resolve()
            if parent.is_relative_to(top):
                _remove(parent / Path(name).name)
                folders.update(each for each in (parent, *parent.parents) if each.is_relative_to(top))
        for folder in sorted(folders - {top}, key=lambda each: len(each.parts), reverse=True):
            with suppress(OSError):
                folder.rmdir()

    def remove_beside(self) -> None:
        """Remove what is beside the data; see `Place`."""
        # The recipe last: what a removal that is interrupted has left is then still known as that of a run.
        there = [each for each in (self.path / BESIDE).iterdir() if each.name != REMOVING]
        for each in sorted(there, key=lambda each: each.name == "recipe.json"):
            if each.is_dir():
                shutil.rmtree(each, ignore_errors=True)
            elif each.name == JOURNAL:
                os.truncate(each, 0)  # which is locked
            else:
                each.unlink()

    def has_files(self) -> bool:
        """Return whether there are files; see `Place`."""
        for folder, below, names in os.walk(self.path):
            if any(PART.fullmatch(name) is None for name in names):  # others may be writing, or trying whether they can
                return True
            if any(Path(folder, name).is_symlink() for name in below):  # which no writer makes
                return True
            # Not what is in folders of other writers, each a dataset of its own, which may have been made before.
            below[:] = [name for name in below if name != BESIDE and not Path(folder, name, BESIDE).is_dir()]
        return False

    def read(self, name: str) -> bytes | None:
        """Return the content of a file; see `Place`."""
        try:
            check_regular(str(self.path / name))
            return (self.path / name).read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            raise WriterError(
                f"{self.path / name} cannot be read: {error.strerror}. Remove what is there; usdsdg repair makes the "
                "file again once the run has ended."
            ) from None

    def write(self, name: str, data: bytes) -> None:
        """Write a file; see `Place`."""
        write_whole(self.path / name, data)

    def exists(self) -> bool:
        """Return whether the folder is there; see `Place`."""
        return self.path.exists()


class StorePlace:
    """A store as a `Place`: the prefix of a bucket."""

    def __init__(self, store: Store) -> None:
        self.name, self.store = store.url, store
        self._mirror = Mirror(store, BESIDE, _is_mirrored, lambda name: name.endswith(".jsonl"))
        self.path = self._mirror.path
        self._leases: list[Lease] = []

    def pull(self, portion: Portion | None = None) -> None:
        """Fetch what is new; see `Place`."""
        own = "" if portion is None else f"{PARTS}/{portion.name}/"
        self._mirror.pull(lambda name: name.startswith(own) or not name.startswith(f"{PARTS}/"))

    def push(self, *, whole: bool = False) -> None:
        """Send what is new; see `Place`."""
        for lease in self._leases:
            lease.check()
        self._mirror.push(whole=whole)

    def locks(self, portion: Portion | None) -> list[Lock]:
        """Take leases; see `Place`."""
        if portion is None:
            # That of a process that shares frames out is there while it begins and joins them itself.
            return [self._lease(_ALL, lambda: (name for name, _ in self.store.list(_LEASES) if name != _SHARING_OUT))]
        shared = self.shared_lock()
        try:
            return [self._lease(f"{_PART}{portion.name.replace('/', '-')}", lambda: ()), shared]
        except BaseException:
            shared.release()
            raise

    def shared_lock(self) -> Lock:
        """Take a lease that several processes may have; see `Place`."""
        return self._lease(f"{_SHARED}{_PROCESS}-{os.urandom(3).hex()}", lambda: [_ALL])

    def sharing_lock(self) -> Lock:
        """Take a lease of its own; see `Place`."""
        return self._lease(_SHARING_OUT, lambda: ())

    def sync(self, names: Iterable[str]) -> None:
        """All that was put is durable; see `Place`."""

    def remove(self, names: Iterable[str]) -> None:
        """Remove files; see `Place`."""
        self._mirror.delete(names)

    def remove_beside(self) -> None:
        """Remove what is beside the data; see `Place`."""
        shutil.rmtree(self.path / BESIDE, ignore_errors=True)
        (self.path / BESIDE).mkdir()
        self._mirror.push()
        self._mirror.delete(name for name, _ in self.store.list(BESIDE) if not name.startswith(f"{_LEASES}/"))

    def has_files(self) -> bool:
        """Return whether there are files; see `Place`."""
        others, within = set(), set()  # folders with files, and those that are datasets of their own
        for name, _ in self.store.list():
            top, beside, _ = f"/{name}".partition(f"/{BESIDE}/")
            if beside:
                within.add(top)
            else:
                others.add(top.rpartition("/")[0])
        return not all(any(f"{each}/".startswith(f"{top}/") for top in within - {""}) for each in others)

    def read(self, name: str) -> bytes | None:
        """Return the content of a file; see `Place`."""
        try:
            return self.store.get(name)
        except FileNotFoundError:
            return None

    def write(self, name: str, data: bytes) -> None:
        """Put a file; see `Place`."""
        self.store.put(name, data)

    def exists(self) -> bool:
        """A prefix is there always; see `Place`."""
        return True

    def _lease(self, path: str, rivals: Callable[[], Iterable[str]]) -> Lease:
        lease = Lease(self.store, path, rivals=rivals)
        self._leases.append(lease)
        return lease


def _remove(file: Path) -> None:
    """Remove a file, of a link the link; a folder in its place, which no run has made, stays."""
    try:
        file.unlink(missing_ok=True)
    except OSError as error:
        if not file.is_dir():
            raise not_writable(file, error) from error


def is_kept_as_data(name: str) -> bool:
    """Return whether a file of a store is one object, as pictures are: neither mirrored, nor a lease."""
    return not _is_mirrored(name) and not name.startswith(f"{_LEASES}/")


def _is_mirrored(name: str) -> bool:
    beside, _, rest = name.partition("/")
    return beside == BESIDE and rest.split("/")[0] in _MIRRORED
