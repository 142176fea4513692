"""What links need that free bodies have: bodies that they carry stay awake, steps that are not finite are reverted."""

# Warp structs are no classes to a type checker.
# pyright: reportGeneralTypeIssues=false

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import newton
    import warp as wp

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays

# What a link carries may carry others, in stacks of up to this height.
CARRIED_LEVELS = 8


class Links:
    """The bodies that joints move, by tree."""

    def __init__(
        self,
        model: newton.Model,
        contacts: ContactArrays,
        tree: np.ndarray,
        ranges: np.ndarray,
        rest_time: wp.array,
        nonfinite_steps: wp.array,
    ) -> None:
        """Take the links of a model.

        Args:
            tree: (N,) the tree of each body, -1 for a body that is no link.
            ranges: (T, 4) begin and end of each tree in joint_q, and in joint_qd.
            rest_time: (N,) how long each body has been at rest; cleared for those that a moving link carries.
            nonfinite_steps: (N,) counts steps that were reverted.
        """
        import warp as wp

        device = model.device
        self._model, self._contacts = model, contacts
        self._tree = wp.array(tree, dtype=wp.int32, device=device)
        self._ranges = wp.array(ranges, dtype=wp.vec4i, device=device)
        self._rest_time, self._nonfinite_steps = rest_time, nonfinite_steps
        self._level = wp.zeros(model.body_count, dtype=wp.int32, device=device)
        self._next_level = wp.zeros_like(self._level)
        self._is_finite = wp.zeros(len(ranges), dtype=wp.int32, device=device)

    def keep_awake(self, state: newton.State) -> None:
        """Let no body be held at rest that touches a moving link, or a body that such a one carries."""
        import warp as wp

        from usdsdg_physics.corrections.joints.links_kernels import mark_moving_links, wake_carried

        wp.launch(
            mark_moving_links,
            dim=self._model.body_count,
            inputs=[self._tree, state.body_qd, self._next_level, CARRIED_LEVELS],
            outputs=[self._level],
            device=self._model.device,
        )
        self._next_level.zero_()
        wp.launch(
            wake_carried,
            dim=self._contacts.shape0.size,
            inputs=[self._model.shape_body, self._tree, self._level, self._contacts],
            outputs=[self._next_level, self._rest_time],
            device=self._model.device,
        )

    def revert_nonfinite(self, before: newton.State, after: newton.State) -> None:
        """Stop the trees that the solver's step gave a coordinate that is not a number where they were."""
        import warp as wp

        from usdsdg_physics.corrections.joints.links_kernels import revert_coordinates, revert_links

        wp.launch(
            revert_coordinates,
            dim=self._is_finite.size,
            inputs=[self._ranges, before.joint_q],
            outputs=[after.joint_q, after.joint_qd, self._is_finite],
            device=self._model.device,
        )
        wp.launch(
            revert_links,
            dim=self._model.body_count,
            inputs=[self._tree, self._is_finite, before.body_q],
            outputs=[after.body_q, after.body_qd, self._nonfinite_steps],
            device=self._model.device,
        )
