"""Listing of the files of a dataset."""

import os
from collections.abc import Callable, Iterator
from pathlib import Path

MAX_DEPTH = 6


def files_below(folder: Path, closed: Callable[[OSError], None] | None = None) -> Iterator[Path]:
    """Yield paths relative to `folder`, sorted within each folder, without hidden and very deep ones.

    closed: gets the error of each folder that cannot be listed, with its `filename`.
    """
    for where, folders, names in os.walk(folder, onerror=closed):
        inside = Path(where).relative_to(folder)
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        if len(inside.parts) >= MAX_DEPTH:
            folders.clear()
        yield from (inside / name for name in sorted(names) if not name.startswith("."))
