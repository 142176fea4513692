"""The physics sensors of the current stage, which read from the moment when they are asked for first."""

from __future__ import annotations

from typing import TypeVar

from pxr import Usd

from usdsdg.compat.isaacsim.sensors.physics.contact_readings import ContactReadings
from usdsdg.compat.isaacsim.sensors.physics.imu_readings import ImuReadings
from usdsdg.compat.wrappers.prim_paths import existing_prim
from usdsdg.session import stage_context
from usdsdg.session.session import current

Kind = TypeVar("Kind", ContactReadings, ImuReadings)


class KnownSensors:
    """Readings by the path of the sensor's prim."""

    def __init__(self) -> None:
        self._readings: dict[str, tuple[Usd.Prim, ContactReadings | ImuReadings]] = {}
        stage_context.on_new_stage(lambda _stage: self._readings.clear())

    def contact(self, path: str) -> ContactReadings:
        """Return the readings of the contact sensor at a path.

        Raises:
            BadPrim: there is no such prim, or no rigid body above it.
        """
        return self._of(path, ContactReadings)

    def imu(self, path: str) -> ImuReadings:
        """Return the readings of the sensor of motion at a path.

        Raises:
            BadPrim: there is no such prim, or no rigid body above it.
        """
        return self._of(path, ImuReadings)

    def _of(self, path: str, kind: type[Kind]) -> Kind:
        prim = existing_prim(path)
        known, readings = self._readings.get(path, (None, None))
        if known != prim or not isinstance(readings, kind):
            readings = kind(prim)
            self._readings[path] = prim, readings
        return readings


def known_sensors() -> KnownSensors:
    """Return the sensors of the session."""
    return current().physics_sensors
