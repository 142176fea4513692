"""`RigidPrim`: several rigid bodies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import UsdPhysics

from usdsdg.compat.isaacsim.core.prims.contact_view import ContactTracker
from usdsdg.compat.isaacsim.core.prims.xform_prim import XFormPrim
from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.compat.isaacsim.core.utils.types import DynamicsViewState
from usdsdg.compat.wrappers import bodies, mass_properties
from usdsdg.compat.wrappers.arrays import as_numpy, chosen, column, pose_rows, rows, rows_or_none
from usdsdg.errors import warn_once
from usdsdg.session import body_velocities
from usdsdg.stage.schemas import physx

if TYPE_CHECKING:
    from usdsdg.compat.wrappers.arrays import Indices, Values


class RigidPrim(ContactTracker, XFormPrim):
    """Rigid bodies. Velocities are world vectors [stage units/s, rad/s] of the latest physics step.

    Contact forces are those of `RigidContactView`.
    """

    def __init__(
        self,
        prim_paths_expr: str | Sequence[str],
        name: str = "rigid_prim_view",
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        visibilities: Values | None = None,
        reset_xform_properties: bool = True,
        masses: Values | None = None,
        densities: Values | None = None,
        linear_velocities: Values | None = None,
        angular_velocities: Values | None = None,
        track_contact_forces: bool = False,
        prepare_contact_sensors: bool = True,
        disable_stablization: bool = True,
        contact_filter_prim_paths_expr: Sequence[str] | None = None,
        max_contact_count: int = 0,
    ) -> None:
        """Wrap prims, see `XFormPrim`, and make them rigid bodies.

        Args:
            track_contact_forces: Whether `get_net_contact_forces` returns forces; so it does with filters.
            prepare_contact_sensors: Let bodies whose contacts are tracked, and filters, report their contacts.
            disable_stablization: Without effect: contact forces are those that the solver applied.
            contact_filter_prim_paths_expr: Prims whose contacts are reported one by one, see `RigidContactView`.
            max_contact_count: How many contact points are returned at most.
        """
        super().__init__(
            prim_paths_expr, name, positions, translations, orientations, scales, visibilities, reset_xform_properties
        )
        bodies.make_rigid(self.prims)
        if masses is not None:
            self._write(UsdPhysics.MassAPI, "Mass", masses, None)
        if densities is not None:
            self.set_densities(densities)
        self._default_velocities = [np.zeros((self.count, 3), np.float32), np.zeros((self.count, 3), np.float32)]
        for row, values in enumerate((linear_velocities, angular_velocities)):
            if values is not None:
                self._default_velocities[row] = np.array(rows(values, 3, self.count), np.float32)
        if linear_velocities is not None or angular_velocities is not None:
            bodies.set_velocities(self.prims, *self._default_velocities)
        self._track_contacts(
            prim_paths_expr, name, contact_filter_prim_paths_expr, track=track_contact_forces,
            prepare=prepare_contact_sensors, max_count=max_contact_count,
        )  # fmt: skip

    @property
    def num_shapes(self) -> int:
        """How many colliders the body has that has most; a collider of several convex parts counts once."""
        return mass_properties.num_shapes(self.prims)

    def is_physics_handle_valid(self) -> bool:
        """Whether physics simulates."""
        return bodies.is_simulating()

    def post_reset(self) -> None:
        """Set poses and velocities as `set_default_state` says."""
        super().post_reset()
        bodies.set_velocities(self.prims, *self._default_velocities)

    # --- velocities ---
    def get_linear_velocities(self, indices: Indices = None, clone: bool = True) -> np.ndarray:
        """Return (N, 3) [stage units/s]."""
        return self._out(body_velocities.velocities(self._chosen(indices))[0])[0]

    def get_angular_velocities(self, indices: Indices = None, clone: bool = True) -> np.ndarray:
        """Return (N, 3) [rad/s]."""
        return self._out(body_velocities.velocities(self._chosen(indices))[1])[0]

    def get_velocities(self, indices: Indices = None, clone: bool = True) -> np.ndarray:
        """Return (N, 6): linear [stage units/s], then angular velocities [rad/s]."""
        return self._out(np.hstack(body_velocities.velocities(self._chosen(indices))))[0]

    def set_linear_velocities(self, velocities: Values, indices: Indices = None) -> None:
        prims = self._chosen(indices)
        bodies.set_velocities(prims, rows(velocities, 3, len(prims)), None)

    def set_angular_velocities(self, velocities: Values, indices: Indices = None) -> None:
        prims = self._chosen(indices)
        bodies.set_velocities(prims, None, rows(velocities, 3, len(prims)))

    def set_velocities(self, velocities: Values, indices: Indices = None) -> None:
        """Set (N, 6): linear [stage units/s], then angular velocities [rad/s]."""
        prims = self._chosen(indices)
        both = rows(velocities, 6, len(prims))
        bodies.set_velocities(prims, both[:, :3], both[:, 3:])

    # --- forces ---
    def apply_forces(self, forces: Values, indices: Indices = None, is_global: bool = True) -> None:
        """Push centers of mass during the next step: (N, 3), in the stage's units of mass, length and s⁻².

        Args:
            is_global: The forces are in the world's axes, not in the bodies' own.

        Raises:
            PhysicsError: physics does not play.
        """
        self.apply_forces_and_torques_at_pos(forces, indices=indices, is_global=is_global)

    def apply_forces_and_torques_at_pos(
        self,
        forces: Values | None = None,
        torques: Values | None = None,
        positions: Values | None = None,
        indices: Indices = None,
        is_global: bool = True,
    ) -> None:
        """Push and turn bodies during the next step: (N, 3) each, in the stage's units of mass, length and s⁻².

        Args:
            positions: Where the forces act, (N, 3) [stage units]; by default the centers of mass.
            is_global: Forces, torques and positions are the world's, not in the bodies' own axes.

        Raises:
            PhysicsError: physics does not play.
        """
        prims = self._chosen(indices)
        vectors = [rows_or_none(each, 3, len(prims)) for each in (forces, torques, positions)]
        bodies.push(prims, *vectors, local=not is_global)

    # --- masses ---
    def get_masses(self, indices: Indices = None, clone: bool = True) -> np.ndarray:
        """Return the authored masses (N,); while physics plays, where none is, what follows from the shapes."""
        return self._out(bodies.masses(self._chosen(indices))[:, 0])[0]

    def get_inv_masses(self, indices: Indices = None, clone: bool = True) -> np.ndarray:
        """Return 1 / mass (N,)."""
        return self._out(1.0 / bodies.masses(self._chosen(indices))[:, 0])[0]

    def set_masses(self, masses: Values, indices: Indices = None) -> None:
        """Set (N,): while physics plays until it stops, as in PhysX, else on the stage."""
        prims = self._chosen(indices)
        bodies.set_masses(prims, column(masses, len(prims)))

    def get_densities(self, indices: Indices = None) -> np.ndarray:
        """Return the authored densities (N,); 0 where none is."""
        api = UsdPhysics.MassAPI
        return self._out(bodies.read(self._chosen(indices), api, api.GetDensityAttr, 0.0)[:, 0])[0]

    def set_densities(self, densities: Values, indices: Indices = None) -> None:
        self._write(UsdPhysics.MassAPI, "Density", densities, indices)

    def get_coms(self, indices: Indices = None, clone: bool = True) -> tuple[np.ndarray, np.ndarray] | None:
        """Return centers of mass (N, 1, 3) and orientations of the principal axes (N, 1, 4) in the bodies' frames.

        With the backend "warp" they are (N, 3) and (N, 4). None, with a warning, where physics does not play.
        """
        if not self._is_simulated("get_coms"):
            return None
        found = mass_properties.centers(self._chosen(indices))
        flat = simulation().backend == "warp"
        positions, orientations = self._out(*(each if flat else each[:, None] for each in found))
        return positions, orientations

    def set_coms(
        self, positions: Values | None = None, orientations: Values | None = None, indices: Indices = None
    ) -> None:
        """Set centers of mass (N, 1, 3) and principal axes (N, 1, 4) in the bodies' frames; what is not given stays.

        The moments of inertia stay too. Nothing is set, with a warning, where physics does not play.
        """
        if self._is_simulated("set_coms"):
            prims = self._chosen(indices)
            mass_properties.set_centers(prims, *pose_rows(positions, orientations, len(prims)))

    def get_inertias(self, indices: Indices = None, clone: bool = True) -> np.ndarray | None:
        """Return inertias (N, 9) about the centers of mass along the bodies' axes, in the stage's mass · length².

        None, with a warning, where physics does not play.
        """
        if not self._is_simulated("get_inertias"):
            return None
        return self._out(mass_properties.inertias(self._chosen(indices)))[0]

    def get_inv_inertias(self, indices: Indices = None, clone: bool = True) -> np.ndarray | None:
        """Return the inverses (N, 9) of the inertias; None, with a warning, where physics does not play."""
        if not self._is_simulated("get_inv_inertias"):
            return None
        return self._out(mass_properties.inertias(self._chosen(indices), inverse=True))[0]

    def set_inertias(self, values: Values, indices: Indices = None) -> None:
        """Set inertias (N, 9) about the centers of mass; not, with a warning, where physics does not play."""
        if self._is_simulated("set_inertias"):
            prims = self._chosen(indices)
            mass_properties.set_inertias(prims, rows(values, 9, len(prims)))

    # --- switches ---
    def get_sleep_thresholds(self, indices: Indices = None) -> np.ndarray:
        """Return the energies per mass (N,) below which bodies may sleep."""
        api = physx.PhysxRigidBodyAPI
        values = bodies.read(self._chosen(indices), api, lambda each: each.GetSleepThresholdAttr(), 0.0)
        return self._out(values[:, 0])[0]

    def set_sleep_thresholds(self, thresholds: Values, indices: Indices = None) -> None:
        self._write(physx.PhysxRigidBodyAPI, "SleepThreshold", thresholds, indices)

    def enable_rigid_body_physics(self, indices: Indices = None) -> None:
        self._switch(UsdPhysics.RigidBodyAPI, "RigidBodyEnabled", True, indices)

    def disable_rigid_body_physics(self, indices: Indices = None) -> None:
        """Make bodies static."""
        self._switch(UsdPhysics.RigidBodyAPI, "RigidBodyEnabled", False, indices)

    def enable_gravities(self, indices: Indices = None) -> None:
        self._switch(physx.PhysxRigidBodyAPI, "DisableGravity", False, indices)

    def disable_gravities(self, indices: Indices = None) -> None:
        self._switch(physx.PhysxRigidBodyAPI, "DisableGravity", True, indices)

    # --- states ---
    def get_default_state(self) -> DynamicsViewState:  # pyright: ignore[reportIncompatibleMethodOverride]
        poses = super().get_default_state()
        return DynamicsViewState(poses.positions, poses.orientations, *self._out(*self._default_velocities))

    def set_default_state(  # pyright: ignore[reportIncompatibleMethodOverride]
        self,
        positions: Values | None = None,
        orientations: Values | None = None,
        linear_velocities: Values | None = None,
        angular_velocities: Values | None = None,
        indices: Indices = None,
    ) -> None:
        """Set the poses and velocities that `post_reset` restores; what is not given stays."""
        super().set_default_state(positions, orientations, indices)
        where = chosen(indices, self.count)
        for row, values in enumerate((linear_velocities, angular_velocities)):
            if values is not None:
                self._default_velocities[row][where] = rows(as_numpy(values), 3, len(where))

    def get_current_dynamic_state(self) -> DynamicsViewState:
        """Return poses in the world and velocities."""
        return DynamicsViewState(*self.get_world_poses(), self.get_linear_velocities(), self.get_angular_velocities())

    def _is_simulated(self, caller: str) -> bool:
        """Whether physics simulates; warn where it does not."""
        if not bodies.is_simulating():
            warn_once(f"{self.name}: physics does not play, so {caller} does nothing")
        return bodies.is_simulating()

    def _write(self, api: type, attribute: str, values: Values, indices: Indices) -> None:
        prims = self._chosen(indices)
        bodies.write(prims, api, attribute, column(values, len(prims)))

    def _switch(self, api: type, attribute: str, value: bool, indices: Indices) -> None:
        prims = self._chosen(indices)
        bodies.write(prims, api, attribute, [value] * len(prims))
