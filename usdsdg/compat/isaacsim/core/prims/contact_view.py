"""`RigidContactView`: contact forces on prims, and the same getters for wrappers that track contacts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.compat.wrappers import bodies, contacts, prim_paths
from usdsdg.compat.wrappers.arrays import as_backend, chosen
from usdsdg.errors import BadPrim, warn_once

if TYPE_CHECKING:
    from usdsdg.compat.wrappers.arrays import Indices

    Arrays = tuple[np.ndarray, ...]


class RigidContactView:
    """Contacts of rigid bodies or colliders in the latest physics step.

    Forces are on the prims, in the world's axes: impulses of the step [stage's unit of mass · length / s] for dt=1,
    forces where dt is the length of the step. Those along the normals are contact forces, those across them friction.
    """

    def __init__(
        self,
        prim_paths_expr: str | Sequence[str],
        filter_paths_expr: Sequence[str] | Sequence[Sequence[str]],
        name: str = "rigid_contact_view",
        prepare_contact_sensors: bool = True,
        disable_stablization: bool = True,
        disable_stabilization: bool | None = None,
        max_contact_count: int = 0,
    ) -> None:
        """Wrap the prims at these paths, in which "*" or ".*" stands for any part of a name.

        Args:
            filter_paths_expr: Prims whose contacts are reported one by one; a list for each of `prim_paths_expr`, or
                one for all. A pattern matches one prim, or one for each prim of the view.
            prepare_contact_sensors: Let all of these prims report their contacts, however small.
            disable_stablization: Without effect, as `disable_stabilization`: forces are those that the solver applied.
            max_contact_count: How many contact points `get_contact_force_data` and `get_friction_data` return at most.

        Raises:
            BadPrim: there are no such prims.
        """
        given = [prim_paths_expr] if isinstance(prim_paths_expr, str) else list(prim_paths_expr)
        self._name, self.max_contact_count = name, max_contact_count
        self._groups = [prim_paths.matching_paths(prim_paths.from_wildcards(each)) for each in given]
        if not any(self._groups):
            raise BadPrim(f"{name}: no prim matches {', '.join(given)}")
        self._filters = _by_group(filter_paths_expr, len(given))
        self._sensors: contacts.ContactSensors | None = None
        if prepare_contact_sensors:
            filters = [path for group in self._filters for each in group for path in prim_paths.matching_paths(each)]
            paths = [path for group in self._groups for path in group] + filters
            contacts.report_contacts(prim_paths.prim_of(path) for path in dict.fromkeys(paths))

    @property
    def num_shapes(self) -> int:
        """How many prims the view has."""
        return sum(map(len, self._groups))

    @property
    def num_filters(self) -> int:
        """How many filters each prim has."""
        return len(self._filters[0])

    def initialize(self, physics_sim_view: object = None) -> None:
        """Do nothing: there are no tensor views to make; contacts are read from the simulation."""

    def is_physics_handle_valid(self) -> bool:
        """Whether physics simulates."""
        return bodies.is_simulating()

    def get_net_contact_forces(self, indices: Indices = None, clone: bool = True, dt: float = 1.0) -> np.ndarray | None:
        """Return the contact forces (M, 3) with anything; None, with a warning, where physics does not play."""
        sensors = self._simulated("get_net_contact_forces")
        return None if sensors is None else self._out(sensors.net_forces(dt)[self._rows(indices)])[0]

    def get_contact_force_matrix(
        self, indices: Indices = None, clone: bool = True, dt: float = 1.0
    ) -> np.ndarray | None:
        """Return the contact forces (M, num_filters, 3) with each filter; None where physics does not play."""
        sensors = self._simulated("get_contact_force_matrix")
        return None if sensors is None else self._out(sensors.force_matrix(dt)[self._rows(indices)])[0]

    def get_contact_force_data(self, indices: Indices = None, clone: bool = True, dt: float = 1.0) -> Arrays | None:
        """Return the contact points with filters, pair by pair; None where physics does not play.

        Returns:
            Forces along the normals (max, 1), points (max, 3) and normals toward the prims (max, 3) in the world,
            separations (max, 1), and how many points each pair has and from which row on (M, num_filters); `max` is
            `max_contact_count`.
        """
        sensors = self._simulated("get_contact_force_data")
        if sensors is None:
            return None
        *points, count, start = sensors.contacts(dt)
        rows = self._rows(indices)
        return self._out(*points, count[rows], start[rows])

    def get_friction_data(self, indices: Indices = None, clone: bool = True, dt: float = 1.0) -> Arrays | None:
        """Return the friction in the contact points with filters, pair by pair; None where physics does not play.

        Returns:
            Forces (max, 3) and points (max, 3), and how many each pair has and from which row on (M, num_filters).
        """
        sensors = self._simulated("get_friction_data")
        if sensors is None:
            return None
        force, position, count, start = sensors.friction(dt)
        rows = self._rows(indices)
        return self._out(force, position, count[rows], start[rows])

    def _simulated(self, caller: str) -> contacts.ContactSensors | None:
        """Return the sensors; None, with a warning, where physics does not play."""
        if not bodies.is_simulating():
            warn_once(f"{self._name}: physics does not play, so {caller} returns None")
            return None
        if self._sensors is None:
            paths = [path for group in self._groups for path in group]
            partners = contacts.partners_of(self._groups, self._filters)
            self._sensors = contacts.ContactSensors(paths, partners, self.max_contact_count)
        return self._sensors

    def _rows(self, indices: Indices) -> list[int]:
        return chosen(indices, self.num_shapes)

    def _out(self, *arrays: np.ndarray) -> Arrays:
        state = simulation()
        return tuple(as_backend(array, state.backend, state.device) for array in arrays)


class ContactTracker:
    """The getters of contacts of a wrapper that may track them, by `_track_contacts`."""

    _contact_view: RigidContactView | None = None

    def _track_contacts(
        self,
        prim_paths_expr: str | Sequence[str],
        name: str,
        filters: Sequence[str] | None,
        *,
        track: bool,
        prepare: bool,
        max_count: int,
    ) -> None:
        """Make the view of the contacts if they are tracked: all, or those with filters."""
        if track or filters:
            self._contact_view = RigidContactView(
                prim_paths_expr, filters or [], f"{name}_contact", prepare, max_contact_count=max_count
            )

    def get_net_contact_forces(self, indices: Indices = None, clone: bool = True, dt: float = 1.0) -> np.ndarray | None:
        """Return the contact forces (M, 3) with anything: impulses for dt=1; see `RigidContactView`.

        None, with a warning, where physics does not play or the wrapper was made without track_contact_forces.
        """
        view = self._tracked("get_net_contact_forces")
        return None if view is None else view.get_net_contact_forces(indices, clone, dt)

    def get_contact_force_matrix(
        self, indices: Indices = None, clone: bool = True, dt: float = 1.0
    ) -> np.ndarray | None:
        """Return the contact forces (M, filters, 3) with each filter: impulses for dt=1; see `RigidContactView`.

        None, with a warning, where physics does not play or there is no contact_filter_prim_paths_expr.
        """
        view = self._tracked("get_contact_force_matrix", by_filter=True)
        return None if view is None else view.get_contact_force_matrix(indices, clone, dt)

    def get_contact_force_data(self, indices: Indices = None, clone: bool = True, dt: float = 1.0) -> Arrays | None:
        """Return the contact points with filters; see `RigidContactView.get_contact_force_data`.

        None, with a warning, where physics does not play or there is no contact_filter_prim_paths_expr.
        """
        view = self._tracked("get_contact_force_data", by_filter=True)
        return None if view is None else view.get_contact_force_data(indices, clone, dt)

    def get_friction_data(self, indices: Indices = None, clone: bool = True, dt: float = 1.0) -> Arrays | None:
        """Return the friction in contacts with filters; see `RigidContactView.get_friction_data`.

        None, with a warning, where physics does not play or there is no contact_filter_prim_paths_expr.
        """
        view = self._tracked("get_friction_data", by_filter=True)
        return None if view is None else view.get_friction_data(indices, clone, dt)

    def _tracked(self, caller: str, *, by_filter: bool = False) -> RigidContactView | None:
        view = self._contact_view
        if view is None or (by_filter and not view.num_filters):
            argument = "contact_filter_prim_paths_expr" if by_filter else "track_contact_forces=True"
            warn_once(f"{type(self).__name__}.{caller} returns None: make the wrapper with {argument}")
            return None
        return view


def _by_group(filters: Sequence[str] | Sequence[Sequence[str]], groups: int) -> list[list[str]]:
    """Return the patterns of filters of each group of prims."""
    lists = [list(each) for each in filters if not isinstance(each, str)]
    each_of_all = lists or [[each for each in filters if isinstance(each, str)]]
    patterns = [[prim_paths.from_wildcards(each) for each in group] for group in each_of_all]
    return patterns * groups if len(patterns) == 1 else patterns
