"""Which of the renderer's gprims belong to prims, for jobs that measure what a camera sees."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import lru_cache

from pxr import Usd


def rows_below(gprims: tuple[str, ...], prims: Sequence[Usd.Prim]) -> list[list[int]]:
    """Return for each prim the indices of the gprims at and below it.

    gprims: their paths as the renderer lists them; an instance of a point instancer has its number, "/a/instancer[3]".
    """
    rows = _rows_by_path(gprims)
    return [list(rows.get(str(prim.GetPath()), ())) for prim in prims]


@lru_cache(maxsize=1)  # jobs ask for one prim after the other, of gprims that stay the same for many frames
def _rows_by_path(gprims: tuple[str, ...]) -> Mapping[str, list[int]]:
    """Return the indices of gprims by their own paths and by those of all prims above them."""
    found: defaultdict[str, list[int]] = defaultdict(list)
    for row, path in enumerate(gprims):
        parts = path.split("[", 1)[0].split("/")
        for end in range(2, len(parts) + 1):
            found["/".join(parts[:end])].append(row)
    return found
