"""What a physics sensor measured in the latest steps, at the times when it measures."""

from __future__ import annotations

from collections import deque
from typing import Generic, TypeVar

from pxr import Usd

from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation

Sample = TypeVar("Sample")


class Samples(Generic[Sample]):
    """The samples of a prim with the attributes enabled and sensorPeriod, the latest first, one per physics step.

    A sensor with a period that is longer than a step measures at its multiples. Samples are forgotten when the
    simulation stops.
    """

    def __init__(self, prim: Usd.Prim, size: int = 2) -> None:
        self.prim = prim
        self.all: deque[Sample] = deque(maxlen=size)
        self.times: deque[float] = deque(maxlen=size)
        self.dt = 0.0  # of the latest step [s]
        self.time = 0.0  # when it measured last [s]
        self.between: tuple[float, list[Sample]] | None = None  # part of the step before that, and both samples
        self._steps = 0

    @property
    def period(self) -> float:
        """The sensor's period [s]; not positive for every step."""
        return float(self.prim.GetAttribute("sensorPeriod").Get() or 0.0)

    @property
    def enabled(self) -> bool:
        return bool(self.prim.GetAttribute("enabled").Get())

    @property
    def is_every_step(self) -> bool:
        """Whether it measures at every step."""
        return self.period <= self.dt * (1.0 + 1e-6)

    def begin(self) -> None:
        """Forget samples of a simulation that has stopped."""
        steps = simulation().steps
        if steps < self._steps:
            self.all.clear()
            self.times.clear()
            self.time, self.between = 0.0, None
        self._steps = steps

    def add(self, sample: Sample, dt: float) -> None:
        """Add the sample of the step of `dt` seconds that was just taken."""
        self.begin()
        now = simulation().time
        self.all.appendleft(sample)
        self.times.appendleft(now)
        self.dt = dt
        if self.is_every_step:
            self.time, self.between = now, None
            return
        # Times are rounded, so that one of many periods may seem to be a step late.
        while self.time + self.period <= now + 1e-6:
            self.time += self.period
            self.between = (self.time - (now - dt)) / dt, list(self.all)[:2]
