"""The contacts of a step and the forces in them, kept on the device until the step has ended."""

# Warp structs are no classes to a type checker.
# pyright: reportGeneralTypeIssues=false

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import newton
    import warp as wp

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


@dataclass(frozen=True)
class ContactRows:
    """Contacts of one substep, a row each, in SI units and the world."""

    shapes: np.ndarray  # (C, 2) indices
    position: np.ndarray  # (C, 3)
    normal: np.ndarray  # (C, 3) from shape 0 to shape 1
    separation: np.ndarray  # (C,)
    impulse: np.ndarray  # (C, 3) on shape 0


class ContactReport:
    """Keeps the contacts of the shapes that are reported; what it launches may be recorded."""

    def __init__(self, model: newton.Model, contacts: ContactArrays, shapes: Collection[int]) -> None:
        """`shapes` are the indices of those whose contacts are kept."""
        import warp as wp

        self._model, self._contacts = model, contacts
        reported = np.zeros(model.shape_count, np.int32)
        reported[list(shapes)] = 1
        self._reported = wp.array(reported, dtype=wp.int32, device=model.device)
        self._substeps = 0
        self.reserve(1)

    def reserve(self, substeps: int) -> bool:
        """Make room for the contacts of so many substeps; return whether the arrays are new ones."""
        import warp as wp

        if substeps <= self._substeps:
            return False
        self._substeps = substeps
        size, device = (substeps, self._contacts.shape0.size), self._model.device
        self._shapes = wp.zeros(size, dtype=wp.vec2i, device=device)
        self._position, self._normal, self._impulse = (wp.zeros(size, dtype=wp.vec3, device=device) for _ in range(3))
        self._separation = wp.zeros(size, dtype=wp.float32, device=device)
        return True

    def note_contacts(self, state: newton.State, substep: int) -> None:
        """Note the contacts that the collision pipeline found, before their shapes are replaced."""
        import warp as wp

        from usdsdg_physics.corrections.contacts.contact_report_kernels import note_contacts

        wp.launch(
            note_contacts,
            dim=self._contacts.shape0.size,
            inputs=[self._model.shape_body, self._reported, state.body_q, self._contacts, substep],
            outputs=[self._shapes, self._position, self._normal, self._separation],
            device=self._model.device,
        )

    def note_forces(self, forces: wp.array, substep: int, dt: float) -> None:
        """Note the forces (C,) [N] in the contacts, after the solver's step of `dt` seconds."""
        import warp as wp

        from usdsdg_physics.corrections.contacts.contact_report_kernels import note_impulses

        wp.launch(
            note_impulses,
            dim=self._contacts.shape0.size,
            inputs=[forces, substep, dt],
            outputs=[self._impulse],
            device=self._model.device,
        )

    def rows(self, substeps: int) -> list[ContactRows]:
        """Return the contacts of the latest step, by substep."""
        shapes, position, normal = (each.numpy() for each in (self._shapes, self._position, self._normal))
        separation, impulse = self._separation.numpy(), self._impulse.numpy()
        kept = [np.flatnonzero(shapes[substep, :, 0] >= 0) for substep in range(substeps)]
        return [
            ContactRows(shapes[i, k], position[i, k], normal[i, k], separation[i, k], impulse[i, k])
            for i, k in enumerate(kept)
        ]
