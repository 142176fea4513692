"""What lets a run with more frames resume an earlier one, as `folders` calls it; see `usdsdg.writers.growth`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from usdsdg.writers.journal.place import Place
from usdsdg.writers.journal.portion import Portion
from usdsdg.writers.journal.recipe import Recipe


class Growth(Protocol):
    """What knows in which way recipes tell the number of frames."""

    def obstacle(self, place: Place, wanted: Recipe, earlier: Mapping[str, Any], portion: Portion | None) -> str | None:
        """Return why a wanted run cannot resume the earlier one of a place: "" if it can; None if they differ in
        more than the number of frames."""
        ...

    def begin(self, place: Place, wanted: Recipe) -> None:
        """Make the earlier run of a place an unfinished one of the wanted recipe, of which all records are there."""
        ...


def advice(
    growth: Growth | None, place: Place, wanted: Recipe, earlier: Mapping[str, Any], portion: Portion | None
) -> str:
    """Return what an error about runs of different recipes says of growing; "" where that is not meant."""
    reason = growth.obstacle(place, wanted, earlier, portion) if growth is not None else None
    if reason is None:
        return ""
    if reason:
        return f"Only the number of frames is another, but --resume cannot go on: {reason}. "
    return "Only the number of frames is larger: --resume makes those that are missing. "
