"""Distance joints: contacts between two points, which may be neither too near nor too far from each other."""

# Warp structs are no classes to a type checker.
# pyright: reportGeneralTypeIssues=false, reportArgumentType=false

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.scene.records import Joint

if TYPE_CHECKING:
    import newton
    import warp as wp

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


class DistanceJoints:
    """Adds, after the contacts of shapes, two for each joint: one that pulls and one that pushes.

    The solver knows no joint of this kind, but a contact keeps two points from passing each other along a normal, which
    is all that a rope or a rod does. Their shapes collide with nothing, and have no friction and no restitution. Joints
    with a spring are forces instead, which act where a rope or a rod would.
    """

    def __init__(
        self,
        joints: Sequence[Joint],
        model: newton.Model,
        contacts: ContactArrays,
        *,
        body_index: Mapping[str, int],
        shapes: Mapping[str, int],
        free: wp.array,
        touched: wp.array,
        rest_time: wp.array,
    ) -> None:
        """Take the joints of a scene.

        Args:
            shapes: by body, a shape of it that contacts may be given to.
            free: (N,) marks the bodies that move by themselves.
            touched: (N,) is set for bodies with contacts.
            rest_time: (N,) how long bodies have been at rest; cleared where the other end of a joint is moved.
        """
        import warp as wp

        self._model, self._contacts = model, contacts
        self._free, self._touched, self._rest_time = free, touched, rest_time
        device = model.device

        def array(rows: list, dtype: type) -> wp.array:
            return wp.array(rows, dtype=dtype, device=device)

        self._paths = [joint.path for joint in joints]
        ends = [(joint.body0, joint.body1) for joint in joints]
        self._bodies = array([[body_index.get(path, -1) for path in pair] for pair in ends], wp.vec2i)
        self._shapes = array([[shapes[path] for path in pair] for pair in ends], wp.vec2i)
        self._point0, self._point1 = (
            array([getattr(joint, f"frame{end}")[:3] for joint in joints], wp.vec3) for end in (0, 1)
        )
        self._range = array([joint.distance for joint in joints], wp.vec2)
        self._spring = array([joint.spring or (-1.0, 0.0) for joint in joints], wp.vec2)
        self._break_force = array([joint.break_force for joint in joints], wp.float32)
        self._force = wp.zeros(len(joints), dtype=wp.float32, device=device)
        self._first = wp.zeros(1, dtype=wp.int32, device=device)
        self._broken = wp.zeros(len(joints), dtype=wp.int32, device=device)
        self._steady = wp.zeros(model.body_count, dtype=wp.spatial_vector, device=device)
        self.has_springs = any(joint.spring for joint in joints)
        self.breakable = any(np.isfinite(joint.break_force) for joint in joints)

    def begin(self, state: newton.State) -> None:
        """Remember the forces that act during a whole step."""
        import warp as wp

        if self.has_springs:
            assert state.body_f is not None
            wp.copy(self._steady, state.body_f)

    def add_contacts(self, state: newton.State, surface_velocity: wp.array | None, dt: float) -> None:
        """Add the contacts of the solver's next step of `dt` seconds, after every correction that looks at contacts.

        `surface_velocity` (C,) [m/s] is that of the contacts, None where no surface moves.
        """
        import warp as wp

        from usdsdg_physics.corrections.joints.distance_joints_kernels import (
            add_distance_contacts,
            count_distance_contacts,
            pull_springs,
        )

        device, count = self._model.device, self._force.size
        wp.launch(
            add_distance_contacts,
            dim=count,
            inputs=[
                self._bodies,
                self._shapes,
                self._point0,
                self._point1,
                self._range,
                self._spring,
                self._free,
                state.body_q,
                state.body_qd,
            ],
            outputs=[self._contacts, surface_velocity, self._touched, self._rest_time],
            device=device,
        )
        wp.launch(
            count_distance_contacts,
            dim=1,
            inputs=[count, self._contacts.shape0.size],
            outputs=[self._contacts.count, self._first],
            device=device,
        )
        if self.has_springs:
            assert state.body_f is not None
            wp.copy(state.body_f, self._steady)
            wp.launch(
                pull_springs,
                dim=1,
                inputs=[
                    count,
                    self._bodies,
                    self._point0,
                    self._point1,
                    self._range,
                    self._spring,
                    dt,
                    self._model.body_inv_mass,
                    self._model.body_inv_inertia,
                    self._model.body_com,
                    state.body_q,
                    state.body_qd,
                ],
                outputs=[state.body_f, self._force],
                device=device,
            )

    def finish(self, states: Sequence[newton.State]) -> None:
        """Leave the forces that act during a whole step to the next one."""
        import warp as wp

        if self.has_springs:
            for state in states:
                assert state.body_f is not None
                wp.copy(state.body_f, self._steady)

    def note_forces(self, forces: wp.array) -> None:
        """Note which joints break under the forces (C,) [N] in the contacts of the solver's latest step."""
        import warp as wp

        from usdsdg_physics.corrections.joints.distance_joints_kernels import note_broken_distances

        wp.launch(
            note_broken_distances,
            dim=self._force.size,
            inputs=[self._first, self._spring, self._force, self._break_force, forces],
            outputs=[self._broken],
            device=self._model.device,
        )

    def broken(self) -> list[str]:
        """Return the paths of the joints that have broken."""
        return [self._paths[row] for row in np.flatnonzero(self._broken.numpy())] if self.breakable else []
