"""The interface behind `SimulationManager`, which scripts ask for the simulated time of an image."""

from typing import NamedTuple

from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation

# Ticks per second of reference times.
TICKS = 1_000_000


class RationalTime(NamedTuple):
    """A time as a fraction of seconds."""

    numerator: int
    denominator: int


class SimulationManagerInterface:
    """Simulated times; reference times are fractions of seconds, as of the annotator ReferenceTime."""

    def get_simulation_time(self) -> float:
        """Return the simulated time [s]."""
        return simulation().time

    def get_sample_count(self) -> int:
        """Return the number of physics steps whose times are remembered."""
        return len(simulation().samples.times)

    def get_sample_range(self) -> tuple[RationalTime, RationalTime] | None:
        """Return the earliest and the latest reference time that is remembered; None without any."""
        times = simulation().samples.times
        if not times:
            return None
        return _rational(times[0][0]), _rational(times[-1][0])

    def get_simulation_time_at_time(self, reference_time: tuple[int, int]) -> float:
        """Return the simulated time [s] at a reference time; the current one beyond those that are remembered."""
        numerator, denominator = reference_time
        seconds = numerator / denominator if denominator else 0.0
        found = simulation().samples.simulated_at(seconds, tolerance=1 / TICKS)
        return simulation().time if found is None else found


def _rational(seconds: float) -> RationalTime:
    return RationalTime(round(seconds * TICKS), TICKS)


class InterfaceAttribute:
    """The class attribute that is the interface; times are remembered from when it is first read on."""

    def __get__(self, instance: object, owner: type) -> SimulationManagerInterface:
        simulation()
        return SimulationManagerInterface()
