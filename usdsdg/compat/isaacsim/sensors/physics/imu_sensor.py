"""`IMUSensor`: how a rigid body accelerates and turns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.compat.isaacsim.sensors.physics import sensor_prims
from usdsdg.compat.isaacsim.sensors.physics.known_sensors import known_sensors
from usdsdg.compat.isaacsim.sensors.physics.physics_sensor import PhysicsSensor, split_path
from usdsdg.compat.wrappers.arrays import as_backend
from usdsdg.session.stage_context import current_stage


class IMUSensor(PhysicsSensor):
    """Reads the motion of the rigid body above it after every physics step, in the sensor's own axes.

    The acceleration is that of the sensor's origin: where the body turns, with the centripetal part.
    """

    def __init__(
        self,
        prim_path: str,
        name: str | None = "imu_sensor",
        frequency: float | None = None,
        dt: float | None = None,
        translation: Sequence[float] | None = None,
        position: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
        linear_acceleration_filter_size: int = 1,
        angular_velocity_filter_size: int = 1,
        orientation_filter_size: int = 1,
    ) -> None:
        """Wrap the sensor at a path, or define one below the rigid body that the path names.

        Args:
            frequency: How often it measures [Hz], or `dt` [s]; by default at every step.
            linear_acceleration_filter_size: Of a new sensor, over how many steps it averages; so are the others.

        Raises:
            ValueError: both frequency and dt are given.
            BadPrim: there is no rigid body above the sensor.
        """
        period = sensor_prims.period_of(frequency, dt)
        if not current_stage().GetPrimAtPath(prim_path):
            parent, own_name = split_path(prim_path)
            widths = {
                "linearAccelerationFilterWidth": max(1, linear_acceleration_filter_size),
                "angularVelocityFilterWidth": max(1, angular_velocity_filter_size),
                "orientationFilterWidth": max(1, orientation_filter_size),
            }
            sensor_prims.define_imu_sensor(parent, own_name, attributes=widths | {"sensorPeriod": period})
        super().__init__(
            prim_path, name or "", position, translation, orientation,
            None if frequency is None and dt is None else period,
        )  # fmt: skip
        self._readings = known_sensors().imu(prim_path)
        zeros = np.zeros(3, np.float32)
        self._frame: dict[str, Any] = {
            "time": 0, "physics_step": 0, "lin_acc": zeros, "ang_vel": zeros.copy(),
            "orientation": np.array([1.0, 0.0, 0.0, 0.0], np.float32), "is_valid": False,
        }  # fmt: skip

    def get_current_frame(self, read_gravity: bool = True) -> dict[str, Any]:
        """Return what was measured last, in the same dictionary every time.

        Keys are time [s], physics_step, lin_acc (3,) [stage units/s²], ang_vel (3,) [rad/s], orientation (4,)
        (w, x, y, z) in the world, and is_valid, False before the first step.

        Args:
            read_gravity: Whether a sensor at rest reads what holds it against gravity, and one in free fall nothing.
        """
        reading, frame = self._readings.reading(gravity=read_gravity), self._frame
        frame["is_valid"] = reading.is_valid
        if reading.is_valid:
            state = simulation()
            for key in ("lin_acc", "ang_vel", "orientation"):
                frame[key] = as_backend(getattr(reading, key).astype(np.float32), state.backend, state.device)
            frame["time"], frame["physics_step"] = float(reading.time), float(state.steps)
        return frame
