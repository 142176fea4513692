"""Episodes: frames of one scene, which is built, simulated and captured from a seed of its own.

Physics is a history, so an episode is the smallest part of a job that can be made without the rest.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from usdsdg.capture.requests import count_unwanted
from usdsdg.graph import sampling
from usdsdg.session.session import current
from usdsdg.writers import Writer
from usdsdg.writers.journal.run import get_run

_SEEDS = 1 << 31


@dataclass(frozen=True)
class Episode:
    """The frames from `first` on, `frames` of them, of a scene with a seed of its own."""

    first: int
    frames: int
    seed: int


class Episodes:
    """The episodes of a job, each of which is made when it is its turn: there may be a million."""

    def __init__(self, seed: int, frames: int, length: int, scenario: str) -> None:
        """length: frames of an episode, of the last one at most."""
        self._seed, self._frames, self._length, self._scenario = seed, frames, length, scenario

    def __len__(self) -> int:
        return max(1, -(-self._frames // self._length))

    def __iter__(self) -> Iterator[Episode]:
        if len(self) == 1:
            yield Episode(0, self._frames, self._seed)
            return
        for number, first in enumerate(range(0, self._frames, self._length)):
            seed = int(sampling.generator(self._seed, f"{self._scenario}/episode", number).integers(_SEEDS))
            yield Episode(first, min(self._length, self._frames - first), seed)


def episodes(seed: int, frames: int, frames_per_episode: int, scenario: str = "object_based") -> Episodes:
    """Return the episodes of a job; frames_per_episode: 0 makes all frames one, with the job's own seed."""
    found = Episodes(seed, frames, frames_per_episode or max(frames, 1), scenario)
    if len(found) > 1:
        get_run().aggregates_wait = get_run().recipe is not None and current().tap is None
    return found


def obstacle(earlier: Any, wanted: Any) -> str:
    """Return why a job has other frames than one with more frames has first; "" if they are the same.

    earlier, wanted: the configurations.
    """
    length = wanted.frames_per_episode
    if not length or not 0 < earlier.num_frames <= length:
        return ""
    return (
        f"up to {length} frames are one episode, which has the seed of the job; of more frames each episode has a seed "
        "of its own, so that the earlier frames would be others"
    )


def can_be_passed_over(writers: Sequence[Writer], episode: Episode) -> bool:
    """Return whether no frame of an episode is this process's to make, and all writers can count it unseen."""
    return count_unwanted(writers, episode.first, episode.frames) == episode.frames
