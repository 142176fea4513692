"""Which of the renderer's gprims belong to prims, for jobs that measure what a camera sees."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pxr import Usd


def rows_below(gprims: Iterable[str], prims: Sequence[Usd.Prim]) -> list[list[int]]:
    """Return for each prim the indices of the gprims at and below it.

    gprims: their paths as the renderer lists them; an instance of a point instancer has its number, "/a/instancer[3]".
    """
    found: dict[str, list[int]] = {str(prim.GetPath()): [] for prim in prims}
    for row, path in enumerate(gprims):
        parts = path.split("[", 1)[0].split("/")
        for end in range(2, len(parts) + 1):
            if (own := found.get("/".join(parts[:end]))) is not None:
                own.append(row)
    return list(found.values())
