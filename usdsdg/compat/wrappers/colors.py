"""Colors by name or as numbers, as Isaac Sim's objects take them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.compat.wrappers.arrays import as_numpy, rows

if TYPE_CHECKING:
    from usdsdg.compat.wrappers.arrays import Values

# The one-letter names of plotting libraries; half as bright as the names of CSS where they are.
_LETTERS = {
    "r": (1, 0, 0), "g": (0, 0.5, 0), "b": (0, 0, 1), "c": (0, 0.75, 0.75), "m": (0.75, 0, 0.75),
    "y": (0.75, 0.75, 0), "k": (0, 0, 0), "w": (1, 1, 1),
}  # fmt: skip
# The colors that plotting libraries go through, "tab:blue" or "C0" and on.
_CYCLE = {
    "blue": "#1f77b4", "orange": "#ff7f0e", "green": "#2ca02c", "red": "#d62728", "purple": "#9467bd",
    "brown": "#8c564b", "pink": "#e377c2", "gray": "#7f7f7f", "olive": "#bcbd22", "cyan": "#17becf",
}  # fmt: skip
_TABLEAU, _PLACE = "tab:", re.compile(r"C(\d+)")


def rgb_rows(colors: str | Sequence[str] | Values, count: int) -> np.ndarray:
    """Return colors (count, 3) from numbers or from names; one for all.

    Names are such as "red", "#8080ff", "r", "tab:blue", "C1" and "0.5".

    Raises:
        ValueError: there is no such name, or there are neither one nor `count` colors.
    """
    if isinstance(colors, str):
        colors = [colors]
    if isinstance(colors, (list, tuple)):
        colors = np.array([_rgb(each) if isinstance(each, str) else as_numpy(each) for each in colors])
    return rows(as_numpy(colors), 3, count)  # pyright: ignore[reportArgumentType]  # no names are left


def _rgb(name: str) -> tuple[float, ...]:
    if name in _LETTERS:
        return _LETTERS[name]
    if name.lower() == "none":
        return (0.0, 0.0, 0.0)  # transparent black, where there is no transparency
    if place := _PLACE.fullmatch(name):
        name = list(_CYCLE.values())[int(place[1]) % len(_CYCLE)]
    elif name.lower().startswith(_TABLEAU):
        name = _CYCLE.get(name.lower().removeprefix(_TABLEAU).replace("grey", "gray"), name)
    try:
        return (float(name),) * 3
    except ValueError:
        from PIL import ImageColor

        return tuple(part / 255.0 for part in ImageColor.getrgb(name)[:3])
