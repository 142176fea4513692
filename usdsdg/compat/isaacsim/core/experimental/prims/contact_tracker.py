"""`ContactTracker`: contact forces on prims."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd

from usdsdg.compat.isaacsim.core.experimental.prims.xform_prim import XformPrim
from usdsdg.compat.physics_schema_tools import intToSdfPath
from usdsdg.compat.wrappers import bodies, contacts
from usdsdg.compat.wrappers.arrays import as_numpy, chosen, column

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values


class ContactTracker(XformPrim):
    """Prims whose contacts are tracked after `_track_contacts`.

    Contact forces are on the prims, in the world's axes: impulses of the latest step [stage's unit of mass · length /
    s] for dt=1, forces where dt is the length of the step. Those along the normals are contact forces, those across
    them friction.
    """

    _filters: Sequence[str] = ()
    _max_contact_count = 0
    _sensors: contacts.ContactSensors | None = None

    def _track_contacts(self, filters: str | Sequence[str], max_count: int) -> None:
        """Let the prims report contacts if there are filters or a number of points."""
        self._filters, self._max_contact_count = [filters] if isinstance(filters, str) else list(filters), max_count
        if self._filters or max_count:
            contacts.report_contacts(self.prims)

    @property
    def num_contact_filters(self) -> int:
        """How many filters each prim has.

        Raises:
            AssertionError: physics does not play, or contacts are not tracked.
        """
        return self._contact_sensors().num_partners

    def set_enabled_contact_tracking(self, enabled: Values, *, indices: Indices = None, threshold: float = 0.0) -> None:
        """Let prims report contacts that push with at least `threshold` [stage units of force], or no more."""
        prims = self._chosen(indices)
        for prim, wanted in zip(prims, column(enabled, len(prims)), strict=True):
            contacts.report_contacts([prim], threshold) if wanted else contacts.stop_reporting([prim])

    def get_enabled_contact_tracking(self, *, indices: Indices = None) -> wp.array:
        """Return which prims report contacts (N, 1)."""
        return self._warp(contacts.reporting(self._chosen(indices)))

    def get_net_contact_forces(self, *, indices: Indices = None, dt: float = 1.0) -> wp.array:
        """Return the contact forces (N, 3) with anything.

        Raises:
            AssertionError: physics does not play, or contacts are not tracked.
        """
        return self._warp(self._contact_sensors().net_forces(dt)[chosen(indices, len(self))])

    def get_contact_force_matrix(self, *, indices: Indices = None, dt: float = 1.0) -> wp.array:
        """Return the contact forces (N, filters, 3) with each filter.

        Raises:
            AssertionError: physics does not play, or there are no filters.
        """
        return self._warp(self._contact_sensors(by_filter=True).force_matrix(dt)[chosen(indices, len(self))])

    def get_contact_force_data(self, *, indices: Indices = None, dt: float = 1.0) -> tuple[wp.array, ...]:
        """Return the contact points with filters, pair by pair.

        Returns:
            Forces along the normals (max, 1), points (max, 3) and normals toward the prims (max, 3) in the world,
            separations (max, 1), and how many points each pair has and from which row on (N, filters); `max` is
            `max_contact_count`.

        Raises:
            AssertionError: physics does not play, or there are no filters.
        """
        return self._warp_pairs(self._contact_sensors(by_filter=True).contacts(dt), indices)

    def get_friction_data(self, *, indices: Indices = None, dt: float = 1.0) -> tuple[wp.array, ...]:
        """Return the friction in the contact points with filters, pair by pair.

        Returns:
            Forces (max, 3) and points (max, 3), and how many each pair has and from which row on (N, filters).

        Raises:
            AssertionError: physics does not play, or there are no filters.
        """
        return self._warp_pairs(self._contact_sensors(by_filter=True).friction(dt), indices)

    def get_raw_contact_data(self, *, indices: Indices = None, dt: float = 1.0) -> tuple[wp.array, ...]:
        """Return the contact points with anything, prim by prim.

        Returns:
            What `get_contact_force_data` returns, with a count and a first row for each prim (N,), and numbers (max,)
            of the bodies or static colliders that are touched, for `get_actor_paths_from_ids`.

        Raises:
            AssertionError: physics does not play, or contacts are not tracked.
        """
        found, touched = self._contact_sensors().all_contacts(dt)
        return (*self._warp_pairs(found, indices), self._warp(touched))

    def get_actor_paths_from_ids(self, actor_ids: Values) -> list[str]:
        """Return the paths of numbers from `get_raw_contact_data`; "" for 0.

        Raises:
            BadValue: a number is not from there.
        """
        return [str(intToSdfPath(int(each))) for each in as_numpy(actor_ids).reshape(-1)]

    def _simulated(self, indices: Indices) -> list[Usd.Prim]:
        """Return the prims of some rows.

        Raises:
            AssertionError: physics does not play, or a prim has been removed from the stage.
        """
        if not bodies.is_simulating():
            raise AssertionError("physics does not play; play the timeline first")
        return self._chosen(indices)

    def _contact_sensors(self, *, by_filter: bool = False) -> contacts.ContactSensors:
        """Return what reads the contacts.

        Raises:
            AssertionError: physics does not play, contacts are not tracked, or `by_filter` and there are no filters.
        """
        if not (self._filters or self._max_contact_count):
            raise AssertionError("contacts are not tracked; give RigidPrim contact_filter_paths or max_contact_count")
        if by_filter and not self._filters:
            raise AssertionError("there are no contact filters; give RigidPrim contact_filter_paths")
        self._simulated(None)
        if self._sensors is None:
            each = len(self._filters) == len(self)
            filters = [[path] for path in self._filters] if each else [self._filters] * len(self)
            partners = contacts.partners_of([[path] for path in self.paths], filters)
            self._sensors = contacts.ContactSensors(self.paths, partners, self._max_contact_count)
        return self._sensors

    def _warp_pairs(self, found: tuple[np.ndarray, ...], indices: Indices) -> tuple[wp.array, ...]:
        """Return arrays of which the last two have a row per prim, with some of these rows."""
        *points, count, start = found
        where = chosen(indices, len(self))
        return tuple(self._warp(each) for each in (*points, count[where], start[where]))
