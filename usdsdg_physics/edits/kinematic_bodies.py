"""Kinematic bodies of a stage that is read again: they go on from where they are, or were put there with others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from pxr import Sdf

from usdsdg.stage.changes import Changes
from usdsdg.stage.physics.instances import prim_of
from usdsdg_physics.edits.subtrees import nearly_equal
from usdsdg_physics.scene.joint_trees import JointTree, joint_trees
from usdsdg_physics.scene.records import STATIC, Body, Joint, Scene
from usdsdg_physics.scene.rigid_frames import pose_matrix, rigid_pose
from usdsdg_physics.world.world import World

# What is nearer than this was not moved: positions [m], per meter from the origin, and quaternions.
_ROUNDING = 1e-6


class KinematicBodies:
    """Where a simulation has the kinematic bodies, and how fast, while one world replaces another."""

    def __init__(self) -> None:
        self._poses: dict[str, np.ndarray] = {}  # by path: (7,) m
        self._velocities: dict[str, np.ndarray] = {}  # (6,) m/s, rad/s of those that moved in the latest step
        self._targets: dict[str, np.ndarray] = {}  # (7,) m, where the stage has those that are on their way

    def note(self, bodies: Mapping[str, Body], world: World) -> None:
        """Note where a world that will be replaced has its kinematic `bodies`."""
        poses, velocities = world.poses().astype(np.float64), world.kinematic_velocities()
        rows = {path: world.body_index[path] for path, body in bodies.items() if body.kinematic}
        self._poses = {path: poses[row] for path, row in rows.items()}
        self._velocities = {path: velocities[row] for path, row in rows.items() if row in velocities}

    def begin(self, scene: Scene, changes: Changes) -> None:
        """Let the bodies of a scene that `changes` moved on the stage begin where the simulation has them.

        The next step moves them to where the stage has them, as without a new world. Those whose prims were made anew
        are there at once, and those that time samples move are where these have them.
        """
        bodies = scene.bodies
        self._poses = {
            path: pose
            for path, pose in self._poses.items()
            if path in bodies and bodies[path].kinematic and not _is_made_anew(path, changes)
        }
        self._targets = {
            path: np.array(bodies[path].pose)
            for path, pose in self._poses.items()
            if path not in scene.animated and _differs(bodies[path].pose, pose)
        }
        for path in self._targets:
            bodies[path] = replace(bodies[path], pose=tuple(self._poses[path].tolist()))

    def resume(self, world: World) -> None:
        """Let the bodies go on in the new world."""
        index = world.body_index
        world.resume_kinematic({index[path]: v for path, v in self._velocities.items() if path in self._poses})
        world.add_kinematic_targets({index[path]: pose for path, pose in self._targets.items()})


def carried_bodies(
    scene: Scene, before: Scene, poses: Mapping[str, np.ndarray], changes: Changes
) -> dict[str, np.ndarray]:
    """Return the poses (7,) [m] of bodies that hang on a base which was put somewhere else on the stage.

    They hang on the joints that were there before. Nothing is carried where another body of a tree was moved, too.

    Args:
        before: what was simulated.
        poses: (7,) [m] where it had the bodies, by path.
        changes: of the stage since then.
    """
    joints = [joint for path, joint in scene.joints.items() if _is_same(joint, before.joints.get(path))]
    found: dict[str, np.ndarray] = {}
    for tree in joint_trees(scene.bodies, joints) if joints else ():
        base = _base(tree)
        if not base or not poses.keys() >= set(tree.bodies):
            continue
        moved = [
            path for path in tree.bodies if _differs(scene.bodies[path].pose, poses[path]) and _is_moved(path, changes)
        ]
        if moved == [base]:
            motion = np.linalg.inv(pose_matrix(poses[base])) @ pose_matrix(scene.bodies[base].pose)
            links = [path for path in tree.bodies if path != base]
            found |= {path: rigid_pose(pose_matrix(poses[path]) @ motion, 1.0) for path in links}
    return found


def _base(tree: JointTree) -> str:
    """Return the body that takes the others of a tree along, "" for none."""
    if tree.root != STATIC:
        return tree.root
    roots = [branch for branch in tree.branches if branch.parent == STATIC]
    fixed = [branch.child for branch in roots if branch.joint.kind == "fixed" and branch.joint.articulated]
    return fixed[0] if len(fixed) == len(roots) == 1 else ""


def _is_same(now: Joint, before: Joint | None) -> bool:
    """Return whether a joint connects the same points of the same bodies as before."""
    if before is None or (now.body0, now.body1) != (before.body0, before.body1):
        return False
    return nearly_equal(now.frame0 + now.frame1, before.frame0 + before.frame1)


def _is_made_anew(path: str, changes: Changes) -> bool:
    """Return whether the prim of a body was composed again, or the units of the stage changed."""
    prim = Sdf.Path(prim_of(path))
    return Sdf.Path.absoluteRootPath in changes.changed or any(prim.HasPrefix(root) for root in changes.resynced)


def _is_moved(path: str, changes: Changes) -> bool:
    """Return whether the transform of a body or of a prim above it was edited."""
    prims = Sdf.Path(prim_of(path)).GetPrefixes()
    names = (name for prim in prims for name in changes.changed.get(prim, ()))
    return _is_made_anew(path, changes) or any(name.startswith("xformOp") for name in names)


def _differs(a: ArrayLike, b: ArrayLike) -> bool:
    """Return whether two poses (7,) differ by more than the rounding of single precision."""
    first, second = np.asarray(a, np.float64), np.asarray(b, np.float64)
    turned = min(np.abs(first[3:] - second[3:]).max(), np.abs(first[3:] + second[3:]).max())
    return bool(
        np.abs(first[:3] - second[:3]).max() > _ROUNDING * (1.0 + np.abs(second[:3]).max()) or turned > _ROUNDING
    )
