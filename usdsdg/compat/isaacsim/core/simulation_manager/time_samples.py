"""The simulated time that belongs to the reference time of an image."""

from __future__ import annotations

from collections import deque

import numpy as np

# The number of steps that are remembered.
REMEMBERED = 1000


class TimeSamples:
    """Reference times, those of the timeline, and simulated times after the latest physics steps [s]."""

    def __init__(self) -> None:
        self.times: deque[tuple[float, float]] = deque(maxlen=REMEMBERED)

    def note(self, reference: float, simulated: float) -> None:
        """Remember the times after a step; of several steps at one reference time, the last."""
        if self.times and reference < self.times[-1][0]:  # another loop of the timeline
            self.times.clear()
        elif self.times and reference == self.times[-1][0]:
            self.times.pop()
        self.times.append((reference, simulated))

    def clear(self) -> None:
        self.times.clear()

    def simulated_at(self, reference: float, *, tolerance: float) -> float | None:
        """Return the simulated time at a reference time, between steps interpolated; None beyond those remembered."""
        if not self.times or not self.times[0][0] - tolerance <= reference <= self.times[-1][0] + tolerance:
            return None
        references, simulated = zip(*self.times, strict=True)
        return float(np.interp(reference, references, simulated))
