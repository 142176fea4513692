"""`RigidPrim`: several rigid bodies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import UsdPhysics

from usdsdg.compat.isaacsim.core.prims.xform_prim import XFormPrim
from usdsdg.compat.isaacsim.core.utils.types import DynamicsViewState
from usdsdg.compat.wrappers import bodies
from usdsdg.compat.wrappers.arrays import as_numpy, chosen, column, rows
from usdsdg.compat.wrappers.unsupported import Refused
from usdsdg.errors import warn_once
from usdsdg.session import body_velocities
from usdsdg.stage.schemas import physx

if TYPE_CHECKING:
    from usdsdg.compat.wrappers.arrays import Indices, Values

_CONTACTS = "contact forces are not measured; overlaps are: get_physx_scene_query_interface().overlap_box"
_MASS = "what physics computes of a body's mass cannot be read or set; author UsdPhysics.MassAPI"


class RigidPrim(XFormPrim):
    """Rigid bodies. Velocities are world vectors [stage units/s, rad/s] of the latest physics step."""

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
        """Wrap prims, see `XFormPrim`, and make them rigid bodies; contacts are not reported."""
        super().__init__(
            prim_paths_expr, name, positions, translations, orientations, scales, visibilities, reset_xform_properties
        )
        bodies.make_rigid(self.prims)
        if masses is not None:
            self.set_masses(masses)
        if densities is not None:
            self.set_densities(densities)
        self._default_velocities = [np.zeros((self.count, 3), np.float32), np.zeros((self.count, 3), np.float32)]
        for row, values in enumerate((linear_velocities, angular_velocities)):
            if values is not None:
                self._default_velocities[row] = np.array(rows(values, 3, self.count), np.float32)
        if linear_velocities is not None or angular_velocities is not None:
            bodies.set_velocities(self.prims, *self._default_velocities)
        if track_contact_forces or contact_filter_prim_paths_expr or max_contact_count:
            warn_once(f"{name}: contacts are not reported, so the arguments about them are ignored")

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
        vectors = [None if each is None else rows(each, 3, len(prims)) for each in (forces, torques, positions)]
        bodies.push(prims, *vectors, local=not is_global)

    # --- masses ---
    def get_masses(self, indices: Indices = None, clone: bool = True) -> np.ndarray:
        """Return the authored masses (N,).

        Raises:
            Unsupported: physics plays, and the mass of a body is not authored.
        """
        return self._out(bodies.masses(self._chosen(indices))[:, 0])[0]

    def get_inv_masses(self, indices: Indices = None, clone: bool = True) -> np.ndarray:
        """Return 1 / mass (N,)."""
        return self._out(1.0 / bodies.masses(self._chosen(indices))[:, 0])[0]

    def set_masses(self, masses: Values, indices: Indices = None) -> None:
        self._write(UsdPhysics.MassAPI, "Mass", masses, indices)

    def get_densities(self, indices: Indices = None) -> np.ndarray:
        """Return the authored densities (N,); 0 where none is."""
        api = UsdPhysics.MassAPI
        return self._out(bodies.read(self._chosen(indices), api, api.GetDensityAttr, 0.0)[:, 0])[0]

    def set_densities(self, densities: Values, indices: Indices = None) -> None:
        self._write(UsdPhysics.MassAPI, "Density", densities, indices)

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

    # --- what physics here does not give ---
    num_shapes = Refused("RigidPrim.num_shapes", _MASS)
    get_coms = Refused("RigidPrim.get_coms", _MASS)
    set_coms = Refused("RigidPrim.set_coms", _MASS)
    get_inertias = Refused("RigidPrim.get_inertias", _MASS)
    get_inv_inertias = Refused("RigidPrim.get_inv_inertias", _MASS)
    set_inertias = Refused("RigidPrim.set_inertias", _MASS)
    get_net_contact_forces = Refused("RigidPrim.get_net_contact_forces", _CONTACTS)
    get_contact_force_matrix = Refused("RigidPrim.get_contact_force_matrix", _CONTACTS)
    get_contact_force_data = Refused("RigidPrim.get_contact_force_data", _CONTACTS)
    get_friction_data = Refused("RigidPrim.get_friction_data", _CONTACTS)

    def _write(self, api: type, attribute: str, values: Values, indices: Indices) -> None:
        prims = self._chosen(indices)
        bodies.write(prims, api, attribute, column(values, len(prims)))

    def _switch(self, api: type, attribute: str, value: bool, indices: Indices) -> None:
        prims = self._chosen(indices)
        bodies.write(prims, api, attribute, [value] * len(prims))
