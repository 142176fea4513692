"""What sensors of motion read: acceleration, angular velocity and orientation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pxr import Usd

from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.compat.isaacsim.sensors.physics.samples import Samples
from usdsdg.compat.isaacsim.sensors.physics.sensor_prims import body_above
from usdsdg.compat.wrappers import poses
from usdsdg.session import body_velocities, engines
from usdsdg.stage.poses.rotations import matrix_from_quat


@dataclass(frozen=True)
class ImuReading:
    """What a sensor of motion read, in its own axes; invalid before the first step."""

    is_valid: bool
    time: float
    lin_acc: np.ndarray  # (3,) [stage units/s²]
    ang_vel: np.ndarray  # (3,) [rad/s]
    orientation: np.ndarray  # (4,) w, x, y, z, in the world


@dataclass(frozen=True)
class _Motion:
    """How the sensor moved at the end of a step, in the world."""

    velocity: np.ndarray  # (3,) of the sensor's origin
    turning: np.ndarray  # (3,)
    orientation: np.ndarray  # (4,) w, x, y, z


class ImuReadings:
    """Reads the motion of a sensor on a rigid body after every physics step."""

    def __init__(self, prim: Usd.Prim) -> None:
        """Begin to read.

        Raises:
            BadPrim: there is no rigid body above the sensor.
        """
        self._prim, self._body = prim, body_above(prim)
        size = 2 * max(self._width(name) for name in ("linearAcceleration", "angularVelocity", "orientation"))
        self._samples: Samples[_Motion] = Samples(prim, max(size, 20))
        self._before: _Motion | None = None  # at the beginning of the first step
        self._ends = [simulation().on_step(self._begin, before=True), simulation().on_step(self._step, before=False)]

    def reading(self, *, latest: bool = False, gravity: bool = True) -> ImuReading:
        """Return the reading at the time when the sensor measured last, or with `latest` after the latest step.

        Args:
            gravity: Whether a sensor at rest reads what holds it against gravity, and one in free fall nothing.
        """
        samples = self._samples
        samples.begin()
        if not samples.enabled or not samples.all:
            return ImuReading(False, 0.0, np.zeros(3), np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
        found = self._filtered(0)
        time = samples.times[0]
        if not latest and not samples.is_every_step:
            time, part = samples.time, samples.between[0] if samples.between else 0.0
            behind = max(0, round((samples.times[0] - time) / samples.dt - (1.0 - part)))
            newer, older = self._filtered(behind), self._filtered(min(behind + 1, len(samples.all) - 1))
            found = tuple(old + part * (new - old) for new, old in zip(newer, older))
        acceleration, turning, orientation = found
        orientation = orientation / np.linalg.norm(orientation)
        axes = matrix_from_quat(poses.xyzw(orientation))  # row vectors: of the sensor to the world
        if gravity:
            acceleration = acceleration - np.array(simulation().scene().get_gravity(), np.float64)
        return ImuReading(True, time, axes @ acceleration, axes @ turning, orientation)

    def _filtered(self, behind: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return acceleration, angular velocity and orientation some steps ago, averaged as the prim says."""
        motions = [*list(self._samples.all)[behind:]] + ([self._before] if self._before else [])
        width = self._width("linearAcceleration")
        spans = [(first, first + width) for first in range(width) if first + width < len(motions)]
        spans = spans or [(0, len(motions) - 1)]
        slopes = [
            (motions[new].velocity - motions[old].velocity) / (max(1, old - new) * self._samples.dt)
            for new, old in spans
        ]
        recent = motions[: self._width("angularVelocity")]
        turns = motions[: self._width("orientation")]
        return (
            np.mean(slopes, axis=0),
            np.mean([motion.turning for motion in recent], axis=0),
            np.mean([_same_side(motion.orientation, turns[0].orientation) for motion in turns], axis=0),
        )

    def _width(self, name: str) -> int:
        return max(1, int(self._prim.GetAttribute(f"{name}FilterWidth").Get() or 1))

    def _begin(self, _dt: float, _context: object) -> None:
        self._samples.begin()
        if not self._samples.all and self._prim.IsValid():
            self._before = self._moving()

    def _step(self, dt: float, _context: object) -> None:
        if not self._prim.IsValid():
            for end in self._ends:
                end()
        elif self._samples.enabled:
            if len(self._samples.all) == self._samples.all.maxlen:
                self._before = None
            self._samples.add(self._moving(), dt)

    def _moving(self) -> _Motion:
        linear, angular = (each[0].astype(np.float64) for each in body_velocities.velocities([self._body]))
        place, turn = poses.world_poses([self._prim])
        origin, axes = poses.world_poses([self._body])
        path = str(self._body.GetPath())
        if path in engines.physics().rigid_bodies:
            center = engines.physics().mass_properties([path]).center[0]
            origin = origin + center @ matrix_from_quat(poses.xyzw(axes[0].astype(np.float64)))
        return _Motion(linear + np.cross(angular, place[0] - origin[0]), angular, turn[0].astype(np.float64))


def _same_side(quat: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return a rotation's quaternion (4,) that is nearer to another, of the two that it has."""
    return quat if quat @ other >= 0.0 else -quat
