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
        size = contacts.shape0.size if model.device.is_cuda else 0
        self._added, self._added_up_to = (wp.zeros(size, dtype=wp.int32, device=model.device) for _ in range(2))

    def __bool__(self) -> bool:
        """Whether a body has a shape that may have ends."""
        return self._any

    def add_contacts(self, state: newton.State) -> None:
        """Add the contacts of far ends to those that the pipeline just found."""
        import warp as wp

        from usdsdg_physics.corrections.contacts import far_ends_kernels as kernels

        inputs = [self._outlines, state.body_q]
        if not self._device.is_cuda:
            wp.launch(kernels.append_far_ends, dim=1, inputs=inputs, outputs=[self._contacts], device=self._device)
            return
        # On a GPU they get their places by a sum, so that these are the same in each run.
        size = self._added.size
        wp.launch(
            kernels.count_far_ends,
            dim=size,
            inputs=[*inputs, self._contacts],
            outputs=[self._added],
            device=self._device,
        )
        wp.utils.array_scan(self._added, self._added_up_to)
        wp.launch(
            kernels.add_far_ends,
            dim=size,
            inputs=[*inputs, self._added, self._added_up_to],
            outputs=[self._contacts],
            device=self._device,
        )
        wp.launch(
            kernels.count_added,
            dim=1,
            inputs=[self._added_up_to],
            outputs=[self._contacts.count],
            device=self._device,
        )
