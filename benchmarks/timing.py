"""Time in turns: what is compared runs in rounds, one after the other, so that a busy machine slows all alike.

CPU seconds are those of the whole process, all its threads together; medians over the rounds are what to compare.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

Work = Callable[[int], object]


@dataclass
class Timings:
    """Seconds of each round; results are those of all calls, the one to warm up included."""

    cpus: list[float] = field(default_factory=list)
    walls: list[float] = field(default_factory=list)
    results: list[object] = field(default_factory=list)

    @property
    def cpu(self) -> float:
        """Median CPU seconds."""
        return statistics.median(self.cpus)

    @property
    def wall(self) -> float:
        """Median seconds of the clock."""
        return statistics.median(self.walls)

    def add(self, work: Work, number: int) -> None:
        """Run `work(number)` and note how long it took."""
        cpu, wall = time.process_time(), time.perf_counter()
        result = work(number)
        self.walls.append(time.perf_counter() - wall)
        self.cpus.append(time.process_time() - cpu)
        self.results.append(result)


def in_turns(contenders: Mapping[str, Work], *, rounds: int = 5, before: Work | None = None) -> dict[str, Timings]:
    """Timings of every contender: a round to warm up, number 0, that is not timed, then rounds 1, 2, …

    Args:
        before: called with the round's number before each contender, in time that is not counted.
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
    """Timings of one contender."""
    return in_turns({"": work}, rounds=rounds, before=before)[""]
