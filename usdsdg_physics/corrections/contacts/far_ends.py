"""Contacts at the far ends of bodies on their side, which the narrow phase does not see while these are up."""

# Warp structs are no classes to a type checker; Newton declares the arrays of models optional.
# pyright: reportGeneralTypeIssues=false, reportOptionalMemberAccess=false

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import newton
    import warp as wp

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


class FarEnds:
    """Lets cylinders, cones and hulls lie on both ends, though they are tilted.

    The narrow phase finds one end alone where the other is more than two degrees higher. An impulse at one end of a rod
    pushes the other down by half as much, and gravity adds to that in each step: a body so short that it tilts by two
    degrees in a step rocks from end to end without end, and what turns it meanwhile lets it roll away. With a contact
    at the end that is up, which holds nothing until that comes down, both stop in the same step.
    """

    def __init__(self, model: newton.Model, free: wp.array, contacts: ContactArrays) -> None:
        """`free` (N,) marks the bodies that move, and that no joint holds."""
        import newton
        import warp as wp

        from usdsdg_physics.corrections.contacts.outlines import outlines_of

        kinds = newton.GeoType
        long = np.isin(
            model.shape_type.numpy(), [int(kind) for kind in (kinds.CYLINDER, kinds.CONE, kinds.CONVEX_MESH)]
        )
        self._any = bool((long & (model.shape_body.numpy() >= 0)).any())
        self._device, self._contacts = model.device, contacts
        self._outlines = outlines_of(model, free)
        self._added, self._added_up_to = (
            wp.zeros(contacts.shape0.size, dtype=wp.int32, device=model.device) for _ in range(2)
        )

    def __bool__(self) -> bool:
        """Whether a body has a shape that may have ends."""
        return self._any

    def add_contacts(self, state: newton.State) -> None:
        """Add the contacts of far ends to those that the pipeline just found."""
        if self._device.is_cuda:
            self.add_at_once(state)
        else:
            self.add_one_by_one(state)

    def add_one_by_one(self, state: newton.State) -> None:
        """Add them in one thread, which looks at no more contacts than there are."""
        import warp as wp

        from usdsdg_physics.corrections.contacts.far_ends_kernels import append_far_ends

        wp.launch(
            append_far_ends,
            dim=1,
            inputs=[self._outlines, state.body_q],
            outputs=[self._contacts],
            device=self._device,
        )

    def add_at_once(self, state: newton.State) -> None:
        """Add them in as many threads as there is room for contacts, in the same order."""
        import warp as wp

        from usdsdg_physics.corrections.contacts.far_ends_kernels import add_far_ends, count_added, count_far_ends

        size, device = self._added.size, self._device
        inputs = [self._outlines, state.body_q]
        wp.launch(count_far_ends, dim=size, inputs=[*inputs, self._contacts], outputs=[self._added], device=device)
        wp.utils.array_scan(self._added, self._added_up_to)
        wp.launch(
            add_far_ends,
            dim=size,
            inputs=[*inputs, self._added, self._added_up_to],
            outputs=[self._contacts],
            device=device,
        )
        wp.launch(count_added, dim=1, inputs=[self._added_up_to], outputs=[self._contacts.count], device=device)
