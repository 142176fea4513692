"""`isaacsim.sensors.physics`: sensors of contacts and of motion at rigid bodies."""

from usdsdg.compat.isaacsim.sensors.physics.contact_sensor import ContactSensor
from usdsdg.compat.isaacsim.sensors.physics.imu_sensor import IMUSensor

__all__ = ["ContactSensor", "IMUSensor"]
