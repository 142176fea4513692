"""The momentum of trees that float: what joints transmit does not change it."""

# Newton declares the arrays of models and states optional; after `finalize` all are there.
# pyright: reportOptionalMemberAccess=false, reportArgumentType=false

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from usdsdg_physics.scene.joint_trees import JointTree
from usdsdg_physics.scene.records import Scene

if TYPE_CHECKING:
    import newton
    import warp as wp


class FloatingTrees:
    """Trees with a floating base, which nothing but gravity and what pushes their bodies moves where nothing is near.

    The solver moves their joints by forces from the begin of a substep, also those of the turning frames that joints
    measure in. What slides on a body that turns at ω gives the tree a momentum that grows by about 4 ω² dt of itself in
    a second.
    """

    def __init__(
        self,
        model: newton.Model,
        scene: Scene,
        trees: Sequence[JointTree],
        *,
        body_index: Mapping[str, int],
        bases: Mapping[str, tuple[int, int]],
        touched: wp.array,
    ) -> None:
        """Take the trees of a scene.

        Args:
            bases: by body, where it is in joint_q and joint_qd.
            touched: (N,) which bodies something is near to.
        """
        import warp as wp

        floating = [tree for tree in trees if tree.root and not scene.bodies[tree.root].kinematic]
        bodies = [[body_index[path] for path in tree.bodies] for tree in floating]

        def integers(values: Any) -> wp.array:
            return wp.array(np.asarray(values, np.int32), dtype=wp.int32, device=model.device)

        self._model: Any = model
        self._starts = integers(np.concatenate([[0], np.cumsum([len(each) for each in bodies])]))
        self._bodies = integers([body for each in bodies for body in each])
        self._coordinates = integers([bases[tree.root][0] for tree in floating])
        self._dofs = integers([bases[tree.root][1] for tree in floating])
        self._touched = touched

    def __bool__(self) -> bool:
        return self._dofs.size > 0

    def keep_momentum(self, before: newton.State, after: newton.State, dt: float) -> None:
        """Give trees that nothing is near the momentum that they have after the solver's step of `dt` seconds."""
        import warp as wp

        from usdsdg_physics.corrections.joints.floating_trees_kernels import keep_momentum

        model = self._model
        wp.launch(
            keep_momentum,
            dim=self._dofs.size,
            inputs=[
                self._starts,
                self._bodies,
                self._coordinates,
                self._dofs,
                model.gravity,
                dt,
                model.body_mass,
                model.body_inertia,
                model.body_com,
                model.steel.rigid_body_linear_damping,
                model.steel.rigid_body_angular_damping,
                self._touched,
                before.body_f,
                before.body_q,
                before.body_qd,
            ],
            outputs=[after.joint_q, after.joint_qd, after.body_q, after.body_qd],
            device=model.device,
        )
