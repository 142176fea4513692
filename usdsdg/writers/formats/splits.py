"""Which part of a dataset a frame belongs to: training, validation, test."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from numbers import Real

from usdsdg.errors import WriterError, warn_once

# Names of parts become names of files and folders: no separators and control characters, and no hidden files.
_UNFIT = re.compile(r"^\.|[/\\\x00-\x1f\x7f]|^$")

_ROUNDED = 0.011  # by so much a sum of shares with two digits may differ from 1


def name_problem(names: Iterable[str]) -> str:
    """Return what is wrong with the names of parts, which are names of files and folders; "" if nothing is."""
    unfit = [repr(str(name)) for name in names if _UNFIT.search(str(name))]
    if not unfit:
        return ""
    return f"{', '.join(unfit)}: a part is called as a file is: no slash, and no dot at the beginning, such as 'train'"


class Splits:
    """Deals frames to parts so that every beginning of the run has the wanted shares; only the number decides."""

    def __init__(self, writer: str, shares: Mapping[str, float] | None, frames_per_scene: int = 1) -> None:
        """
        shares: relative sizes by name, such as {"train": 0.8, "val": 0.2}; None: all is "train".
        frames_per_scene: so many frames in a row stay together; 1 deals single frames.

        Raises:
            WriterError: there are none, a share is not a number above 0, a name is none of a file, or no frame is in a
                scene.
        """
        if frames_per_scene < 1:
            raise WriterError(f"{writer}: frames_per_scene is {frames_per_scene}; expected a whole number above 0.")
        self._together = frames_per_scene
        given = {"train": 1.0} if shares is None else dict(shares)
        if not given or not all(isinstance(share, Real) and 0.0 < share < math.inf for share in given.values()):
            raise WriterError(
                f"{writer}: splits is {shares!r}; expected shares above 0 such as " + "{'train': 0.8, 'val': 0.2}."
            )
        if problem := name_problem(given):
            raise WriterError(f"{writer}: splits has {problem}.")
        total = float(sum(given.values()))
        if any(share < 1.0 for share in given.values()) and abs(total - 1.0) > _ROUNDED:
            dealt = ", ".join(f"{share / total:.0%} {name}" for name, share in given.items())
            warn_once(f"{writer}: splits add up to {total:g}. They are relative to each other: {dealt}.")
        self._shares = {str(name): float(share) / total for name, share in given.items()}
        self._restart()

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the parts."""
        return tuple(self._shares)

    def of(self, frame: int) -> str:
        """Return the part of a frame, by its number from 0; fast for one that is not before the last one."""
        scene = frame // self._together
        if scene < self._dealt - 1:
            self._restart()
        while self._dealt <= scene:
            self._dealt += 1
            self._last = max(self._shares, key=lambda each: self._shares[each] * self._dealt - self._counts[each])
            self._counts[self._last] += 1
        return self._last

    def _restart(self) -> None:
        self._dealt, self._last = 0, ""  # scenes that are dealt, and the part of the last one
        self._counts = dict.fromkeys(self._shares, 0)
