"""`PhysicsSensor`: what both sensors have."""

from __future__ import annotations

from collections.abc import Sequence

from usdsdg.compat.isaacsim.core.prims import SingleXFormPrim


class PhysicsSensor(SingleXFormPrim):
    """A sensor with a period, which can be paused."""

    def __init__(
        self,
        prim_path: str,
        name: str,
        position: Sequence[float] | None,
        translation: Sequence[float] | None,
        orientation: Sequence[float] | None,
        dt: float | None,
    ) -> None:
        """Wrap the sensor's prim, and place it."""
        super().__init__(prim_path, name, position, translation, orientation)
        if dt is not None:
            self.set_dt(dt)

    def post_reset(self) -> None:
        """Do nothing: a sensor stays where it is on its body."""

    def resume(self) -> None:
        self.prim.GetAttribute("enabled").Set(True)

    def pause(self) -> None:
        self.prim.GetAttribute("enabled").Set(False)

    def is_paused(self) -> bool:
        return not self.prim.GetAttribute("enabled").Get()

    def set_frequency(self, value: float) -> None:
        """Set how often it measures [Hz]."""
        self.set_dt(1.0 / value)

    def get_frequency(self) -> int:
        """Return how often it measures [Hz]."""
        return round(1.0 / self.get_dt())

    def get_dt(self) -> float:
        """Return the period [s]."""
        return float(self.prim.GetAttribute("sensorPeriod").Get())

    def set_dt(self, value: float) -> None:
        """Set the period [s]."""
        self.prim.GetAttribute("sensorPeriod").Set(value)


def split_path(prim_path: str) -> tuple[str, str]:
    """Return the path of a sensor's parent, and its own name."""
    parent, _, name = prim_path.rpartition("/")
    return parent, name
