"""Commands that define physics sensors."""

from __future__ import annotations

from pxr import Gf, Usd

from usdsdg.compat.isaacsim.sensors.physics import sensor_prims
from usdsdg.compat.isaacsim.sensors.physics.known_sensors import known_sensors
from usdsdg.compat.omni.kit.commands.registry import command


@command("IsaacSensorCreateContactSensor")
def create_contact_sensor(
    path: str = "/Contact_Sensor",
    parent: str | None = None,
    min_threshold: float = 0,
    max_threshold: float = 100000,
    color: Gf.Vec4f | None = None,
    radius: float = -1,
    sensor_period: float = -1,
    translation: Gf.Vec3d | None = None,
) -> Usd.Prim:
    """Define a contact sensor below `parent`, which reports its contacts from then on; return it.

    Raises:
        BadPrim: there is no such parent.
    """
    values = {
        "threshold": Gf.Vec2f(min_threshold, max_threshold), "color": Gf.Vec4f(color or (1, 1, 1, 1)),
        "radius": radius, "sensorPeriod": sensor_period,
    }  # fmt: skip
    sensor = sensor_prims.define_contact_sensor(parent, path, attributes=values, translation=translation)
    known_sensors().begin(sensor)
    return sensor


@command("IsaacSensorCreateImuSensor")
def create_imu_sensor(
    path: str = "/Imu_Sensor",
    parent: str | None = None,
    sensor_period: float = -1,
    translation: Gf.Vec3d | None = None,
    orientation: Gf.Quatd | None = None,
    linear_acceleration_filter_size: int = 1,
    angular_velocity_filter_size: int = 1,
    orientation_filter_size: int = 1,
) -> Usd.Prim:
    """Define a sensor of motion below `parent`; return it.

    Raises:
        BadPrim: there is no such parent.
    """
    values = {
        "sensorPeriod": sensor_period, "linearAccelerationFilterWidth": linear_acceleration_filter_size,
        "angularVelocityFilterWidth": angular_velocity_filter_size, "orientationFilterWidth": orientation_filter_size,
    }  # fmt: skip
    sensor = sensor_prims.define_imu_sensor(
        parent, path, attributes=values, translation=translation, orientation=orientation
    )
    known_sensors().begin(sensor)
    return sensor
