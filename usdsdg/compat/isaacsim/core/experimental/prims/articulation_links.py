"""`ArticulationLinks`: links of robots, Jacobians and mass matrices, which `Articulation` has."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from pxr import Usd

from usdsdg.compat.isaacsim.core.experimental.prims.articulation_drives import ArticulationDrives
from usdsdg.compat.wrappers import bodies, mass_properties
from usdsdg.compat.wrappers.arrays import chosen, grid, pose_rows, rows
from usdsdg.compat.wrappers.links import LinkRows

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values


class ArticulationLinks(ArticulationDrives):
    """Links: the base first, then breadth first. What only a simulation knows asserts that physics plays."""

    @property
    def link_names(self) -> list[str]:
        """Return the names of the links, the base first."""
        return self._links.names

    @property
    def link_paths(self) -> list[list[str]]:
        """Return the paths of the links, of each robot."""
        return [tree.links for tree in self._links.trees]

    @property
    def num_links(self) -> int:
        return len(self.link_names)

    @property
    def num_shapes(self) -> int:
        """How many colliders the first robot has."""
        return sum(mass_properties.num_shapes([prim]) for prim in self._links.prims([0], range(self.num_links)))

    def get_link_indices(self, names: str | Sequence[str]) -> wp.array:
        """Return the places of links by name.

        Raises:
            AssertionError: there is no such link.
        """
        return self._places(self.link_names, names, "link")

    def get_link_incoming_joint_force(
        self, *, indices: Indices = None, link_indices: Indices = None
    ) -> tuple[wp.array, wp.array]:
        """Return forces (N, L, 3) and torques (N, L, 3) of the joints that hold links, of the latest step.

        It is what body 0 of a joint exerts on body 1, along the joint's frame at body 1, what drives do included. The
        base has zeros, as in PhysX.

        Raises:
            PhysicsError: physics does not play.
        """
        where, which = chosen(indices, len(self)), chosen(link_indices, self.num_links)
        found = self._joints.forces()[where][:, which]
        return self._warp(found[..., :3]), self._warp(found[..., 3:])

    # --- masses ---
    def get_link_masses(
        self, *, indices: Indices = None, link_indices: Indices = None, inverse: bool = False
    ) -> wp.array:
        """Return (N, L), or 1 / mass with `inverse`."""
        prims, shape = self._bodies(indices, link_indices)
        masses = bodies.masses(prims).reshape(shape)
        return self._warp(1.0 / masses if inverse else masses)

    def set_link_masses(self, masses: Values, *, indices: Indices = None, link_indices: Indices = None) -> None:
        """Set (N, L)."""
        prims, shape = self._bodies(indices, link_indices)
        numbers = grid(masses, shape).reshape(-1).tolist()
        bodies.set_masses(prims, numbers)

    def get_link_coms(self, *, indices: Indices = None, link_indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return centers of mass (N, L, 3) and orientations (N, L, 4) of the principal axes in the links' frames."""
        prims, shape = self._simulated(indices, link_indices)
        positions, turns = mass_properties.centers(prims)
        return self._warp(positions.reshape(*shape, 3)), self._warp(turns.reshape(*shape, 4))

    def set_link_coms(
        self,
        positions: Values | None = None,
        orientations: Values | None = None,
        *,
        indices: Indices = None,
        link_indices: Indices = None,
    ) -> None:
        """Set centers of mass (N, L, 3) and principal axes (N, L, 4); what is not given stays.

        Raises:
            AssertionError: neither is given.
        """
        if positions is None and orientations is None:
            raise AssertionError("give positions or orientations")
        prims, _ = self._simulated(indices, link_indices)
        mass_properties.set_centers(prims, *pose_rows(positions, orientations, len(prims)))

    def get_link_inertias(
        self, *, indices: Indices = None, link_indices: Indices = None, inverse: bool = False
    ) -> wp.array:
        """Return inertias (N, L, 9) about the centers of mass along the links' axes, or their inverses."""
        prims, shape = self._simulated(indices, link_indices)
        return self._warp(mass_properties.inertias(prims, inverse=inverse).reshape(*shape, 9))

    def set_link_inertias(self, inertias: Values, *, indices: Indices = None, link_indices: Indices = None) -> None:
        """Set inertias (N, L, 9) about the centers of mass along the links' axes."""
        prims, _ = self._simulated(indices, link_indices)
        mass_properties.set_inertias(prims, rows(inertias, 9, len(prims)))

    def get_link_enabled_gravities(self, *, indices: Indices = None, link_indices: Indices = None) -> wp.array:
        """Return which links gravity pulls (N, L)."""
        where, which = chosen(indices, len(self)), chosen(link_indices, self.num_links)
        return self._warp(~self._links.disabled_gravities(where, which))

    def set_link_enabled_gravities(
        self, enabled: Values, *, indices: Indices = None, link_indices: Indices = None
    ) -> None:
        """Switch gravity on or off for links (N, L)."""
        where, which = chosen(indices, len(self)), chosen(link_indices, self.num_links)
        self._links.disable_gravities(where, which, ~grid(enabled, (len(where), len(which))).astype(bool))

    # --- how links move with joints ---
    @property
    def jacobian_matrix_shape(self) -> tuple[int, int, int]:
        """Return (L - 1, 6, D) of a robot whose base is fixed, (L, 6, D + 6) of others."""
        return self._links.jacobian_shape

    @property
    def mass_matrix_shape(self) -> tuple[int, int]:
        """Return (D, D) of a robot whose base is fixed, (D + 6, D + 6) of others."""
        count = self._links.jacobian_shape[2]
        return count, count

    def get_jacobian_matrices(self, *, indices: Indices = None) -> wp.array:
        """Return (N, *jacobian_matrix_shape): from joint velocities to velocities of links in the world.

        Rows of a link are the velocity of its center of mass, as PhysX has it, and its angular velocity. The base has
        no rows where it is fixed, and else the first 6 columns: its own velocities.
        """
        return self._warp(self._links.jacobians(self._playing(indices)))

    def get_mass_matrices(self, *, indices: Indices = None) -> wp.array:
        """Return (N, *mass_matrix_shape); coordinates are the columns of Jacobians."""
        return self._warp(self._links.mass_matrices(self._playing(indices)))

    def get_dof_coriolis_and_centrifugal_compensation_forces(
        self, *, indices: Indices = None, dof_indices: Indices = None
    ) -> wp.array:
        """Return the efforts (N, D) that make up for Coriolis and centrifugal forces."""
        self._playing(None)
        return self._part(self._links.coriolis_forces(range(len(self))), indices, dof_indices)

    def get_dof_gravity_compensation_forces(self, *, indices: Indices = None, dof_indices: Indices = None) -> wp.array:
        """Return the efforts (N, D) that hold joints against gravity."""
        self._playing(None)
        return self._part(self._links.gravity_forces(range(len(self))), indices, dof_indices)

    @cached_property
    def _links(self) -> LinkRows:
        return LinkRows(self._joints)

    def _playing(self, indices: Indices) -> list[int]:
        """Return rows.

        Raises:
            AssertionError: physics does not play.
        """
        if not bodies.is_simulating():
            raise AssertionError(f"{self.paths[0]}: only a simulation knows this; play first")
        return chosen(indices, len(self))

    def _bodies(self, indices: Indices, links: Indices) -> tuple[list[Usd.Prim], tuple[int, int]]:
        """Return the prims of links, row by row, and how many rows and columns they are."""
        where, which = chosen(indices, len(self)), chosen(links, self.num_links)
        return self._links.prims(where, which), (len(where), len(which))

    def _simulated(self, indices: Indices, links: Indices) -> tuple[list[Usd.Prim], tuple[int, int]]:  # pyright: ignore[reportIncompatibleMethodOverride]
        self._playing(indices)
        return self._bodies(indices, links)
