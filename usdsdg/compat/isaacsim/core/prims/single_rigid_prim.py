"""`SingleRigidPrim`: one rigid body."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.compat.isaacsim.core.prims.rigid_prim import RigidPrim
from usdsdg.compat.isaacsim.core.prims.single_xform_prim import SingleXFormPrim
from usdsdg.compat.isaacsim.core.utils.types import DynamicState
from usdsdg.compat.wrappers.prim_paths import existing_prim

if TYPE_CHECKING:
    from usdsdg.compat.wrappers.arrays import Values


class SingleRigidPrim(SingleXFormPrim):
    """One rigid body; velocities are world vectors [stage units/s, rad/s]."""

    _bodies: RigidPrim

    def __init__(
        self,
        prim_path: str,
        name: str = "rigid_prim",
        position: Sequence[float] | None = None,
        translation: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
        scale: Sequence[float] | None = None,
        visible: bool | None = None,
        reset_xform_properties: bool = True,
        mass: float | None = None,
        density: float | None = None,
        linear_velocity: Sequence[float] | None = None,
        angular_velocity: Sequence[float] | None = None,
    ) -> None:
        """Wrap a prim, see `SingleXFormPrim`, and make it a rigid body.

        Raises:
            BadPrim: there is no such prim.
        """
        existing_prim(prim_path)
        # Named, since a dynamic object is a SingleGeometryPrim too, which has been initialized before.
        SingleXFormPrim.__init__(
            self, prim_path, name, position, translation, orientation, scale, visible, reset_xform_properties
        )
        self._bodies = self._view = RigidPrim(
            prim_path, name, reset_xform_properties=False, masses=mass, densities=density,
            linear_velocities=linear_velocity, angular_velocities=angular_velocity,
        )  # fmt: skip

    def get_linear_velocity(self) -> np.ndarray:
        """Return (3,) [stage units/s]."""
        return self._bodies.get_linear_velocities()[0]

    def set_linear_velocity(self, velocity: Values) -> None:
        self._bodies.set_linear_velocities(velocity)

    def get_angular_velocity(self) -> np.ndarray:
        """Return (3,) [rad/s]."""
        return self._bodies.get_angular_velocities()[0]

    def set_angular_velocity(self, velocity: Values) -> None:
        self._bodies.set_angular_velocities(velocity)

    def get_mass(self) -> float:
        """Return the authored mass; while physics plays, where none is, what follows from the shapes."""
        return float(self._bodies.get_masses()[0])

    def set_mass(self, mass: float) -> None:
        self._bodies.set_masses(mass)

    def get_com(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Return the center of mass (1, 3) and the orientation of the principal axes (1, 4) in the body's frame.

        None, with a warning, where physics does not play.
        """
        found = self._bodies.get_coms()
        return None if found is None else (found[0][0], found[1][0])

    def set_com(self, position: Values, orientation: Values) -> None:
        """Set the center of mass (3,) and the orientation of the principal axes (4,): see `RigidPrim.set_coms`."""
        self._bodies.set_coms(position, orientation)

    def get_density(self) -> float:
        return float(self._bodies.get_densities()[0])

    def set_density(self, density: float) -> None:
        self._bodies.set_densities(density)

    def get_sleep_threshold(self) -> float:
        return float(self._bodies.get_sleep_thresholds()[0])

    def set_sleep_threshold(self, threshold: float) -> None:
        self._bodies.set_sleep_thresholds(threshold)

    def enable_rigid_body_physics(self) -> None:
        self._bodies.enable_rigid_body_physics()

    def disable_rigid_body_physics(self) -> None:
        """Make the body static."""
        self._bodies.disable_rigid_body_physics()

    def get_default_state(self) -> DynamicState:  # pyright: ignore[reportIncompatibleMethodOverride]
        state = self._bodies.get_default_state()
        return DynamicState(
            state.positions[0], state.orientations[0], state.linear_velocities[0], state.angular_velocities[0]
        )

    def set_default_state(  # pyright: ignore[reportIncompatibleMethodOverride]
        self,
        position: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
        linear_velocity: Sequence[float] | None = None,
        angular_velocity: Sequence[float] | None = None,
    ) -> None:
        """Set pose and velocities that `post_reset` restores; what is not given stays."""
        self._bodies.set_default_state(position, orientation, linear_velocity, angular_velocity)

    def get_current_dynamic_state(self) -> DynamicState:
        """Return the pose in the world and the velocities."""
        return DynamicState(*self.get_world_pose(), self.get_linear_velocity(), self.get_angular_velocity())
