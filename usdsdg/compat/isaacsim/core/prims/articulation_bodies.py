"""`ArticulationBodies`: links of several robots, Jacobians and mass matrices, which `Articulation` has."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd

from usdsdg.compat.isaacsim.core.prims.articulation_drives import ArticulationDrives
from usdsdg.compat.isaacsim.core.prims.articulation_joints import _index
from usdsdg.compat.wrappers import bodies, mass_properties
from usdsdg.compat.wrappers.arrays import chosen, grid, pose_rows, rows
from usdsdg.compat.wrappers.links import LinkRows
from usdsdg.errors import warn_once

if TYPE_CHECKING:
    from usdsdg.compat.isaacsim.core.prims.articulation_joints import Names
    from usdsdg.compat.wrappers.arrays import Indices, Values


class ArticulationBodies(ArticulationDrives):
    """Links by `body_indices`: the base first, then breadth first. What only a simulation knows is None before it."""

    @property
    def body_names(self) -> list[str]:
        """Return the names of the links, the base first."""
        return self._links.names

    @property
    def num_bodies(self) -> int:
        return len(self.body_names)

    @property
    def num_shapes(self) -> int:
        """How many colliders the first robot has."""
        return sum(mass_properties.num_shapes([prim]) for prim in self._links.prims([0], range(self.num_bodies)))

    def get_articulation_body_count(self) -> int:
        return self.num_bodies

    def get_body_index(self, body_name: str) -> int:
        """Return the place of a link.

        Raises:
            KeyError: there is no such link.
        """
        return _index(self.body_names, body_name, "link")

    get_link_index = get_body_index

    # --- masses ---
    def get_body_masses(self, indices: Indices = None, body_indices: Indices = None, clone: bool = True) -> np.ndarray:
        """Return (N, L)."""
        prims, shape = self._bodies(indices, body_indices)
        return self._out(bodies.masses(prims).reshape(shape))[0]

    def get_body_inv_masses(
        self, indices: Indices = None, body_indices: Indices = None, clone: bool = True
    ) -> np.ndarray:
        """Return 1 / mass (N, L)."""
        prims, shape = self._bodies(indices, body_indices)
        return self._out(1.0 / bodies.masses(prims).reshape(shape))[0]

    def set_body_masses(self, values: Values, indices: Indices = None, body_indices: Indices = None) -> None:
        """Set (N, L)."""
        prims, shape = self._bodies(indices, body_indices)
        masses = grid(values, shape).reshape(-1).tolist()
        bodies.set_masses(prims, masses)

    def get_body_coms(
        self, indices: Indices = None, body_indices: Indices = None, clone: bool = True
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """Return centers of mass (N, L, 3) and orientations (N, L, 4) of the principal axes in the links' frames."""
        if not self._is_simulated("get_body_coms"):
            return None
        prims, shape = self._bodies(indices, body_indices)
        positions, turns = mass_properties.centers(prims)
        positions, turns = self._out(positions.reshape(*shape, 3), turns.reshape(*shape, 4))
        return positions, turns

    def set_body_coms(
        self,
        positions: Values | None = None,
        orientations: Values | None = None,
        indices: Indices = None,
        body_indices: Indices = None,
    ) -> None:
        """Set centers of mass (N, L, 3) and principal axes (N, L, 4); what is not given stays."""
        if self._is_simulated("set_body_coms"):
            prims, _ = self._bodies(indices, body_indices)
            mass_properties.set_centers(prims, *pose_rows(positions, orientations, len(prims)))

    def get_body_inertias(
        self, indices: Indices = None, body_indices: Indices = None, clone: bool = True
    ) -> np.ndarray | None:
        """Return inertias (N, L, 9) about the centers of mass along the links' axes."""
        return self._inertias("get_body_inertias", indices, body_indices, inverse=False)

    def get_body_inv_inertias(
        self, indices: Indices = None, body_indices: Indices = None, clone: bool = True
    ) -> np.ndarray | None:
        """Return the inverses (N, L, 9) of the inertias."""
        return self._inertias("get_body_inv_inertias", indices, body_indices, inverse=True)

    def set_body_inertias(self, values: Values, indices: Indices = None, body_indices: Indices = None) -> None:
        """Set inertias (N, L, 9) about the centers of mass along the links' axes."""
        prims, _ = self._bodies(indices, body_indices)
        mass_properties.set_inertias(prims, rows(values, 9, len(prims)))

    def get_body_disable_gravity(
        self, indices: Indices = None, body_indices: Indices = None, clone: bool = True
    ) -> np.ndarray:
        """Return which links gravity does not pull (N, L)."""
        where, which = chosen(indices, self.count), chosen(body_indices, self.num_bodies)
        return self._out(self._links.disabled_gravities(where, which))[0]

    def set_body_disable_gravity(self, values: Values, indices: Indices = None, body_indices: Indices = None) -> None:
        """Switch gravity off where the values (N, L) are true, and on where not."""
        where, which = chosen(indices, self.count), chosen(body_indices, self.num_bodies)
        self._links.disable_gravities(where, which, grid(values, (len(where), len(which))))

    # --- how links move with joints ---
    def get_jacobian_shape(self) -> tuple[int, int, int]:
        """Return (L - 1, 6, D) of a robot whose base is fixed, (L, 6, D + 6) of others."""
        return self._links.jacobian_shape

    def get_jacobians(self, indices: Indices = None, clone: bool = True) -> np.ndarray | None:
        """Return (N, *get_jacobian_shape()): from joint velocities to velocities of links in the world.

        Rows of a link are the velocity of its center of mass, as PhysX has it, and its angular velocity. The base has
        no rows where it is fixed, and else the first 6 columns: its own velocities. None before physics plays.
        """
        if not self._is_simulated("get_jacobians"):
            return None
        return self._out(self._links.jacobians(chosen(indices, self.count)))[0]

    def get_mass_matrix_shape(self) -> tuple[int, int]:
        """Return (D, D) of a robot whose base is fixed, (D + 6, D + 6) of others."""
        count = self._links.jacobian_shape[2]
        return count, count

    def get_mass_matrices(self, indices: Indices = None, clone: bool = True) -> np.ndarray | None:
        """Return (N, *get_mass_matrix_shape()); coordinates are the columns of Jacobians."""
        if not self._is_simulated("get_mass_matrices"):
            return None
        return self._out(self._links.mass_matrices(chosen(indices, self.count)))[0]

    def get_coriolis_and_centrifugal_forces(
        self, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None, clone: bool = True
    ) -> np.ndarray | None:
        """Return the efforts (N, D) that make up for Coriolis and centrifugal forces."""
        if not self._is_simulated("get_coriolis_and_centrifugal_forces"):
            return None
        forces = self._links.coriolis_forces(range(self.count))
        return self._part(forces, indices, joint_indices, joint_names)

    def get_generalized_gravity_forces(
        self, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None, clone: bool = True
    ) -> np.ndarray | None:
        """Return the efforts (N, D) that hold joints against gravity."""
        if not self._is_simulated("get_generalized_gravity_forces"):
            return None
        return self._part(self._links.gravity_forces(range(self.count)), indices, joint_indices, joint_names)

    @cached_property
    def _links(self) -> LinkRows:
        return LinkRows(self._joints)

    def _bodies(self, indices: Indices, columns: Indices) -> tuple[list[Usd.Prim], tuple[int, int]]:
        """Return the prims of links, row by row, and how many rows and columns they are."""
        where, which = chosen(indices, self.count), chosen(columns, self.num_bodies)
        return self._links.prims(where, which), (len(where), len(which))

    def _inertias(self, caller: str, indices: Indices, columns: Indices, *, inverse: bool) -> np.ndarray | None:
        if not self._is_simulated(caller):
            return None
        prims, shape = self._bodies(indices, columns)
        return self._out(mass_properties.inertias(prims, inverse=inverse).reshape(*shape, 9))[0]

    def _is_simulated(self, caller: str) -> bool:
        """Whether physics simulates; warn where it does not."""
        if not bodies.is_simulating():
            warn_once(f"{self.name}: physics does not play, so {caller} does nothing")
        return bodies.is_simulating()
