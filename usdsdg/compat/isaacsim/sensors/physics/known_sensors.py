"""The physics sensors of the current stage, which read from their making, a play, or the first question on."""

from __future__ import annotations

from typing import TypeVar

from pxr import Usd

from usdsdg.compat.isaacsim.sensors.physics.contact_readings import ContactReadings
from usdsdg.compat.isaacsim.sensors.physics.imu_readings import ImuReadings
from usdsdg.compat.isaacsim.sensors.physics.sensor_prims import has_body_above
from usdsdg.compat.wrappers.prim_paths import existing_prim
from usdsdg.session import stage_context
from usdsdg.session.session import current
from usdsdg.session.timeline import get_timeline

Kind = TypeVar("Kind", ContactReadings, ImuReadings)


class KnownSensors:
    """Readings by the path of the sensor's prim."""

    def __init__(self) -> None:
        self._readings: dict[str, tuple[Usd.Prim, ContactReadings | ImuReadings]] = {}
        self._begins_at_play = False
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

    def begin(self, prim: Usd.Prim) -> None:
        """Let a sensor read from now on, if there is a body above it; without, the first question is an error."""
        kind, path = prim.GetTypeName(), str(prim.GetPath())
        if kind == "IsaacContactSensor" and has_body_above(prim):
            self.contact(path)
        elif kind == "IsaacImuSensor" and has_body_above(prim):
            self.imu(path)

    def begin_at_play(self) -> None:
        """Let all sensors of the stage read from the next play on, and from now on if it plays."""
        if not self._begins_at_play:
            self._begins_at_play = True
            get_timeline().subscribe(lambda change: self._begin_all() if change == "play" else None)
        if get_timeline().is_playing():
            self._begin_all()

    def _begin_all(self) -> None:
        for prim in stage_context.current_stage().Traverse():
            self.begin(prim)

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
