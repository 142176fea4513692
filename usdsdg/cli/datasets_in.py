"""The datasets in a folder that a command is given."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from usdsdg.stage.semantics.semantic_classes import BESIDE


def datasets_in(place: str) -> list[str]:
    """Return the datasets in a folder or at a URL, at any depth, as where a job has written several formats.

    Also those that have lost their recipe, or of which it may not be read: the command says so. Below a dataset there
    is no search for others. A folder without any stands for itself, and its command says why it cannot do anything
    there.

    Raises:
        StoreError: the URL names no store, or what is there cannot be listed.
    """
    from usdsdg.stores.addresses import is_url

    if is_url(place):
        return _in_store(place) or [place]
    if _is_dataset(Path(place)):
        return [place]
    found = []
    for folder, below, _ in os.walk(place, onerror=_tell_unreadable):
        inside = [name for name in below if _is_dataset(Path(folder, name))]
        found += [str(Path(folder, name)) for name in inside]
        below[:] = set(below) - {*inside, BESIDE}
    return sorted(found) or [place]


def _in_store(url: str) -> list[str]:
    """Return the URLs of the datasets at a URL; of those that are none themselves all names are listed."""
    from usdsdg.stores import open_store
    from usdsdg.writers.journal.places.place import JOURNAL
    from usdsdg.writers.journal.recipe import FILE

    store = open_store(url)
    if store.size(FILE) is not None:
        return [url]
    tops = set()
    for name, _ in store.list():
        top, _, rest = f"/{name}".partition(f"/{BESIDE}/")
        if rest in (os.path.basename(FILE), JOURNAL):
            tops.add(top)
    return sorted(f"{url.rstrip('/')}{top}" for top in tops if not any(top.startswith(f"{each}/") for each in tops))


def _is_dataset(folder: Path) -> bool:
    from usdsdg.writers.journal.places.place import JOURNAL
    from usdsdg.writers.journal.recipe import FILE

    beside = folder / BESIDE
    if os.path.isfile(folder / FILE) or (os.path.isdir(beside) and not os.access(beside, os.X_OK)):
        return True
    journal = beside / JOURNAL
    return os.path.isfile(journal) and os.path.getsize(journal) > 0  # an empty one is but a lock


def _tell_unreadable(error: OSError) -> None:
    if not isinstance(error, (FileNotFoundError, NotADirectoryError)):  # the place itself, of which the command tells
        print(f"note: {error.filename} was not looked into: {error.strerror}", file=sys.stderr)
