"""Mass matrices of trees of joints, on the host: what resists an axis, and velocities that keep momentum."""

# pyright: reportOptionalMemberAccess=false

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.stage.poses.rotations import matrix_from_quat
from usdsdg_physics.model.joints import BuiltJoints

if TYPE_CHECKING:
    import newton


@dataclass(frozen=True)
class TreeInertia:
    """The coordinates of one articulation of a model where it is now, and how bodies move with them."""

    dofs: np.ndarray  # (D,) their numbers in joint_qd
    prescribed: np.ndarray  # (D,) bool: of a kinematic base, which nothing pushes
    armature: np.ndarray  # (D,) kg, kg m²: what axes have besides the bodies
    matrix: np.ndarray  # (D, D) kg, kg m², with the armature
    # By body: (6, D) from velocities of coordinates to that of its center of mass and its angular velocity, and back
    # from those to momentum, both in the world.
    motion: dict[int, np.ndarray]
    momentum: dict[int, np.ndarray]

    def projected(self, velocities: np.ndarray, prescribed: np.ndarray) -> np.ndarray:
        """Return the coordinates' velocities (D,) that have the momentum of body velocities (N, 6).

        Those of a kinematic base are `prescribed` (D,), and what it carries along keeps its momentum. The armature has
        the speed of its axis, and takes none of that momentum: velocities that joints allow stay as they are.
        """
        found, free = np.where(self.prescribed, prescribed, 0.0), ~self.prescribed
        impulse = sum((inertia @ velocities[body] for body, inertia in self.momentum.items()), np.zeros(len(self.dofs)))
        bare = self.matrix - np.diag(self.armature)
        impulse = impulse - bare @ found
        found[free] = _solved(bare[np.ix_(free, free)], impulse[free])
        return found


def axis_inertias(
    model: newton.Model, built: BuiltJoints, state: newton.State, trees: Iterable[int]
) -> dict[int, float]:
    """Return by axis of some trees what resists it [kg, kg m²] while all other axes of its tree move freely."""
    found: dict[int, float] = {}
    row_of = {axis.dof: row for row, axis in enumerate(built.axes)}
    for number in trees:
        tree = tree_inertia(model, built.articulations[number], state)
        free = np.flatnonzero(~tree.prescribed)
        inverse = _solved(tree.matrix[np.ix_(free, free)], np.eye(len(free)))
        for place, column in enumerate(free):
            if (dof := int(tree.dofs[column])) in row_of and inverse[place, place] > 0.0:
                found[row_of[dof]] = 1.0 / inverse[place, place]
    return found


def tree_inertia(model: newton.Model, articulation: int, state: newton.State) -> TreeInertia:
    """Return the inertia of an articulation at the poses of its bodies in `state`."""
    import newton

    start, end = (int(array.numpy()[articulation]) for array in (model.articulation_start, model.articulation_end))
    owner = model.joint_articulation.numpy()
    joints = [joint for joint in range(start, end) if owner[joint] == articulation]
    parents, children = model.joint_parent.numpy(), model.joint_child.numpy()
    starts, axes, dims = model.joint_qd_start.numpy(), model.joint_axis.numpy(), model.joint_dof_dim.numpy()
    anchors, poses = model.joint_X_p.numpy().astype(np.float64), state.body_q.numpy().astype(np.float64)
    masses, inertias, centers = model.body_mass.numpy(), model.body_inertia.numpy(), model.body_com.numpy()
    places, coordinates = model.joint_q_start.numpy(), state.joint_q.numpy().astype(np.float64)
    kinds, kinematic = model.joint_type.numpy(), model.body_flags.numpy() & int(newton.BodyFlags.KINEMATIC)
    first = int(starts[joints[0]])
    count = int(starts[joints[-1] + 1]) - first
    prescribed = np.zeros(count, bool)
    armature = model.joint_armature.numpy()[first : first + count].astype(np.float64)
    matrix = np.diag(armature)
    # Velocities of centers of mass and angular velocities (6, D).
    motion: dict[int, np.ndarray] = {}
    momentum: dict[int, np.ndarray] = {}
    for joint in joints:
        parent, child = int(parents[joint]), int(children[joint])
        frame = _placed(poses[parent] if parent >= 0 else None, anchors[joint])
        rotation, turn = matrix_from_quat(frame[3:]), matrix_from_quat(poses[child, 3:])
        center = poses[child, :3] + centers[child].astype(np.float64) @ turn
        # What turns about the joint's frame, or about the center of a free body, which also gives its velocity.
        pivot = center if kinds[joint] == int(newton.JointType.FREE) else frame[:3]
        jacobian = np.zeros((6, count))
        if parent in motion:
            parent_turn = matrix_from_quat(poses[parent, 3:])
            arm = center - poses[parent, :3] - centers[parent].astype(np.float64) @ parent_turn
            jacobian = motion[parent].copy()
            jacobian[:3] += np.cross(jacobian[3:], arm, axis=0)
        numbers = range(int(starts[joint]), int(starts[joint + 1]))
        local = axes[numbers].astype(np.float64)
        if kinds[joint] == int(newton.JointType.D6):
            moved, sliding = coordinates[int(places[joint]) :][: len(numbers)], int(dims[joint, 0])
            pivot = pivot + moved[:sliding] @ local[:sliding] @ rotation
            local = _turned_axes(local, moved, sliding)
        for number, direction in zip(numbers, local @ rotation):
            column = number - first
            if number - int(starts[joint]) < dims[joint, 0]:
                jacobian[:3, column] = direction
            else:
                jacobian[3:, column] = direction
                jacobian[:3, column] = np.cross(direction, center - pivot)
            prescribed[column] = kinematic[child] != 0
        inertia = turn.T @ inertias[child].astype(np.float64) @ turn
        motion[child] = jacobian
        momentum[child] = np.hstack([masses[child] * jacobian[:3].T, jacobian[3:].T @ inertia])
        matrix += momentum[child] @ jacobian
    return TreeInertia(np.arange(first, first + count), prescribed, armature, matrix, motion, momentum)


def _turned_axes(axes: np.ndarray, positions: np.ndarray, sliding: int) -> np.ndarray:
    """Return the axes (D, 3) of a general joint, of which each that turns is turned by those before it."""
    from scipy.spatial.transform import Rotation

    found, turn = axes.copy(), Rotation.identity()
    for row in range(sliding, len(axes)):
        found[row] = turn.apply(axes[row])
        turn = turn * Rotation.from_rotvec(positions[row] * axes[row])
    return found


def _solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solve a symmetric system that may be singular, with its coordinates scaled to the same size."""
    scale = np.diag(1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-30)))
    return scale @ np.linalg.pinv(scale @ matrix @ scale, rcond=1e-10, hermitian=True) @ scale @ right


def _placed(parent: np.ndarray | None, frame: np.ndarray) -> np.ndarray:
    """Return the pose (7,) of a frame that is given in a parent's, or in the world."""
    if parent is None:
        return frame
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_quat(parent[3:])
    return np.concatenate([parent[:3] + turn.apply(frame[:3]), (turn * Rotation.from_quat(frame[3:])).as_quat()])
