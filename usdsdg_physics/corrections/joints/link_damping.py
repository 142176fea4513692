"""The damping of links, of which the solver damps only free roots of trees, and their highest velocities."""

# Newton declares the arrays of models and states optional; after `finalize` all are there.
# pyright: reportOptionalMemberAccess=false, reportArgumentType=false

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from usdsdg_physics.scene.records import Body

if TYPE_CHECKING:
    import newton


class LinkDamping:
    """Drag of the bodies that follow from joint coordinates, by their linear and angular damping, in each substep.

    Links of a tree that hangs on the world or on a kinematic body are damped as free bodies are. What a tree with a
    free root does as a whole is damped with that, so its links are damped against their parents.

    As in PhysX, links and free roots lose what is above their highest velocities at the begin of a step, and their
    joints share that out: a motor may drive a wheel faster.
    """

    def __init__(self, model: newton.Model, bodies: Sequence[Body]) -> None:
        """`bodies` are those of the model, in its order."""
        import newton
        import warp as wp

        kinds, parents, children = (
            array.numpy() for array in (model.joint_type, model.joint_parent, model.joint_child)
        )
        kinematic = (model.body_flags.numpy() & int(newton.BodyFlags.KINEMATIC)) != 0
        articulations = model.joint_articulation.numpy()
        is_free = kinds == int(newton.JointType.FREE)
        afloat = set(articulations[is_free & ~kinematic[children]].tolist())
        joints = np.flatnonzero(~is_free & ~kinematic[children])
        joints = joints[np.argsort(articulations[joints], kind="stable")]
        floats = np.isin(articulations[joints], list(afloat))
        self._model: Any = model
        self._links = wp.array(children[joints], dtype=wp.int32, device=model.device)
        self._against = wp.array(np.where(floats, parents[joints], -1), dtype=wp.int32, device=model.device)
        # One thread for each tree, so that sums have one order.
        starts = np.unique(articulations[joints], return_index=True)[1]
        self._trees = wp.array([*starts, len(joints)], dtype=wp.int32, device=model.device)
        roots = np.flatnonzero(is_free & np.isin(articulations, articulations[joints]) & ~kinematic[children])
        limited = np.sort(children[np.concatenate([joints, roots])])
        self._limited = wp.array(limited, dtype=wp.int32, device=model.device)
        speeds = [[body.max_velocity, body.max_angular_velocity] for body in bodies]
        self._max_velocity, self._max_angular_velocity = (
            wp.array(each, dtype=wp.float32, device=model.device) for each in np.array(speeds, np.float32).T.copy()
        )
        self._kept = wp.zeros(model.body_count, dtype=wp.spatial_vector, device=model.device)

    def __bool__(self) -> bool:
        return self._links.size > 0

    def add(self, state: newton.State, dt: float, *, limits: bool) -> None:
        """Add the drag, and what `limits` speeds, to what pushes bodies in the solver's next step of `dt` seconds."""
        import warp as wp

        from usdsdg_physics.corrections.joints.link_damping_kernels import drag_links, limit_links

        model = self._model
        wp.copy(self._kept, state.body_f)
        wp.launch(
            drag_links,
            dim=self._trees.size - 1,
            inputs=[
                self._trees,
                self._links,
                self._against,
                dt,
                model.steel.rigid_body_linear_damping,
                model.steel.rigid_body_angular_damping,
                model.body_mass,
                model.body_inertia,
                state.body_q,
                state.body_qd,
            ],
            outputs=[state.body_f],
            device=model.device,
        )

        if limits:
            wp.launch(
                limit_links,
                dim=self._limited.size,
                inputs=[
                    self._limited,
                    dt,
                    self._max_velocity,
                    self._max_angular_velocity,
                    model.body_mass,
                    model.body_inertia,
                    state.body_q,
                    state.body_qd,
                ],
                outputs=[state.body_f],
                device=model.device,
            )

    def remove(self, state: newton.State) -> None:
        """Leave what pushes bodies as it was."""
        import warp as wp

        wp.copy(state.body_f, self._kept)
