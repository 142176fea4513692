"""Tops: bodies that turn freely about a point that is fixed."""

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


class Tops:
    """Bodies on a ball joint to the world or a kinematic body, and on no other, with nothing near.

    The solver turns them by forces from the begin of a substep, and adds the gyroscopic torque of their center of mass
    and of their arm to the joint in different ways: slow tops with a long arm precessed half as far again as they
    should, and rose.
    """

    def __init__(
        self,
        model: newton.Model,
        scene: Scene,
        trees: Sequence[JointTree],
        *,
        body_index: Mapping[str, int],
        joint_of: Mapping[str, int],
        touched: wp.array,
    ) -> None:
        """Take the trees of a scene.

        Args:
            joint_of: numbers of joints, by path.
            touched: (N,) which bodies something is near to.
        """
        import warp as wp

        branches = [tree.branches[0] for tree in trees if _is_top(tree, scene)]
        armature = model.joint_armature.numpy()
        starts = model.joint_qd_start.numpy()
        rows = [(body_index[branch.child], joint_of[branch.joint.path]) for branch in branches]
        # An axis with an inertia of its own would take a part of the momentum.
        rows = [row for row in rows if not armature[starts[row[1]] : starts[row[1] + 1]].any()]
        pairs = np.array(rows, np.int32).reshape(-1, 2)
        self._model: Any = model
        self._bodies, self._joints = (
            wp.array(column, dtype=wp.int32, device=model.device) for column in np.ascontiguousarray(pairs.T)
        )
        self._touched = touched

    def __bool__(self) -> bool:
        return self._bodies.size > 0

    def turn(self, before: newton.State, after: newton.State, dt: float) -> None:
        """Turn the tops that nothing is near for a substep of `dt` seconds."""
        import warp as wp

        from usdsdg_physics.corrections.joints.tops_kernels import turn_tops

        model = self._model
        wp.launch(
            turn_tops,
            dim=self._bodies.size,
            inputs=[
                self._bodies,
                self._joints,
                model.gravity,
                dt,
                model.joint_q_start,
                model.joint_qd_start,
                model.joint_parent,
                model.joint_X_p,
                model.joint_X_c,
                model.body_mass,
                model.body_inertia,
                model.body_com,
                self._touched,
                before.body_f,
                before.body_q,
                before.body_qd,
            ],
            outputs=[after.joint_q, after.joint_qd, after.body_q, after.body_qd],
            device=model.device,
        )


def _is_top(tree: JointTree, scene: Scene) -> bool:
    is_held = not tree.root or scene.bodies[tree.root].kinematic
    return is_held and len(tree.branches) == 1 and not tree.loops and tree.branches[0].joint.kind == "ball"
