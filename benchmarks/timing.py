"""Time contenders in turns, round by round, so that other load on the machine slows all alike.

CPU seconds are those of the whole process, all its threads together; compare medians over the rounds.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

Work = Callable[[int], object]


@dataclass
class Timings:
    """Seconds of each round, and the results of all calls, the warm-up round included."""

    cpus: list[float] = field(default_factory=list)
    walls: list[float] = field(default_factory=list)
    results: list[object] = field(default_factory=list)

    @property
    def cpu(self) -> float:
        """Median CPU seconds."""
        return statistics.median(self.cpus)

    @property
    def wall(self) -> float:
        """Median wall seconds."""
        return statistics.median(self.walls)

    def add(self, work: Work, number: int) -> None:
        """Run `work(number)` and record how long it took."""
        cpu, wall = time.process_time(), time.perf_counter()
        result = work(number)
        self.walls.append(time.perf_counter() - wall)
        self.cpus.append(time.process_time() - cpu)
        self.results.append(result)


def in_turns(contenders: Mapping[str, Work], *, rounds: int = 5, before: Work | None = None) -> dict[str, Timings]:
    """Return the timings of every contender: round 0 warms up and is not timed, then rounds 1, 2, …

    Args:
        before: called with the round's number before each contender; not timed.
    """
    timings = {name: Timings() for name in contenders}
    for number in range(rounds + 1):
        for name, work in contenders.items():
            if before is not None:
                before(number)
            if number == 0:
                timings[name].results.append(work(0))
            else:
                timings[name].add(work, number)
    return timings


def alone(work: Work, *, rounds: int = 5, before: Work | None = None) -> Timings:
    """Return the timings of one contender."""
    return in_turns({"": work}, rounds=rounds, before=before)[""]
