"""Have Newton's solver visit the contacts and rows that there are, in place of all that there is room for."""

# The solver keeps its capacities in private attributes.
# pyright: reportArgumentType=false, reportOptionalMemberAccess=false

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import newton

ROWS_PER_CONTACT = 3
ROWS_PER_LIMITED_BODY = 6  # along and about each axis
MIN_VISITED = 64


class VisitedContacts:
    """How many contacts the kernels of a substep visit: about as many as were found, so that the bits stay the same.

    Newton launches a thread for each contact and each row that its buffers hold, which is ten times as many as a scene
    has while its bodies fly; those that find nothing took a third of a step. The count halves the capacity some times,
    since each count is another record of a substep's launches.
    """

    def __init__(self, solver: Any, contacts: newton.Contacts, *, extra: int) -> None:
        """`extra` contacts may come to those that the collision pipeline finds."""
        self._solver, self._contacts, self._extra = solver, contacts, extra
        self._capacity: int = contacts.rigid_contact_max
        self._rows: int = solver._free_body_constraint_max
        self._patches: Any = solver._friction_patches
        self._patch_capacity: int = self._patches.capacity
        limits = [solver._rigid_body_max_linear_velocity, solver._rigid_body_max_angular_velocity]
        limited = np.any([np.isfinite(limit.numpy()) for limit in limits if limit is not None], axis=0)
        self._other_rows = ROWS_PER_LIMITED_BODY * int(np.sum(limited))
        # A kernel that keeps contacts for the next substep keeps poses too, in the same threads.
        self._least = max(MIN_VISITED, solver.model.body_count)
        self._latest = 0

    @classmethod
    def of(cls, solver: Any, contacts: newton.Contacts, *, extra: int) -> VisitedContacts | None:
        """Return those of a solver; None where it or its device is another than the one that this knows."""
        names = (
            "_free_body_constraint_max",
            "_friction_patches",
            "_rigid_body_max_linear_velocity",
            "_rigid_body_max_angular_velocity",
            "_world_count",
        )
        if solver.model.device.is_cuda or not all(hasattr(solver, name) for name in names):
            return None
        if solver._world_count != 1 or not hasattr(solver._friction_patches, "capacity"):
            return None
        return cls(solver, contacts, extra=extra)

    def choose(self) -> int:
        """Return how many contacts the substep has to visit whose contacts were just found.

        Those of the substep before are among them, whose friction is remembered in the places that they had.
        """
        found = min(int(self._contacts.rigid_contact_count.numpy()[0]) + self._extra, self._capacity)
        needed, self._latest = max(found, self._latest, self._least), found
        visited = self._capacity
        while visited // 2 >= needed:
            visited //= 2
        return visited

    @contextmanager
    def visiting(self, count: int) -> Iterator[None]:
        """Within it, the solver visits so many contacts and the rows that these may have."""
        self._contacts.rigid_contact_max = self._patches.capacity = count
        self._solver._free_body_constraint_max = min(self._rows, ROWS_PER_CONTACT * count + self._other_rows)
        try:
            yield
        finally:
            self._contacts.rigid_contact_max, self._patches.capacity = self._capacity, self._patch_capacity
            self._solver._free_body_constraint_max = self._rows
