"""Inertia that axes of rotation get of their own where a chain carries so much that its mass matrix has no inverse.

Ten links that carry a thousand times their mass turn it about ten points on a line, nearly as one. In single precision
the matrix then has an eigenvalue below zero, and the solver's result is no number.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.scene.joint_trees import Branch, JointTree
from usdsdg_physics.scene.records import STATIC, Scene

if TYPE_CHECKING:
    import newton

# The least eigenvalue per axis of a mass matrix whose diagonal is scaled to ones: sixteen times what rounding to single
# precision may take from it. With four times, rounding alone still shook the links of a chain under 5000 times the mass
# of one, which added 21 to 38 % to its energy, by loads that differ by a hundredth; so it is 11 to 21 %.
LEAST_EIGENVALUE = 16.0 * float(np.finfo(np.float32).eps)
# Of more axes than this the eigenvalue is not computed, and counts as zero.
MANY = 400


def add_chain_armature(
    builder: newton.ModelBuilder,
    tree: JointTree,
    scene: Scene,
    body_index: Mapping[str, int],
    joint_of: Mapping[str, int],
) -> None:
    """Add to the armature of a tree's axes of rotation what its mass matrix lacks, in the pose that is worst: straight.

    It is a share of what an axis moves, so small that nothing but the lightest links feels it.
    """
    turning = [branch for branch in tree.branches if _turns(branch)]
    if len(turning) < 2:
        return
    matrix = _straight_matrix(builder, tree, turning, scene, body_index)
    moved = np.diag(matrix)[-len(turning) :]
    axes = [_angular_axes(builder, joint_of[branch.joint.path]) for branch in turning]
    share = LEAST_EIGENVALUE * sum(map(len, axes)) - _least_eigenvalue(matrix)
    if share <= 0.0:
        return
    for dofs, inertia in zip(axes, moved):
        for dof in dofs:
            builder.joint_armature[dof] += share * float(inertia)


def _turns(branch: Branch) -> bool:
    return branch.joint.kind == "ball" or any(axis.angular for axis in branch.joint.axes)


def _angular_axes(builder: newton.ModelBuilder, joint: int) -> range:
    """Return where the axes of rotation of a joint are in joint_qd."""
    linear, angular = builder.joint_dof_dim[joint]
    start = builder.joint_qd_start[joint] + linear
    return range(start, start + angular)


def _least_eigenvalue(matrix: np.ndarray) -> float:
    if len(matrix) > MANY:
        return 0.0
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-30))
    return float(np.linalg.eigvalsh(scale[:, None] * matrix * scale)[0])


def _straight_matrix(
    builder: newton.ModelBuilder,
    tree: JointTree,
    turning: list[Branch],
    scene: Scene,
    body_index: Mapping[str, int],
) -> np.ndarray:
    """Return the mass matrix (D, D) of a tree on a line, in which all axes turn the same way, across the line.

    The first row is of a floating base that moves across the line; without one the first is that of the first joint.
    """
    column = {branch.joint.path: number for number, branch in enumerate(turning)}
    floats = bool(tree.root) and not scene.bodies[tree.root].kinematic
    # Of each body: where it hangs on its joint, how far that is along the line [m], and the axes that move it.
    hangs: dict[str, tuple[np.ndarray, float, np.ndarray]] = {}
    if tree.root:
        hangs[tree.root] = np.asarray(builder.body_com[body_index[tree.root]]), 0.0, np.zeros(len(turning))
    else:
        hangs[STATIC] = np.zeros(3), 0.0, np.zeros(len(turning))
    places, speeds, masses, moments = [], [], [], []
    at = np.zeros(len(turning))
    for branch in tree.branches:
        joint = branch.joint
        ends = (joint.frame1, joint.frame0) if branch.is_reversed else (joint.frame0, joint.frame1)
        parent_end, child_end = (np.asarray(frame[:3], np.float64) for frame in ends)
        before, along, moves = hangs.get(branch.parent, hangs.get(STATIC, (parent_end, 0.0, np.zeros(len(turning)))))
        if branch.parent != STATIC:
            along = along + float(np.linalg.norm(parent_end - before))
        moves = moves.copy()
        if joint.path in column:
            moves[column[joint.path]], at[column[joint.path]] = 1.0, along
        hangs[branch.child] = child_end, along, moves
        body = body_index[branch.child]
        places.append(along + float(np.linalg.norm(np.asarray(builder.body_com[body]) - child_end)))
        speeds.append(moves)
        masses.append(float(builder.body_mass[body]))
        moments.append(float(np.trace(np.asarray(builder.body_inertia[body], np.float64).reshape(3, 3))) / 3.0)
    turns = np.array(speeds)
    arms = turns * (np.array(places)[:, None] - at)
    if floats:
        masses.append(float(builder.body_mass[body_index[tree.root]]))
        moments.append(0.0)
        turns, arms = (np.vstack([rows, np.zeros(len(turning))]) for rows in (turns, arms))
        turns, arms = np.hstack([np.zeros((len(turns), 1)), turns]), np.hstack([np.ones((len(arms), 1)), arms])
    return arms.T @ (np.array(masses)[:, None] * arms) + turns.T @ (np.array(moments)[:, None] * turns)
