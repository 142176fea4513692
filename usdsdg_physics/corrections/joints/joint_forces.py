"""The forces and torques that the joints of articulations pass on, which scripts read."""

# Newton declares the arrays of models and states optional; after `finalize` all are there.
# pyright: reportArgumentType=false

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.scene.joint_trees import Branch
from usdsdg_physics.scene.records import STATIC, Scene

if TYPE_CHECKING:
    import newton
    import warp as wp

    from usdsdg_physics.model.build import BuiltModel


class JointForces:
    """The mean over a step of what body 0 of a joint exerts on body 1, in the joint's frame at body 1, as in PhysX."""

    def __init__(self, built: BuiltModel, branches: Mapping[str, Branch]) -> None:
        import warp as wp

        model, index = built.model, built.body_index
        self._model, self._branches = model, list(branches.values())
        self._rows = {path: row for row, path in enumerate(branches)}
        joints = [branch.joint for branch in self._branches]

        def array(values: list, dtype: type) -> wp.array:
            return wp.array(values, dtype=dtype, device=model.device)

        self._child = array([index[branch.child] for branch in self._branches], wp.int32)
        self._body = array([index.get(joint.body1, -1) for joint in joints], wp.int32)
        self._frame = array([joint.frame1 for joint in joints], wp.transform)
        self._sign = array([-1.0 if branch.is_reversed else 1.0 for branch in self._branches], wp.float32)
        self._measured = wp.zeros(len(joints), dtype=wp.spatial_vector, device=model.device)

    @classmethod
    def of(cls, built: BuiltModel, scene: Scene) -> JointForces | None:
        """Return those of the joints in articulations; None where there are none.

        Bodies that a kinematic one carries have its acceleration from nothing, so their joints are not among them.
        """
        kinematic = {path for path, body in scene.bodies.items() if body.kinematic}
        branches = {
            branch.joint.path: branch
            for tree in built.joints.trees
            for branch in tree.branches
            if branch.joint.articulated and tree.root not in kinematic
        }
        return cls(built, branches) if branches else None

    def apply(self, before: newton.State, wrench: wp.array, *, substep: int, substeps: int) -> None:
        """Add the `wrench` (N,) at each body's center of mass in a substep that began with a state."""
        import warp as wp

        from usdsdg_physics.corrections.joints.joint_forces_kernels import add_joint_forces

        wp.launch(
            add_joint_forces,
            dim=len(self._branches),
            inputs=[
                self._child,
                self._body,
                self._frame,
                self._sign,
                self._model.body_com,
                before.body_q,
                wrench,
                1.0 / substeps,
                int(substep == 0),
            ],
            outputs=[self._measured],
            device=self._model.device,
        )

    @property
    def paths(self) -> Collection[str]:
        """The paths of the joints that are measured."""
        return self._rows.keys()

    def of_joints(self, paths: Sequence[str]) -> np.ndarray:
        """Return forces [N] and torques [N m] (n, 6) of some `paths`, torques about the joint at body 1."""
        rows = [self._rows[path] for path in paths]
        found = self._measured.numpy().astype(np.float64)[rows].reshape(-1, 6)
        # What holds the base where it is, is no joint to PhysX.
        held = [self._branches[row].parent == STATIC and self._branches[row].joint.kind == "fixed" for row in rows]
        found[held] = 0.0
        return found
