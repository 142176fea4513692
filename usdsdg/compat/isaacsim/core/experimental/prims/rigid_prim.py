"""`RigidPrim`: rigid bodies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import UsdPhysics

from usdsdg.compat.isaacsim.core.experimental.prims.contact_tracker import ContactTracker
from usdsdg.compat.wrappers import bodies, mass_properties
from usdsdg.compat.wrappers.arrays import column, pose_rows, rows, rows_or_none
from usdsdg.session import body_velocities
from usdsdg.stage.schemas import physx

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values


class RigidPrim(ContactTracker):
    """Rigid bodies. Poses and velocities are those of the latest physics step, which are on the stage."""

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        resolve_paths: bool = True,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = False,
        masses: Values | None = None,
        densities: Values | None = None,
        contact_filter_paths: str | Sequence[str] | None = None,
        max_contact_count: int = 0,
    ) -> None:
        """Wrap prims, see `XformPrim`, and make them rigid bodies.

        Args:
            masses: (N, 1); 0 computes them from the densities of the colliders.
            contact_filter_paths: Prims whose contacts are reported one by one, paths or patterns, each for all bodies;
                where there are as many as bodies, one for each. The bodies then report contacts, as with
                `max_contact_count`.
            max_contact_count: How many contact points are returned at most.
        """
        super().__init__(
            paths, resolve_paths=resolve_paths, positions=positions, translations=translations,
            orientations=orientations, scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        bodies.make_rigid(self.prims)
        if masses is not None:
            self._write(UsdPhysics.MassAPI, "Mass", masses, None)
        if densities is not None:
            self.set_densities(densities)
        self._track_contacts(contact_filter_paths or (), max_contact_count)

    def is_physics_tensor_entity_valid(self) -> bool:
        """Whether physics simulates."""
        return bodies.is_simulating()

    # --- velocities ---
    def get_velocities(self, *, indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return linear (N, 3) [stage units/s] and angular velocities (N, 3) [rad/s] in the world."""
        linear, angular = body_velocities.velocities(self._chosen(indices))
        return self._warp(linear), self._warp(angular)

    def set_velocities(
        self,
        linear_velocities: Values | None = None,
        angular_velocities: Values | None = None,
        *,
        indices: Indices = None,
    ) -> None:
        """Set linear [stage units/s] or angular velocities [rad/s] in the world; what is not given stays.

        Raises:
            AssertionError: neither is given.
        """
        if linear_velocities is None and angular_velocities is None:
            raise AssertionError("give linear_velocities or angular_velocities")
        prims = self._chosen(indices)
        both = (rows_or_none(each, 3, len(prims)) for each in (linear_velocities, angular_velocities))
        bodies.set_velocities(prims, *both)

    # --- forces ---
    def apply_forces(self, forces: Values, *, indices: Indices = None, local_frame: bool = False) -> None:
        """Push centers of mass during the next step: (N, 3), in the stage's units of mass, length and s⁻².

        Args:
            local_frame: The forces are in the bodies' own axes.

        Raises:
            PhysicsError: physics does not play.
        """
        self.apply_forces_and_torques_at_pos(forces, indices=indices, local_frame=local_frame)

    def apply_forces_and_torques_at_pos(
        self,
        forces: Values | None = None,
        torques: Values | None = None,
        *,
        positions: Values | None = None,
        indices: Indices = None,
        local_frame: bool = False,
    ) -> None:
        """Push and turn bodies during the next step: (N, 3) each, in the stage's units of mass, length and s⁻².

        Args:
            positions: Where the forces act, (N, 3) [stage units]; by default the centers of mass.
            local_frame: Forces, torques and positions are in the bodies' own axes, positions from their origins.

        Raises:
            AssertionError: neither forces nor torques are given.
            PhysicsError: physics does not play.
        """
        if forces is None and torques is None:
            raise AssertionError("give forces or torques")
        prims = self._chosen(indices)
        vectors = [rows_or_none(each, 3, len(prims)) for each in (forces, torques, positions)]
        bodies.push(prims, *vectors, local=local_frame)

    # --- masses ---
    def get_masses(self, *, indices: Indices = None, inverse: bool = False) -> wp.array:
        """Return the authored masses (N, 1), or 1/(mass + 1e-8) with `inverse`.

        While physics plays it is, where none is authored, the mass that follows from the shapes.
        """
        masses = bodies.masses(self._chosen(indices))
        return self._warp(np.float32(1.0) / (masses + np.float32(1e-8)) if inverse else masses)

    def set_masses(self, masses: Values, *, indices: Indices = None) -> None:
        """Set (N,): while physics plays until it stops, as in PhysX, else on the stage."""
        prims = self._chosen(indices)
        bodies.set_masses(prims, column(masses, len(prims)))

    def get_densities(self, *, indices: Indices = None) -> wp.array:
        """Return the authored densities (N, 1); 0 where none is."""
        api = UsdPhysics.MassAPI
        return self._warp(bodies.read(self._chosen(indices), api, api.GetDensityAttr, 0.0))

    def set_densities(self, densities: Values, *, indices: Indices = None) -> None:
        self._write(UsdPhysics.MassAPI, "Density", densities, indices)

    def get_coms(self, *, indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return centers of mass (N, 3) and orientations of the principal axes (N, 4) in the bodies' frames.

        Raises:
            AssertionError: physics does not play.
        """
        positions, orientations = mass_properties.centers(self._simulated(indices))
        return self._warp(positions), self._warp(orientations)

    def set_coms(
        self, positions: Values | None = None, orientations: Values | None = None, *, indices: Indices = None
    ) -> None:
        """Set centers of mass (N, 3) and principal axes (N, 4) in the bodies' frames; what is not given stays.

        The moments of inertia stay too.

        Raises:
            AssertionError: neither is given, or physics does not play.
        """
        if positions is None and orientations is None:
            raise AssertionError("give positions or orientations")
        prims = self._simulated(indices)
        mass_properties.set_centers(prims, *pose_rows(positions, orientations, len(prims)))

    def get_inertias(self, *, indices: Indices = None, inverse: bool = False) -> wp.array:
        """Return inertias (N, 9) about the centers of mass along the bodies' axes, in the stage's mass · length².

        Raises:
            AssertionError: physics does not play.
        """
        return self._warp(mass_properties.inertias(self._simulated(indices), inverse=inverse))

    def set_inertias(self, inertias: Values, *, indices: Indices = None) -> None:
        """Set inertias (N, 9) about the centers of mass along the bodies' axes.

        Raises:
            AssertionError: physics does not play.
        """
        prims = self._simulated(indices)
        mass_properties.set_inertias(prims, rows(inertias, 9, len(prims)))

    @property
    def num_shapes(self) -> int:
        """How many colliders the body has that has most; a collider of several convex parts counts once."""
        return mass_properties.num_shapes(self.prims)

    # --- switches ---
    def get_sleep_thresholds(self, *, indices: Indices = None) -> wp.array:
        """Return the energies per mass (N, 1) below which bodies may sleep."""
        api = physx.PhysxRigidBodyAPI
        return self._warp(bodies.read(self._chosen(indices), api, lambda each: each.GetSleepThresholdAttr(), 0.0))

    def set_sleep_thresholds(self, thresholds: Values, *, indices: Indices = None) -> None:
        self._write(physx.PhysxRigidBodyAPI, "SleepThreshold", thresholds, indices)

    def get_enabled_rigid_bodies(self, *, indices: Indices = None) -> wp.array:
        """Return which bodies are simulated (N, 1)."""
        api = UsdPhysics.RigidBodyAPI
        return self._warp(bodies.read(self._chosen(indices), api, api.GetRigidBodyEnabledAttr, False))

    def set_enabled_rigid_bodies(self, enabled: Values, *, indices: Indices = None) -> None:
        """Turn bodies on or off; one that is off is static."""
        prims = self._chosen(indices)
        switches = [bool(each) for each in column(enabled, len(prims))]
        bodies.write(prims, UsdPhysics.RigidBodyAPI, "RigidBodyEnabled", switches)

    def get_enabled_gravities(self, *, indices: Indices = None) -> wp.array:
        """Return which bodies gravity pulls (N, 1)."""
        api = physx.PhysxRigidBodyAPI
        off = bodies.read(self._chosen(indices), api, lambda each: each.GetDisableGravityAttr(), False)
        return self._warp(~off)

    def set_enabled_gravities(self, enabled: Values, *, indices: Indices = None) -> None:
        """Turn gravity on or off."""
        prims = self._chosen(indices)
        switches = [not each for each in column(enabled, len(prims))]
        bodies.write(prims, physx.PhysxRigidBodyAPI, "DisableGravity", switches)

    # --- default state ---
    def set_default_state(
        self,
        positions: Values | None = None,
        orientations: Values | None = None,
        linear_velocities: Values | None = None,
        angular_velocities: Values | None = None,
        *,
        indices: Indices = None,
    ) -> None:
        """Remember poses and velocities for `reset_to_default_state`; velocities that are never set are 0."""
        if positions is not None or orientations is not None:
            super().set_default_state(positions, orientations, indices=indices)
        self._set_default("linear_velocities", linear_velocities, (0.0, 0.0, 0.0), indices)
        self._set_default("angular_velocities", angular_velocities, (0.0, 0.0, 0.0), indices)

    def get_default_state(self, *, indices: Indices = None) -> tuple[wp.array | None, ...]:
        """Return default positions, orientations, linear and angular velocities; None where none have been set."""
        velocities = (self._default(name, indices) for name in ("linear_velocities", "angular_velocities"))
        return (*super().get_default_state(indices=indices), *velocities)

    def reset_to_default_state(self, *, warn_on_non_default_state: bool = False) -> None:
        """Set poses and velocities as `set_default_state` says."""
        linear, angular = self._defaults.get("linear_velocities"), self._defaults.get("angular_velocities")
        if linear is not None or angular is not None:
            self.set_velocities(linear, angular)
        if (linear is None and angular is None) or self._defaults.keys() & {"positions", "orientations"}:
            super().reset_to_default_state(warn_on_non_default_state=warn_on_non_default_state)

    def _needs_ops(self) -> bool:
        return not bodies.is_simulating() and super()._needs_ops()

    def _write(self, api: type, attribute: str, values: Values, indices: Indices) -> None:
        prims = self._chosen(indices)
        bodies.write(prims, api, attribute, column(values, len(prims)))
