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
        self,
        scene: Scene,
        model: newton.Model,
        shape_index: dict[str, int],
        free: wp.array,
        contacts: ContactArrays,
        *,
        lifts: bool,
    ) -> None:
        """Allocate what bodies need.

        Args:
            free: (N,) the bodies that move, and that no joint holds.
            lifts: whether what is light lifts what is much heavier as well where it only touches something fixed. Our
                own solver moves it out of that at once; Newton's keeps it there, squeezed, until what it lifts is up.
        """
        import warp as wp

        self._model, self._free, self._contacts, self._lifts = model, free, contacts, lifts
        colliders = scene.colliders.values()
        thickness = half_thicknesses(colliders, shape_index, model.shape_count, least=MIN_HALF_THICKNESS)
        self._half_thickness = wp.array(thickness, dtype=wp.float32, device=model.device)
        # (N,) not zero for bodies that overlap with others farther than what rests.
        self.squeezed = wp.zeros(model.body_count, dtype=wp.int32, device=model.device)
        self._support, self._touched, self._touched_by = (
            wp.zeros(model.body_count, dtype=wp.int32, device=model.device) for _ in range(3)
        )
        # (N,) how many others that are free touch each body.
        self.neighbors = wp.zeros(model.body_count, dtype=wp.int32, device=model.device)

    def redirect_contacts(self, state: newton.State, h: float, visited: int) -> None:
        """Correct the contacts, at most `visited`, before the solver's step of `h` seconds.

        That is after those that need the shapes that touch.
        """
        import warp as wp

        from usdsdg_physics.corrections.overlaps.squeezes_kernels import note_squeezes, redirect_squeezes

        for array in (self.squeezed, self._support, self._touched, self._touched_by, self.neighbors):
            array.zero_()
        wp.launch(
            note_squeezes,
            dim=visited,
            inputs=[self._model.shape_body, self._half_thickness, self._free, state.body_q, self._contacts],
            outputs=[self.squeezed, self._support, self._touched, self._touched_by, self.neighbors],
            device=self._model.device,
        )
        wp.launch(
            redirect_squeezes,
            dim=visited,
            inputs=[
                self._model.shape_body,
                self._half_thickness,
                self._free,
                self._model.body_inv_mass,
                self._model.body_com,
                state.body_q,
                state.body_qd,
                self.squeezed,
                self._support,
                self._touched,
                self._touched_by,
                int(self._lifts),
                h,
            ],
            outputs=[self._contacts],
            device=self._model.device,
        )
