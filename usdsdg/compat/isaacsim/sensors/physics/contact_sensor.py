"""`ContactSensor`: how strongly a rigid body is touched."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from pxr import Gf, UsdPhysics

from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.compat.isaacsim.sensors.physics import sensor_prims
from usdsdg.compat.isaacsim.sensors.physics.known_sensors import known_sensors
from usdsdg.compat.isaacsim.sensors.physics.physics_sensor import PhysicsSensor, split_path
from usdsdg.errors import BadPrim
from usdsdg.session.stage_context import current_stage


class ContactSensor(PhysicsSensor):
    """Reads the contacts of the rigid body above it after every physics step; forces are in the stage's units."""

    def __init__(
        self,
        prim_path: str,
        name: str | None = "contact_sensor",
        frequency: float | None = None,
        dt: float | None = None,
        translation: Sequence[float] | None = None,
        position: Sequence[float] | None = None,
        min_threshold: float | None = None,
        max_threshold: float | None = None,
        radius: float | None = None,
    ) -> None:
        """Wrap the sensor at a path, or define one below the collider that the path names.

        Args:
            frequency: How often it measures [Hz], or `dt` [s]; by default at every step.
            min_threshold: Force below which nothing touches; 0 by default.
            max_threshold: Largest force that is read; 100000 by default.
            radius: How near to the sensor's origin a contact counts [stage units]; by default anywhere.

        Raises:
            ValueError: both frequency and dt are given.
            BadPrim: the prim above is no collider, or no rigid body is above.
        """
        period = sensor_prims.period_of(frequency, dt)
        parent, own_name = split_path(prim_path)
        above = current_stage().GetPrimAtPath(parent)
        if above and not above.HasAPI(UsdPhysics.CollisionAPI):
            raise BadPrim(f"{parent} is no collider, so it has no contacts. Put the sensor below one.")
        is_new = not current_stage().GetPrimAtPath(prim_path)
        if is_new:
            attributes = {"threshold": Gf.Vec2f(0, 100000), "radius": -1.0, "sensorPeriod": period}
            sensor_prims.define_contact_sensor(parent, own_name, attributes=attributes)
        super().__init__(
            prim_path, name or "", position, translation, None, None if frequency is None and dt is None else period
        )
        for given, setter in (
            (min_threshold, self.set_min_threshold), (max_threshold, self.set_max_threshold), (radius, self.set_radius),
        ):  # fmt: skip
            if given is not None:
                setter(given)
        self._readings = known_sensors().contact(prim_path)
        self._frame: dict[str, Any] = {"time": 0, "physics_step": 0}

    def get_current_frame(self) -> dict[str, Any]:
        """Return what was measured last, in the same dictionary every time.

        Keys are time [s], physics_step, in_contact, force, number_of_contacts, and after
        `add_raw_contact_data_to_frame` contacts: a list of body0, body1, position (3,), normal (3,) toward body 0 and
        impulse (3,) on it. Before the first step there are time and physics_step alone.
        """
        reading, frame = self._readings.reading(), self._frame
        if not reading.is_valid:
            return frame
        frame["in_contact"], frame["force"], frame["time"] = reading.in_contact, reading.value, reading.time
        frame["number_of_contacts"] = len(reading.contacts)
        frame["physics_step"] = float(simulation().steps)
        if "contacts" in frame:
            frame["contacts"] = [
                {
                    "body0": each.body0, "body1": each.body1, "position": np.array(each.position, np.float32),
                    "normal": np.array(each.normal, np.float32), "impulse": np.array(each.impulse, np.float32),
                }
                for each in reading.contacts
            ]  # fmt: skip
        return frame

    def add_raw_contact_data_to_frame(self) -> None:
        """Let frames list the points of contact."""
        self._frame["contacts"] = []

    def remove_raw_contact_data_from_frame(self) -> None:
        """Let frames not list the points of contact any more."""
        self._frame.pop("contacts", None)

    def get_radius(self) -> float:
        """Return how near to the sensor's origin a contact counts [stage units]; not positive for anywhere."""
        return float(self.prim.GetAttribute("radius").Get())

    def set_radius(self, value: float) -> None:
        self.prim.GetAttribute("radius").Set(value)

    def get_min_threshold(self) -> float:
        return float(self.prim.GetAttribute("threshold").Get()[0])

    def set_min_threshold(self, value: float) -> None:
        self.prim.GetAttribute("threshold").Set(Gf.Vec2f(value, self.get_max_threshold()))

    def get_max_threshold(self) -> float:
        return float(self.prim.GetAttribute("threshold").Get()[1])

    def set_max_threshold(self, value: float) -> None:
        self.prim.GetAttribute("threshold").Set(Gf.Vec2f(self.get_min_threshold(), value))
