"""The links of articulations: masses, gravity, where the base is, and how links move with the joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Usd

from usdsdg.articulations import dynamics
from usdsdg.articulations.joint_tree import JointTree
from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.compat.wrappers import bodies, poses
from usdsdg.compat.wrappers.joints.properties import JointProperties
from usdsdg.compat.wrappers.joints.rows import JointRows
from usdsdg.errors import BadValue, Unsupported
from usdsdg.session import body_velocities, engines
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.poses.rotations import matrix_from_quat
from usdsdg.stage.schemas import physx

_KNOWN = ("Revolute", "Prismatic", "Fixed")


class LinkRows:
    """The links of articulations that are built alike: one row per robot, the base first, parents before children."""

    def __init__(self, joints: JointRows) -> None:
        """Take the links of robots.

        Raises:
            BadValue: robots have different numbers of links.
        """
        self._joints = joints
        self.trees: list[JointTree] = [robot.tree for robot in joints.robots]
        if len({len(tree.links) for tree in self.trees}) > 1:
            raise BadValue(f"{', '.join(tree.root for tree in self.trees)} have different numbers of links")

    @property
    def names(self) -> list[str]:
        """The names of the links."""
        return [path.rsplit("/", 1)[1] for path in self.trees[0].links]

    @property
    def is_fixed(self) -> bool:
        """Whether the bases are fixed to the world."""
        return self.trees[0].is_fixed

    def prims(self, rows: Sequence[int], columns: Sequence[int]) -> list[Usd.Prim]:
        """Return the prims of links `columns` of the robots `rows`, row by row."""
        stage = current_stage()
        return [stage.GetPrimAtPath(self.trees[row].links[column]) for row in rows for column in columns]

    def bases(self, rows: Sequence[int]) -> list[Usd.Prim]:
        """Return the prims of the bases."""
        return self.prims(rows, [0])

    def disabled_gravities(self, rows: Sequence[int], columns: Sequence[int]) -> np.ndarray:
        """Return which links gravity does not pull (n, l) bool."""
        api = physx.PhysxRigidBodyAPI
        found = bodies.read(self.prims(rows, columns), api, lambda each: each.GetDisableGravityAttr(), False)
        return found.reshape(len(rows), len(columns))

    def disable_gravities(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Switch gravity off, or on, for links (n, l)."""
        switches = [bool(each) for each in values.reshape(-1)]
        bodies.write(self.prims(rows, columns), physx.PhysxRigidBodyAPI, "DisableGravity", switches)

    # --- how links move with the joints ---
    @property
    def jacobian_shape(self) -> tuple[int, int, int]:
        """Links, 6 and coordinates; a fixed base is no row, and a floating one has 6 columns."""
        count, dofs = len(self.trees[0].links), len(self.trees[0].dofs)
        return (count - 1, 6, dofs) if self.is_fixed else (count, 6, dofs + 6)

    def jacobians(self, rows: Sequence[int]) -> np.ndarray:
        """Return (n, *jacobian_shape) float32, to velocities of centers of mass and angular velocities in the world.

        Raises:
            PhysicsError: physics does not play.
            Unsupported: a joint has several axes.
        """
        found = [self._moved(row)[2][1 if self.is_fixed else 0 :] for row in rows]
        return np.array(found, np.float32).reshape(-1, *self.jacobian_shape)

    def mass_matrices(self, rows: Sequence[int]) -> np.ndarray:
        """Return (n, C, C) float32; coordinates are the columns of Jacobians. Errors are those of `jacobians`."""
        armatures = JointProperties(self._joints).armatures().astype(np.float64)
        found = []
        for row in rows:
            links, _, moved = self._moved(row)
            found.append(dynamics.mass_matrix(links, moved, armatures[row]))
        return np.array(found, np.float32)

    def gravity_forces(self, rows: Sequence[int]) -> np.ndarray:
        """Return the efforts (n, D) float32 that hold joints against gravity. Errors are those of `jacobians`."""
        found = []
        for row in rows:
            links, _, moved = self._moved(row)
            found.append(dynamics.gravity_forces(links, moved))
        return self._of_joints(found)

    def coriolis_forces(self, rows: Sequence[int]) -> np.ndarray:
        """Return the efforts (n, D) float32 that make up for Coriolis and centrifugal forces. See `jacobians`."""
        found = []
        for row in rows:
            links, motions, moved = self._moved(row)
            speeds = self._joints.robots[row].velocities
            if not self.is_fixed:
                linear, angular = body_velocities.velocities(self.bases([row]))
                speeds = np.concatenate([linear[0], angular[0], speeds]).astype(np.float64)
            found.append(dynamics.coriolis_forces(links, motions, moved, speeds, is_fixed=self.is_fixed))
        return self._of_joints(found)

    def _of_joints(self, forces: list[np.ndarray]) -> np.ndarray:
        dofs = len(self.trees[0].dofs)
        return np.array([force[len(force) - dofs :] for force in forces], np.float32).reshape(-1, dofs)

    def _moved(self, row: int) -> tuple[dynamics.Links, list[dynamics.Motion], np.ndarray]:
        tree = self.trees[row]
        if others := [each.joint.path for each in tree.branches if each.joint.kind not in _KNOWN]:
            raise Unsupported(
                f"{others[0]}: Jacobians and mass matrices are known of revolute, prismatic and fixed joints only; "
                "split a joint with several axes into such"
            )
        columns = range(len(tree.links))
        prims = self.prims([row], columns)
        found = engines.physics().mass_properties(tree.links)
        origins, turns = poses.world_poses(prims)
        axes = matrix_from_quat(poses.xyzw(turns).astype(np.float64))
        gravity = np.array(simulation().scene().get_gravity(), np.float64)
        pulled = ~self.disabled_gravities([row], columns)[0]
        links = dynamics.Links(
            origins + np.einsum("ni,nij->nj", found.center, axes),
            found.mass,
            np.einsum("nji,njk,nkl->nil", axes, found.inertia, axes),
            pulled[:, None] * gravity,
        )
        motions = tree.motions()
        return links, motions, dynamics.jacobian(links, motions, len(tree.dofs), is_fixed=tree.is_fixed)
