"""Take from bodies that fall on something fixed, without restitution, the spin that the impact would give them."""

# Warp structs are no classes to a type checker; Newton declares the arrays of models optional.
# pyright: reportGeneralTypeIssues=false, reportOptionalMemberAccess=false

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import newton
    import warp as wp

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


class Impacts:
    """Lets restitution 0 mean what things do that are dropped: they lie down.

    An ideal rigid cube that falls on a corner keeps up to three quarters of its energy as spin, hits with the next
    corner, and hops on for half a meter from a fall of three. Soft things lose it at once, and so do the bodies of
    PhysX, which sink in during the step of an impact until all their corners touch. What hits something that is not
    below its center of mass, as a plank the edge of a table, turns about that: no other corner would stop it.
    """

    def __init__(self, model: newton.Model, free: wp.array, contacts: ContactArrays) -> None:
        """`free` (N,) marks the bodies that move, and that no joint holds."""
        import warp as wp
        from newton import ShapeFlags

        from usdsdg_physics.corrections.contacts.supports_kernels import FixedShapes

        self._model, self._free, self._contacts = model, free, contacts
        body = model.shape_body.numpy()
        moves = (body >= 0) & np.isin(body, np.flatnonzero(free.numpy()))
        is_solid = model.shape_flags.numpy() & int(ShapeFlags.COLLIDE_SHAPES) != 0
        fixed = FixedShapes()
        fixed.indices = wp.array(np.flatnonzero(~moves & is_solid), dtype=wp.int32, device=model.device)
        fixed.kind, fixed.size, fixed.source = model.shape_type, model.shape_scale, model.shape_source_ptr
        fixed.radius, fixed.transform = model.shape_collision_radius, model.shape_transform
        fixed.body, fixed.group = model.shape_body, model.shape_collision_group
        self._fixed = fixed
        self._lever = wp.zeros(len(contacts.shape0), dtype=wp.vec3, device=model.device)

    def center_contacts(self, state: newton.State, surface_velocity: wp.array | None, dt: float, visited: int) -> None:
        """Move the contacts of impacts in the next `dt` seconds below the centers of mass of the bodies that fall.

        There are at most `visited` contacts; their shapes have the friction of both. surface_velocity: (C,) of the
            contacts [m/s], None where no surface moves.
        """
        import warp as wp

        from usdsdg_physics.corrections.contacts.impacts_kernels import center_impacts, find_levers

        model = self._model
        bodies = [self._free, model.body_com, state.body_q, state.body_qd]
        wp.launch(
            find_levers,
            dim=visited,
            inputs=[model.shape_body, self._fixed, self._contacts, model.gravity, *bodies],
            outputs=[self._lever],
            device=model.device,
        )
        wp.launch(
            center_impacts,
            dim=visited,
            inputs=[
                model.shape_body,
                model.shape_material_restitution,
                model.shape_material_mu,
                surface_velocity,
                self._lever,
                *bodies,
                dt,
            ],
            outputs=[self._contacts],
            device=model.device,
        )
