"""Take from bodies that fall on something fixed, without restitution, the spin that the impact would give them."""

# Warp structs are no classes to a type checker.
# pyright: reportGeneralTypeIssues=false

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import newton
    import warp as wp

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


class Impacts:
    """Lets restitution 0 mean what things do that are dropped: they lie down.

    An ideal rigid cube that falls on a corner keeps up to three quarters of its energy as spin, hits with the next
    corner, and hops on for half a meter from a fall of three. Soft things lose it at once, and so do the bodies of
    PhysX, which sink in during the step of an impact until all their corners touch.
    """

    def __init__(self, model: newton.Model, free: wp.array, contacts: ContactArrays) -> None:
        """`free` (N,) marks the bodies that move, and that no joint holds."""
        self._model, self._free, self._contacts = model, free, contacts

    def center_contacts(self, state: newton.State, surface_velocity: wp.array | None, dt: float, visited: int) -> None:
        """Move the contacts of impacts in the next `dt` seconds below the centers of mass of the bodies that fall.

        There are at most `visited` contacts; their shapes have the friction of both. surface_velocity: (C,) of the
            contacts [m/s], None where no surface moves.
        """
        import warp as wp

        from usdsdg_physics.corrections.contacts.impacts_kernels import center_impacts

        wp.launch(
            center_impacts,
            dim=visited,
            inputs=[
                self._model.shape_body,
                self._model.shape_material_restitution,
                self._model.shape_material_mu,
                surface_velocity,
                self._free,
                self._model.body_com,
                state.body_q,
                state.body_qd,
                dt,
            ],
            outputs=[self._contacts],
            device=self._model.device,
        )
