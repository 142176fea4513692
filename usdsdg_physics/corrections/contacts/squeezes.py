"""Free bodies that heavier ones squeeze: they push these apart, rather than turn between them or sink into a floor."""

# Warp structs are no classes to a type checker.
# pyright: reportGeneralTypeIssues=false

from __future__ import annotations

from typing import TYPE_CHECKING

from usdsdg_physics.scene.extents import half_thicknesses
from usdsdg_physics.scene.records import Scene

if TYPE_CHECKING:
    import newton
    import warp as wp

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays

# Thinner things count as this thick [m]: what rests overlaps by up to a few tenths of a millimeter.
MIN_HALF_THICKNESS = 1e-3


class Squeezes:
    """Corrects the contacts that are deep for a thin body: between a floor and what lies on it, these do not end.

    The solver moves bodies along a straight line for each contact. Where one is as deep as half of a plate, it turns
    the plate about its middle, from one corner in the floor to the other, and neither the plate nor what lies on it
    rises. And what is a hundred times heavier than what it lies on is lifted so slowly that it does not rise at all.
    """

    def __init__(
        self, scene: Scene, model: newton.Model, shape_index: dict[str, int], free: wp.array, contacts: ContactArrays
    ) -> None:
        """`free` (N,) marks the bodies that move, and that no joint holds."""
        import warp as wp

        self._model, self._free, self._contacts = model, free, contacts
        colliders = scene.colliders.values()
        thickness = half_thicknesses(colliders, shape_index, model.shape_count, least=MIN_HALF_THICKNESS)
        self._half_thickness = wp.array(thickness, dtype=wp.float32, device=model.device)
        # (N,) not zero for bodies that overlap with others farther than what rests.
        self.squeezed = wp.zeros(model.body_count, dtype=wp.int32, device=model.device)
        self._support = wp.zeros(model.body_count, dtype=wp.int32, device=model.device)
        # (N,) how many others that are free touch each body.
        self.neighbors = wp.zeros(model.body_count, dtype=wp.int32, device=model.device)

    def redirect_contacts(self, state: newton.State) -> None:
        """Correct the contacts before the solver's step, after those that need to know which shapes touch."""
        import warp as wp

        from usdsdg_physics.corrections.contacts.squeezes_kernels import note_squeezes, redirect_squeezes

        self.squeezed.zero_()
        self._support.zero_()
        self.neighbors.zero_()
        wp.launch(
            note_squeezes,
            dim=self._contacts.shape0.size,
            inputs=[self._model.shape_body, self._half_thickness, self._free, state.body_q, self._contacts],
            outputs=[self.squeezed, self._support, self.neighbors],
            device=self._model.device,
        )
        wp.launch(
            redirect_squeezes,
            dim=self._contacts.shape0.size,
            inputs=[
                self._model.shape_body,
                self._half_thickness,
                self._free,
                self._model.body_inv_mass,
                self._model.body_com,
                state.body_q,
                self.squeezed,
                self._support,
            ],
            outputs=[self._contacts],
            device=self._model.device,
        )
