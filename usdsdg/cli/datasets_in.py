"""The datasets in a folder that a command is given."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from usdsdg.stage.semantics.semantic_classes import BESIDE


def datasets_in(place: str) -> list[str]:
    """Return the datasets in a folder, at any depth, as where a job has written several formats; of a URL itself.

    Below a dataset there is no search for others. A folder without any stands for itself, and its command says why it
    cannot do anything there.
    """
    from usdsdg.stores.addresses import is_url
    from usdsdg.writers.journal.recipe import FILE

    if is_url(place) or Path(place, FILE).is_file():
        return [place]
    found = []
    for folder, below, _ in os.walk(place, onerror=_tell_unreadable):
        inside = [name for name in below if Path(folder, name, FILE).is_file()]
        found += [str(Path(folder, name)) for name in inside]
        below[:] = set(below) - {*inside, BESIDE}
    return sorted(found) or [place]


def _tell_unreadable(error: OSError) -> None:
    if not isinstance(error, (FileNotFoundError, NotADirectoryError)):  # the place itself, of which the command tells
        print(f"note: {error.filename} was not looked into: {error.strerror}", file=sys.stderr)
