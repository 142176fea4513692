"""Give contacts to shapes with the friction and restitution that their two materials have together."""

# Warp structs are no classes to a type checker.
# pyright: reportGeneralTypeIssues=false, reportOptionalMemberAccess=false

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.scene.contact_coefficients import CoefficientTable

if TYPE_CHECKING:
    import newton
    import warp as wp

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


class ContactCoefficients:
    """Replaces the shapes of contacts by stand-ins; see `usdsdg_physics.scene.contact_coefficients`."""

    def __init__(
        self,
        table: CoefficientTable,
        model: newton.Model,
        contacts: ContactArrays,
        *,
        body_index: Mapping[str, int],
        shape_index: Mapping[str, int],
        stand_in_index: np.ndarray,
    ) -> None:
        """`stand_in_index` has the shape of each stand-in in the model."""
        import newton
        import warp as wp

        self._model, self._contacts = model, contacts
        dynamic = (model.body_flags.numpy() & int(newton.BodyFlags.KINEMATIC)) == 0
        self._dynamic = wp.array(dynamic, dtype=wp.int32, device=model.device)
        material = np.full(model.shape_count, -1, np.int32)
        for path, row in table.material.items():
            material[shape_index[path]] = row
        stand_in = np.full((model.body_count + 1, max(table.value.max() + 1, 1)), -1, np.int32)
        for (body, value), row in table.stand_in.items():
            stand_in[body_index.get(body, -1) + 1, value] = stand_in_index[row]
        self._material, self._value, self._stand_in = (
            wp.array(numbers, dtype=wp.int32, device=model.device) for numbers in (material, table.value, stand_in)
        )
        self._static_friction = wp.array(table.static_friction, dtype=wp.float32, device=model.device)

    def apply(self, state: newton.State, surface_velocity: wp.array | None, dt: float) -> None:
        """Replace the shapes of the contacts, after every correction that looks at them.

        Args:
            dt: length of the solver's next step [s].
            surface_velocity: (C,) of the contacts [m/s], None where no surface moves.
        """
        import warp as wp

        from usdsdg_physics.corrections.friction.contact_coefficients_kernels import replace_shapes

        wp.launch(
            replace_shapes,
            dim=self._contacts.shape0.size,
            inputs=[
                self._model.shape_body,
                self._material,
                self._value,
                self._stand_in,
                self._static_friction,
                self._model.gravity,
                dt,
                self._dynamic,
                self._model.body_inv_mass,
                state.body_f,
                self._model.body_com,
                state.body_q,
                state.body_qd,
                surface_velocity,
            ],
            outputs=[self._contacts],
            device=self._model.device,
        )
