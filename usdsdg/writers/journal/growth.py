"""Growing a dataset: a run with more frames, which differs in nothing else, makes those that are missing."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from usdsdg.errors import DatasetError, WriterError
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.writers.journal import journal, recipe
from usdsdg.writers.journal.facts import WRITERS
from usdsdg.writers.journal.journal import NAME, Journal
from usdsdg.writers.journal.lines import SHARED, SPOOLS
from usdsdg.writers.journal.merge import parts_of
from usdsdg.writers.journal.places.place import JOINED, Place
from usdsdg.writers.journal.portion import Portion
from usdsdg.writers.journal.recipe import Recipe
from usdsdg.writers.journal.spool_hashes import AGGREGATES, ONCE, SpoolHashes

# What keeps the earlier frames, of a folder with the recipe `.usdsdg/recipe.json`, from being the first ones of the
# wanted run: "" if nothing does; None if the runs differ in more than the number of frames.
Obstacle = Callable[[Recipe, Recipe, Path], str | None]
# Writes the spools of samples of a run that has ended, of its shards; called with the contents of its journal.
RestoreSamples = Callable[[Place, journal.Contents], None]
# Writers whose files of one frame name the whole recipe, and so the number of frames.
_NAMING_THE_RECIPE = ("RerunWriter",)


class MoreFrames:
    """Lets a run with more frames resume a complete one, or one that has not ended."""

    def __init__(self, obstacle: Obstacle, restore_samples: RestoreSamples, frames: int | None = None) -> None:
        """Of a run with so many frames; None: not known before it has ended.

        Args:
            obstacle: of the command, called with the wanted recipe, the earlier one, and the folder of the latter.
            restore_samples: of the formats with shards, which are no concern of the journal.
        """
        self._obstacle, self._restore_samples, self._frames = obstacle, restore_samples, frames

    def obstacle(self, place: Place, wanted: Recipe, earlier: Mapping[str, Any], portion: Portion | None) -> str | None:
        """Return why a run cannot resume an earlier one as `Obstacle` does."""
        try:
            reason = self._obstacle(wanted, Recipe.of_values(earlier, place.path), place.path)
        except DatasetError:
            return None
        if reason:
            return reason
        return reason if reason is None else _obstacle_there(place, portion)

    def begin(self, place: Place, wanted: Recipe) -> None:
        """Make an earlier run with fewer frames, which is locked and has no obstacle, an unfinished one of `wanted`.

        So is one of the same recipe of whose frames only the first parts were made and joined. Of one that had ended,
        and of which the end of the journal is lost, samples are read back from its shards, too.

        Raises:
            WriterError: its journal was damaged, or a shard of samples, which grows.
            OutputNotWritable: a file cannot be written.
        """
        earlier = recipe.read(place.path)
        if earlier is None:
            return
        own = place.path / BESIDE / NAME
        contents = journal.read(own) if own.is_file() else journal.Contents()
        differs = bool(wanted.differences(earlier))
        grows = differs or (self._frames is not None and len(contents.frames) < self._frames)
        if (grows and contents.is_complete) or _lacks_samples(place, contents):
            self._restore_samples(place, contents)
            spools = SpoolHashes(place.path / BESIDE / AGGREGATES).facts_of_files()
            # Before the recipe: with a complete journal, a process that died in between would leave a run that has
            # ended with too few frames.
            Journal(own).append([{SHARED: {}, SPOOLS: spools}], {})
            place.push()
        if differs:
            wanted.write(place.path)


def _lacks_samples(place: Place, contents: journal.Contents) -> bool:
    """Return whether a run had removed the samples of its shards at its end, of which the journal tells no more."""
    is_told = any(name.startswith(f"{ONCE}/") for name in contents.spools)
    if contents.is_complete or not contents.frames or is_told:
        return False
    return not any(SpoolHashes(place.path / BESIDE / AGGREGATES / ONCE).files())


def advice(
    growth: MoreFrames | None, place: Place, wanted: Recipe, earlier: Mapping[str, Any], portion: Portion | None
) -> str:
    """Return what an error about runs of different recipes says of growing; "" where that is not meant."""
    reason = growth.obstacle(place, wanted, earlier, portion) if growth is not None else None
    if reason is None:
        return ""
    if reason:
        return f"Only the number of frames is another, but --resume cannot go on: {reason}. "
    return "Only the number of frames is larger: --resume makes those that are missing. "


def more_frames_of_option(wanted: Recipe, earlier: Recipe, folder: Path) -> str | None:
    """Return what keeps the frames of `usdsdg run --frames N` from being the first of another N; see `Obstacle`."""
    mine, theirs = wanted.options.get("frames"), earlier.options.get("frames")
    if differing(wanted, earlier) != {"options"} or not isinstance(mine, int) or not isinstance(theirs, int):
        return None
    if {**wanted.options, "frames": 0} != {**earlier.options, "frames": 0}:
        return None
    return fewer(f"--frames {theirs}", f"--frames {mine}") if mine < theirs else ""


def differing(wanted: Recipe, earlier: Recipe) -> set[str]:
    """Return the names of the facts that tell one recipe from the other."""
    return {name for name in recipe.IDENTITY if getattr(wanted, name) != getattr(earlier, name)}


def fewer(earlier: str, wanted: str) -> str:
    """Return why a dataset does not become smaller."""
    return f"it was made with {earlier}, now it is {wanted}, and --resume adds frames, but removes none"


def _obstacle_there(place: Place, portion: Portion | None) -> str:
    """Return what in a place keeps it from growing; "" if nothing does."""
    if portion is not None:
        return (
            "one part of it alone cannot grow; give --resume without --frames A:B and --shard, or --workers N --resume"
        )
    if parts_of(place.path) or (place.path / JOINED).exists():
        return (
            "it has parts that are not joined; end that run first, with --workers N --resume and its number of frames"
        )
    own = place.path / BESIDE / NAME
    try:
        facts = journal.read(own).facts if own.is_file() else {}
    except WriterError as error:
        return str(error)
    naming = [key for key in facts.get(WRITERS, {}) if key.rpartition("-")[0] in _NAMING_THE_RECIPE]
    return f"the files of {naming[0].rpartition('-')[0]} have an id of the whole recipe" if naming else ""
