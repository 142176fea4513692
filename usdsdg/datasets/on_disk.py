"""A dataset where readers can open its files: a folder as it is, or the copy of one in a store."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

from usdsdg.errors import StoreError, UsdsdgError
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.stores.addresses import is_url
from usdsdg.stores.paths import path_below
from usdsdg.stores.store import Store
from usdsdg.writers.journal.places.place import StorePlace, is_kept_as_data, place_of

# Of `.usdsdg`: what `verify` compares labels with, which is much, and which others do not read.
RECORDS = (f"{BESIDE}/frames/", f"{BESIDE}/stages/")
_AT_ONCE = 16  # requests
_SPARE = 64 << 20  # bytes that stay free on the disk


class OnDisk:
    """A dataset with a local folder that has its files, or those of them that were fetched."""

    def __init__(self, name: str, path: Path, store: Store | None) -> None:
        """name: as the user gave it, a folder or URL. store: that files are fetched from; None: all are there."""
        self.name, self.path, self._store = name, path, store

    @property
    def is_copy(self) -> bool:
        """Whether its folder is a copy, which goes when it is closed."""
        return self._store is not None

    def fetch(self, wanted: Callable[[str], bool] = lambda name: True) -> None:
        """Fetch files of the store that are not there yet.

        wanted: whether a file, by its path in the dataset, is fetched.

        Raises:
            StoreError: the store does not answer or denies it, or the disk has no room.
            OutputNotWritable: a name in the store leaves the folder.
        """
        store = self._store
        if store is None:
            return
        sizes = {name: size for name, size in store.list() if is_kept_as_data(name) and wanted(name)}
        files = {name: file for name in sizes if not (file := path_below(self.path, name)).exists()}
        self._check_room(sum(sizes[name] for name in files))

        def bring(item: tuple[str, Path]) -> None:
            name, file = item
            data = store.get(name)
            try:
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_bytes(data)
            except OSError as error:
                why = f"{error.strerror}: {self.name} has this name twice, as a file and as a folder"
                raise StoreError(f"{name} cannot be copied to {file.parent}: {why}") from error

        with ThreadPoolExecutor(_AT_ONCE) as pool:
            list(pool.map(bring, files.items()))

    def keep(self, file: Path) -> Path | str:
        """Put a file that was made in the folder into the store, if it is a copy; return its path or URL.

        Raises:
            OutputNotWritable: the store denies it, or does not answer.
        """
        if self._store is None:
            return file
        name = file.relative_to(self.path).as_posix()
        self._store.put(name, file.read_bytes())
        return f"{self.name}/{name}"

    def named(self, text: str) -> str:
        """Return a text with the dataset's own name in place of that of the copy."""
        return text.replace(str(self.path), self.name) if self.is_copy else text

    def _check_room(self, size: int) -> None:
        free = shutil.disk_usage(self.path).free - _SPARE
        if size > free:
            raise StoreError(
                f"{self.name} has {size / 1e9:.1f} GB to be copied for this, and {self.path.parent} has "
                f"{max(free, 0) / 1e9:.1f} GB left. Set TMPDIR to a folder with more room"
            )


@contextmanager
def on_disk(where: str | os.PathLike[str]) -> Iterator[OnDisk]:
    """Give a dataset in a folder, or at a URL, a local folder; errors that are raised inside name the URL.

    Of a store the folder is temporary. It has recipe and journals, as they are when a run is going on, at once; the
    rest is fetched.

    Raises:
        StoreError: the URL names no store, or the store does not answer or denies it.
    """
    place = place_of(where)
    if not isinstance(place, StorePlace):
        yield OnDisk(str(where), Path(place.path if is_url(where) else where), None)
        return
    place.pull()
    dataset = OnDisk(place.name, place.path, place.store)
    try:
        yield dataset
    except UsdsdgError as error:
        error.args = tuple(dataset.named(each) if isinstance(each, str) else each for each in error.args)
        raise
