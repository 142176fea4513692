"""Colors by name or as numbers, as Isaac Sim's objects take them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdsdg.compat.wrappers.arrays import as_numpy, rows

# The one-letter names of plotting libraries; half as bright as the names of CSS where they are.
_LETTERS = {
    "r": (1, 0, 0), "g": (0, 0.5, 0), "b": (0, 0, 1), "c": (0, 0.75, 0.75), "m": (0.75, 0, 0.75),
    "y": (0.75, 0.75, 0), "k": (0, 0, 0), "w": (1, 1, 1),
}  # fmt: skip


def rgb_rows(colors: str | Sequence[str] | Sequence[float] | np.ndarray, count: int) -> np.ndarray:
    """Return colors (count, 3) from numbers, or from names such as "red", "#8080ff", "r" and "0.5"; one for all.

    Raises:
        ValueError: there is no such name, or there are neither one nor `count` colors.
    """
    if isinstance(colors, str):
        colors = [colors]
    if isinstance(colors, (list, tuple)):
        colors = np.array([_rgb(each) if isinstance(each, str) else as_numpy(each) for each in colors])
    return rows(np.asarray(colors), 3, count)


def _rgb(name: str) -> tuple[float, ...]:
    if name in _LETTERS:
        return _LETTERS[name]
    try:
        return (float(name),) * 3
    except ValueError:
        from PIL import ImageColor

        return tuple(part / 255.0 for part in ImageColor.getrgb(name)[:3])
