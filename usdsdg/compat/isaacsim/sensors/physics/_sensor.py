"""`isaacsim.sensors.physics._sensor`: readings of sensors by path."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.compat.isaacsim.sensors.physics.contact_readings import ContactReading
from usdsdg.compat.isaacsim.sensors.physics.known_sensors import known_sensors
from usdsdg.compat.physics_schema_tools import intToSdfPath, sdfPathToInt
from usdsdg.compat.wrappers.prim_paths import prim_of
from usdsdg.errors import warn_once

_RAW = np.dtype([
    ("time", np.float32), ("dt", np.float32), ("body0", np.uint64), ("body1", np.uint64),
    ("position", np.float32, 3), ("normal", np.float32, 3), ("impulse", np.float32, 3),
])  # fmt: skip


class ContactSensorInterface:
    """Reads contact sensors."""

    def is_contact_sensor(self, sensor_path: str) -> bool:
        return prim_of(sensor_path).GetTypeName() == "IsaacContactSensor"

    def get_sensor_reading(self, sensor_path: str, use_latest_data: bool = False) -> ContactReading:
        """Return is_valid, time [s], in_contact and value, the force in the stage's units.

        Raises:
            BadPrim: there is no such prim, or no rigid body above it.
        """
        return known_sensors().contact(sensor_path).reading(latest=use_latest_data)

    def get_contact_sensor_raw_data(self, sensor_path: str) -> np.ndarray:
        """Return the points of contact (P,): time, dt, body0, body1, position, normal and impulse on body 0.

        Raises:
            BadPrim: there is no such prim, or no rigid body above it.
        """
        reading = known_sensors().contact(sensor_path).reading(latest=True)
        found, dt = np.zeros(len(reading.contacts), _RAW), simulation().scene().get_dt()
        for row, each in enumerate(reading.contacts):
            bodies = sdfPathToInt(each.body0), sdfPathToInt(each.body1)
            found[row] = (reading.time, dt, *bodies, each.position, each.normal, each.impulse)
        return found

    def decode_body_name(self, body: int) -> str:
        """Return the path of a body of raw data."""
        return str(intToSdfPath(int(body)))


class ImuSensorInterface:
    """Reads sensors of motion."""

    def is_imu_sensor(self, sensor_path: str) -> bool:
        return prim_of(sensor_path).GetTypeName() == "IsaacImuSensor"

    def get_sensor_reading(
        self,
        sensor_path: str,
        interpolation_function: Any = None,
        use_latest_data: bool = False,
        read_gravity: bool = True,
    ) -> SimpleNamespace:
        """Return is_valid, time [s], lin_acc_x …, ang_vel_x …, and orientation (x, y, z, w).

        Raises:
            BadPrim: there is no such prim, or no rigid body above it.
        """
        if interpolation_function is not None:
            warn_once("interpolation_function has no effect: readings between two steps are interpolated linearly")
        reading = known_sensors().imu(sensor_path).reading(latest=use_latest_data, gravity=read_gravity)
        parts = {
            f"{name}_{axis}": float(number)
            for name, values in (("lin_acc", reading.lin_acc), ("ang_vel", reading.ang_vel))
            for axis, number in zip("xyz", values)
        }
        w, x, y, z = reading.orientation.tolist()
        return SimpleNamespace(is_valid=reading.is_valid, time=reading.time, orientation=(x, y, z, w), **parts)


_contact, _imu = ContactSensorInterface(), ImuSensorInterface()


def acquire_contact_sensor_interface() -> ContactSensorInterface:
    """Return what reads contact sensors; those of the stage read from the next play on."""
    known_sensors().begin_at_play()
    return _contact


def acquire_imu_sensor_interface() -> ImuSensorInterface:
    """Return what reads sensors of motion; those of the stage read from the next play on."""
    known_sensors().begin_at_play()
    return _imu


def release_contact_sensor_interface(interface: ContactSensorInterface) -> None:
    """Do nothing: interfaces hold nothing."""


def release_imu_sensor_interface(interface: ImuSensorInterface) -> None:
    """Do nothing: interfaces hold nothing."""
