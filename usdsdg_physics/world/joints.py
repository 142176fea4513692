"""The joints of a world: coordinates from poses of bodies and back, drives, efforts."""

# Newton declares the arrays of models and states optional; after `finalize` all are there.
# pyright: reportOptionalMemberAccess=false, reportArgumentType=false

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.errors import warn_once
from usdsdg.stage.poses.rotations import rotated
from usdsdg_physics.model.joint_inertia import axis_inertias, tree_inertia
from usdsdg_physics.model.joints import BuiltJoints, measured_drift
from usdsdg_physics.scene.records import STATIC, Drive, Scene
from usdsdg_physics.world.continued import AxisKey

if TYPE_CHECKING:
    import newton
    import warp as wp

# Inertia counts as the same while joints move by less than this [rad, m].
SAME_INERTIA = 0.02
# Frames of a joint that are farther apart than this at the start are named [m].
MAX_DRIFT = 1e-3


class Joints:
    """Reads and sets the joint coordinates of the articulated bodies of a model, by the rows of `axes`.

    The solver moves joint coordinates; the poses and velocities of links follow from them.
    """

    def __init__(self, scene: Scene, model: newton.Model, control: newton.Control, built: BuiltJoints) -> None:
        import warp as wp

        self._scene, self._model, self._control, self._built = scene, model, control, built
        self.axes = built.axes
        self.rows = {(axis.joint, axis.axis.name): row for row, axis in enumerate(built.axes)}
        self._articulations = wp.array(built.articulations, dtype=wp.int32, device=model.device)
        self._coordinates = np.array([axis.coordinate for axis in built.axes], np.int64)
        self._dofs = np.array([axis.dof for axis in built.axes], np.int64)
        self._turning = np.array([axis.axis.angular for axis in built.axes], bool)
        self._pushed = False
        self._drives = {row: axis.axis.drive for row, axis in enumerate(built.axes) if axis.axis.drive is not None}
        # By tree: the joint coordinates for which its drives of accelerations have the strength that they need.
        self._strength_at: dict[int, np.ndarray] = {}

    def start(self, state: newton.State, near: Mapping[AxisKey, float]) -> None:
        """Take coordinates from the poses and velocities of bodies, or from what joints start with.

        Of angles that differ by whole turns those count that are nearest to `near`, 0 by default.
        """
        apart = []
        for number, tree in enumerate(self._built.trees):
            joint, distance = measured_drift(tree, {path: body.pose for path, body in self._scene.bodies.items()})
            if distance > MAX_DRIFT:
                apart.append(number)
                warn_once(
                    f"{joint}: its frames are {distance:.3g} m apart, so its bodies jump together. Author poses of the "
                    "bodies, or physics:localPos0 and physics:localPos1, that meet."
                )
        self._begin_within_limits(state, near)
        self.measure(state)
        self._center(state, apart)
        positions = {key: self.axes[row].axis.position for key, row in self.rows.items()}
        velocities = {key: self.axes[row].axis.velocity for key, row in self.rows.items()}
        self.set_state(
            state,
            {key: value for key, value in positions.items() if value is not None},
            {key: value for key, value in velocities.items() if value is not None},
        )
        self._engage_gears(state)
        self._write_drives(self._drives, state)

    def _begin_within_limits(self, state: newton.State, near: Mapping[AxisKey, float]) -> None:
        """Set all axes to what is given, or to 0, or to the limit that is nearest to it."""
        coordinates = state.joint_q.numpy().copy()
        limits = np.array([(axis.axis.lower, axis.axis.upper) for axis in self.axes]).reshape(-1, 2)
        usual = np.clip(0.0, *limits.T).tolist()
        coordinates[self._coordinates] = [
            near.get((axis.joint, axis.axis.name), usual[row]) for row, axis in enumerate(self.axes)
        ]
        state.joint_q.assign(coordinates)

    def _center(self, state: newton.State, trees: Iterable[int]) -> None:
        """Move floating trees whose links jumped together to where the stage has their centers of mass."""
        mass, centers = self._model.body_mass.numpy(), self._model.body_com.numpy()
        coordinates, now = state.joint_q.numpy().copy(), state.body_q.numpy()
        before = np.array([body.pose for body in self._scene.bodies.values()])
        row_of, moved = {path: row for row, path in enumerate(self._scene.bodies)}, []
        for tree in (self._built.trees[number] for number in trees):
            if not tree.root or self._scene.bodies[tree.root].kinematic:
                continue
            rows = [row_of[path] for path in tree.bodies]
            ends = [poses[rows, :3] + rotated(poses[rows, 3:], centers[rows]) for poses in (before, now)]
            start, _ = self._built.bases[tree.root]
            coordinates[start : start + 3] += mass[rows] @ (ends[0] - ends[1]) / mass[rows].sum()
            moved.append(self._built.links[tree.root])
        if moved:
            state.joint_q.assign(coordinates)
            self.place(state, moved)

    def measure(self, state: newton.State, trees: Sequence[int] | None = None) -> None:
        """Take the positions of trees (None: all) from the poses of their bodies; then place these."""
        import newton
        import warp as wp

        speeds, before = wp.clone(state.joint_qd), self.positions(state)
        newton.eval_ik(self._model, state, state.joint_q, speeds, indices=self._of(trees))
        self._unwind(state, before)
        self.place(state, trees)

    def _unwind(self, state: newton.State, before: np.ndarray) -> None:
        """Take whole turns from angles, of which poses know nothing: those nearest to `before` (A,) are right."""
        measured = self.positions(state)
        turns = np.where(self._turning, np.round((measured - before) / (2.0 * np.pi)), 0.0)
        if turns.any():
            coordinates = state.joint_q.numpy().copy()
            coordinates[self._coordinates] = measured - turns * 2.0 * np.pi
            state.joint_q.assign(coordinates)

    def place(self, state: newton.State, trees: Sequence[int] | None = None) -> None:
        """Place the bodies of trees (None: all) by their coordinates."""
        import newton

        newton.eval_fk(self._model, state.joint_q, state.joint_qd, state, indices=self._of(trees))

    def teleport(self, state: newton.State, poses: Mapping[str, np.ndarray]) -> None:
        """Follow bodies that were put to new poses (7,), by path; those that are no links do not matter.

        A base takes all other links along. Without it, or with every link, coordinates follow from the poses.
        """
        self._fix_bases(poses)
        coordinates, moved = state.joint_q.numpy().copy(), False
        for path, (start, _) in self._built.bases.items():
            if path in poses:
                coordinates[start : start + 7], moved = poses[path], True
        if moved:
            state.joint_q.assign(coordinates)
        self._follow(state, poses)

    def push(self, state: newton.State, velocities: Mapping[str, np.ndarray]) -> None:
        """Follow bodies that got new velocities (6,), by path, which `state` has already.

        As in PhysX, the floating base of an articulation takes all other links along. A kinematic base leaves them
        their momentum. Otherwise coordinates get the velocities that have the momentum of all bodies.
        """
        trees = self._trees_of(velocities)
        if not trees:
            return
        speeds, bodies = state.joint_qd.numpy().copy(), state.body_qd.numpy().astype(np.float64)
        for tree in trees:
            inertia = tree_inertia(self._model, self._built.articulations[tree], state)
            for path, (_, start) in self._built.bases.items():
                if path in velocities and self._built.links[path] == tree:
                    speeds[start : start + 6] = velocities[path]
            carried = self._is_articulated(tree) and self._is_carried(tree, self._told(tree, velocities))
            if inertia.prescribed.any() or not carried:
                speeds[inertia.dofs] = inertia.projected(bodies, speeds[inertia.dofs])
        state.joint_qd.assign(speeds)
        self.place(state, trees)

    def _told(self, tree: int, velocities: Mapping[str, np.ndarray]) -> set[str]:
        """Return the bodies of a tree that got velocities; where all did, as at the start, those that move."""
        bodies = self._built.trees[tree].bodies
        told = {path for path in bodies if path in velocities}
        return told if len(told) < len(bodies) else {path for path in told if np.any(velocities[path])}

    def _is_articulated(self, tree: int) -> bool:
        return any(branch.joint.articulated for branch in self._built.trees[tree].branches)

    def _trees_of(self, changed: Collection[str]) -> list[int]:
        return sorted({self._built.links[path] for path in changed if path in self._built.links})

    def _follow(self, state: newton.State, changed: Collection[str]) -> None:
        trees = self._trees_of(changed)
        carried = [tree for tree in trees if self._is_carried(tree, changed)]
        if measured := [tree for tree in trees if tree not in carried]:
            self.measure(state, measured)
        if carried:
            self.place(state, carried)

    def _is_carried(self, tree: int, changed: Collection[str]) -> bool:
        """Return whether the base of a tree is among the bodies that changed, and not all others too."""
        bodies = self._built.trees[tree].bodies
        return any(
            path in changed for path in bodies if path in self._built.bases or path in self._built.fixed_bases
        ) and (len(bodies) == 1 or not all(path in changed for path in bodies))

    def _fix_bases(self, poses: Mapping[str, np.ndarray]) -> None:
        """Fix bases to the world at new poses (7,), by path."""
        import warp as wp

        bases = {path: index for path, index in self._built.fixed_bases.items() if path in poses}
        if not bases:
            return
        anchors = self._model.joint_X_p.numpy().copy()
        children = self._model.joint_X_c.numpy()
        for path, index in bases.items():
            anchors[index] = np.array(wp.transform(*poses[path].tolist()) * wp.transform(*children[index].tolist()))
        self._model.joint_X_p.assign(anchors)

    def positions(self, state: newton.State) -> np.ndarray:
        """Return the positions (A,) float64 of all axes [m, rad]."""
        return state.joint_q.numpy()[self._coordinates].astype(np.float64)

    def positions_by_axis(self, state: newton.State) -> dict[AxisKey, float]:
        """Return the positions of all axes [m, rad]."""
        positions = self.positions(state).tolist()
        return {key: positions[row] for key, row in self.rows.items()}

    def velocities(self, state: newton.State) -> np.ndarray:
        """Return the velocities (A,) float64 of all axes [m/s, rad/s]."""
        return state.joint_qd.numpy()[self._dofs].astype(np.float64)

    def set_state(
        self, state: newton.State, positions: Mapping[AxisKey, float], velocities: Mapping[AxisKey, float]
    ) -> None:
        """Move axes at once, and set their velocities; bodies follow. Axes that close loops have neither."""
        trees = set()
        for values, array, index in (
            (positions, state.joint_q, self._coordinates),
            (velocities, state.joint_qd, self._dofs),
        ):
            rows = {self.rows[key]: value for key, value in values.items() if key in self.rows}
            if rows:
                numbers = array.numpy().copy()
                numbers[index[list(rows)]] = list(rows.values())
                array.assign(numbers)
                trees |= {self._tree(row) for row in rows}
        if trees:
            self.place(state, sorted(trees))

    def set_drives(self, drives: Mapping[AxisKey, Drive], state: newton.State) -> None:
        """Replace drives."""
        changed = {self.rows[key]: drive for key, drive in drives.items() if key in self.rows}
        self._drives |= changed
        self._write_drives(changed, state)

    def follow_inertia(self, state: newton.State) -> None:
        """Give drives of accelerations the strength that the inertia of their axes needs where they are now."""
        if not self._strength_at:
            return
        coordinates, rows = state.joint_q.numpy(), self._accelerating()
        moved = [
            tree
            for tree, before in self._strength_at.items()
            if np.abs(coordinates[self._coordinates_of(tree)] - before).max(initial=0.0) > SAME_INERTIA
        ]
        if moved:
            self._write_drives({row: self._drives[row] for row in rows if self._tree(row) in moved}, state)

    def _accelerating(self) -> list[int]:
        return [row for row, drive in self._drives.items() if drive.acceleration]

    def _coordinates_of(self, tree: int) -> slice:
        """Return where the coordinates of a tree's joints are in joint_q, without those of its base."""
        begin, end, _, _ = self._built.ranges[tree]
        return slice(begin + 7 * (self._built.trees[tree].root != STATIC), end)

    def add_efforts(self, efforts: Mapping[AxisKey, float]) -> None:
        """Push axes during the next step [N, N m]; efforts add up."""
        force = self._control.joint_f.numpy().copy()
        for key, effort in efforts.items():
            if key in self.rows:
                force[self._dofs[self.rows[key]]] += effort
        self._control.joint_f.assign(force)
        self._pushed = True

    def efforts(self) -> dict[AxisKey, float]:
        """Return what pushes axes during the next step [N, N m]."""
        force = self._control.joint_f.numpy() if self._pushed else np.zeros(0)
        return {key: float(force[self._dofs[row]]) for key, row in self.rows.items()} if self._pushed else {}

    def clear_efforts(self) -> None:
        """Push no axis any more."""
        if self._pushed:
            self._control.joint_f.zero_()
            self._pushed = False

    def _write_drives(self, drives: Mapping[int, Drive], state: newton.State) -> None:
        """Write drives to the model, by row; those per mass are scaled by the inertia that their axis moves now."""
        if not drives:
            return
        trees = {self._tree(row) for row, drive in drives.items() if drive.acceleration}
        inertia = axis_inertias(self._model, self._built, state, trees)
        coordinates = state.joint_q.numpy()
        self._strength_at |= {tree: coordinates[self._coordinates_of(tree)].copy() for tree in trees}
        arrays = {
            name: getattr(owner, name).numpy().copy()
            for name, owner in (
                ("joint_target_ke", self._model),
                ("joint_target_kd", self._model),
                ("joint_effort_limit", self._model),
                ("joint_target_q", self._control),
                ("joint_target_qd", self._control),
            )
        }
        for row, drive in drives.items():
            dof, scale = self._dofs[row], inertia.get(row, 1.0) if drive.acceleration else 1.0
            # To the solver a limit of zero is none.
            strength = scale if drive.max_force > 0.0 else 0.0
            arrays["joint_target_ke"][dof] = drive.stiffness * strength
            arrays["joint_target_kd"][dof] = drive.damping * strength
            arrays["joint_effort_limit"][dof] = drive.max_force
            arrays["joint_target_qd"][dof] = drive.target_velocity
            arrays["joint_target_q"][self._coordinates[row]] = drive.target
        for name, numbers in arrays.items():
            getattr(self._control if name.startswith("joint_target_q") else self._model, name).assign(numbers)

    def _engage_gears(self, state: newton.State) -> None:
        """Let joints in gear follow from where they are."""
        if not self._built.in_gear:
            return
        coefficients = self._model.joint_mimic_coeffs.numpy().copy()
        rows = {axis.joint: row for row, axis in enumerate(self.axes)}
        positions = self.positions(state)
        for path, leader, gearing in self._built.in_gear:
            offset = positions[rows[path]] - gearing * positions[rows[leader]]
            coefficients[self._built.joint_of[path]] = offset, gearing
        self._model.joint_mimic_coeffs.assign(coefficients)

    def _tree(self, row: int) -> int:
        """Return the number of the tree that an axis belongs to."""
        joint = self._scene.joints[self.axes[row].joint]
        return self._built.links[joint.body1 if joint.body1 in self._built.links else joint.body0]

    def _of(self, trees: Sequence[int] | None) -> wp.array:
        import warp as wp

        if trees is None:
            return self._articulations
        chosen = [self._built.articulations[tree] for tree in trees]
        return wp.array(chosen, dtype=wp.int32, device=self._model.device)
