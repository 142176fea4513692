"""The joints with one axis of a running simulation, which robots are read and driven by."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from usdsdg.errors import PhysicsError
from usdsdg_physics.play import PlaySession


class SimulatedJoints:
    """Reads and moves revolute and prismatic joints, by path; positions are angles [rad] or distances [stage units].

    All but `paths` raise a PhysicsError where a path is no joint with one axis that is simulated.
    """

    def __init__(self, session: PlaySession) -> None:
        self._session = session

    @property
    def paths(self) -> tuple[str, ...]:
        """Paths of the joints with one axis."""
        return tuple(path for path, joint in self._session.current_scene().joints.items() if len(joint.axes) == 1)

    def state(self, joints: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
        """Return the positions and velocities (N,) of joints."""
        keys, units = self._keys(joints)
        positions, velocities = self._session.current_world().joint_state(keys)
        return positions / units, velocities / units

    def forces(self, joints: Sequence[str]) -> np.ndarray:
        """Return the forces and torques (N, 6) of joints; see `NewtonEngine.joint_forces`."""
        world, units = self._session.current_world(), self._session.units
        measured = world.joint_forces
        if unknown := [path for path in joints if measured is None or path not in measured.paths]:
            raise PhysicsError(
                f"{unknown[0]} is no joint of a simulated articulation whose base is not kinematic, or it closes a "
                "loop, so its forces are not measured. Apply UsdPhysics.ArticulationRootAPI to a prim above it."
            )
        newtons = units.kilograms * units.meters
        found = measured.of_joints(joints) if measured is not None else np.zeros((0, 6))
        return found / np.repeat([newtons, newtons * units.meters], 3)

    def set_state(
        self, joints: Sequence[str], positions: ArrayLike | None = None, velocities: ArrayLike | None = None
    ) -> None:
        """Move joints at once, and set their velocities; see `NewtonEngine.set_joint_state`."""
        keys, units = self._keys(joints)
        given = [
            {} if values is None else dict(zip(keys, (np.asarray(values, np.float64) * units).tolist(), strict=True))
            for values in (positions, velocities)
        ]
        self._session.current_world().set_joint_state(*given)
        self._session.write()

    def add_efforts(self, joints: Sequence[str], efforts: np.ndarray) -> None:
        """Push joints during the next step; see `NewtonEngine.apply_joint_efforts`."""
        keys, units = self._keys(joints)
        kilograms, meters = self._session.units.kilograms, self._session.units.meters
        # A force has one length in its unit, a torque two.
        newtons = kilograms * meters * np.where(units == 1.0, meters, 1.0)
        self._session.current_world().add_joint_efforts(dict(zip(keys, (efforts * newtons).tolist(), strict=True)))

    def _keys(self, joints: Sequence[str]) -> tuple[list[tuple[str, str]], np.ndarray]:
        """Return the axes of joints with one, and their units of position in SI."""
        known = self._session.scene.joints
        if unknown := [path for path in joints if path not in known or len(known[path].axes) != 1]:
            raise PhysicsError(f"{unknown[0]} is not a simulated revolute or prismatic joint, so it has no position")
        axes = [known[path].axes[0] for path in joints]
        keys = [(path, axis.name) for path, axis in zip(joints, axes)]
        return keys, np.array([1.0 if axis.angular else self._session.units.meters for axis in axes])
