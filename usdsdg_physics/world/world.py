"""A newton model in motion: states, forces, substeps, and writes that reach every array the solver reads."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from usdsdg_physics.corrections.depenetration import Intruders
from usdsdg_physics.corrections.sleeping import Sleepers
from usdsdg_physics.corrections.tunneling_guard import Sides
from usdsdg_physics.model.build import COLLIDES, SWITCHED_OFF, build
from usdsdg_physics.model.compile_kernels import Progress
from usdsdg_physics.scene.extents import half_thickness, world_box
from usdsdg_physics.scene.records import Scene

# A step of 1/60 s takes two substeps, the 1/320 s steps of motion blur one.
SUBSTEPS_PER_SECOND = 120.0
# A triangle mesh has no inside that would push a body back out, so near one no body may travel farther in a substep
# than this share of its half thickness, at up to this many substeps for each ordinary one.
SHEET_TRAVEL = 0.5
SHEET_SUBSTEPS = 4
SHEET_DISTANCE = 0.5  # m
# PhysX's wake counter.
REST_AFTER = 0.4  # s
# Share of the speed that gravity adds in one substep below which a body may be called quiet.
REST_SHARE_OF_GRAVITY = 0.25


class World:
    """All bodies and colliders of one scene, in SI units. Bodies and shapes are addressed by their indices."""

    def __init__(
        self, scene: Scene, *, device: str | None = None, capacity: float = 1.0, progress: Progress | None = None
    ) -> None:
        import warp as wp

        built = build(scene, device=device, capacity=capacity, progress=progress)
        self.model, self.pipeline, self.solver = built.model, built.pipeline, built.solver
        self.body_index, self.shape_index = built.body_index, built.shape_index
        self.mass, self.center = built.mass, built.center
        self.bodies = list(built.body_index)
        self.colliders = list(built.shape_index)
        self.gravity = np.asarray(scene.gravity, np.float64)
        self._state, self._next = self.model.state(), self.model.state()
        self._contacts = self.pipeline.contacts()
        self._control = self.model.control()

        bodies = list(scene.bodies.values())
        count = len(bodies)
        where = self.model.device
        self._dynamic = np.array([not body.kinematic for body in bodies], bool)
        self._gravity_on = np.array([body.gravity and not body.kinematic for body in bodies], bool)
        self._dynamic_wp = wp.array(self._dynamic.astype(np.int32), dtype=wp.int32, device=where)
        self._pulled_wp = wp.zeros(count, dtype=wp.int32, device=where)
        self._max_velocity = wp.array([b.max_velocity for b in bodies], dtype=wp.float32, device=where)
        self._max_angular = wp.array([b.max_angular_velocity for b in bodies], dtype=wp.float32, device=where)
        self._gyration = wp.array(built.gyration, dtype=wp.float32, device=where)
        self._sleep_threshold = wp.array([b.sleep_threshold for b in bodies], dtype=wp.float32, device=where)
        self._quiet = wp.zeros(count, dtype=wp.float32, device=where)
        self._sleepers = Sleepers(self.model, self._gyration, self._sleep_threshold)
        self._broken = wp.zeros(count, dtype=wp.int32, device=where)
        self._meshes = {built.shape_index[c.path]: c.shape for c in scene.colliders.values() if c.shape.kind == "mesh"}
        self._box_meshes()
        thickness = dict.fromkeys(scene.bodies, np.inf)
        for collider in scene.colliders.values():
            if collider.body:
                thickness[collider.body] = min(thickness[collider.body], half_thickness(collider.shape))
        self._thickness = np.array(list(thickness.values()))
        self._moving: dict[int, np.ndarray] = {}
        self._sides = Sides(scene, self.model, built.shape_index)
        self._intruders = Intruders(scene, self.model, built.shape_index)

        if count:
            everyone = np.arange(count)
            self.set_poses(everyone, np.array([body.pose for body in bodies]))
            self.set_velocities(everyone, np.array([[*b.velocity, *b.angular_velocity] for b in bodies]))
            self._apply_gravity()
        self.set_enabled({built.shape_index[c.path]: c.enabled for c in scene.colliders.values()})

    def poses(self) -> np.ndarray:
        """(N, 7) float32: x, y, z [m] and quaternion x, y, z, w of every body frame."""
        return self._state.joint_q.numpy().reshape(-1, 7).copy()

    def velocities(self) -> np.ndarray:
        """(N, 6) float32, world: velocity of the centre of mass [m/s], angular velocity [rad/s]."""
        return self._state.joint_qd.numpy().reshape(-1, 6).copy()

    def set_poses(self, indices: Sequence[int] | np.ndarray, poses: np.ndarray) -> None:
        """Teleport bodies; their velocities stay."""

        q = self._state.joint_q.numpy().reshape(-1, 7).copy()
        q[indices] = poses
        self._state.joint_q.assign(q.ravel())
        # The solver reads joint coordinates, the collision pipeline body poses.
        self._state.body_q.assign(q)
        self._sides.place(indices)
        self.wake(indices)

    def set_velocities(self, indices: Sequence[int] | np.ndarray, velocities: np.ndarray) -> None:
        """Set rows of `velocities()`."""

        qd = self._state.joint_qd.numpy().reshape(-1, 6).copy()
        qd[indices] = velocities
        self._state.joint_qd.assign(qd.ravel())
        self._state.body_qd.assign(qd)
        self.wake(indices)

    def wake(self, indices: Sequence[int] | np.ndarray | None = None) -> None:
        """Let bodies move again that were held at rest or put to sleep; None: all that were held at rest."""
        if indices is None:
            self._quiet.zero_()
            return
        quiet = self._quiet.numpy().copy()
        quiet[indices] = 0.0
        self._quiet.assign(quiet)
        self._sleepers.put(indices, asleep=False)

    def put_to_sleep(self, indices: Sequence[int]) -> None:
        """Take the speed of bodies and hold them where they are; kinematic ones stay as they are."""
        dynamic = [index for index in indices if self._dynamic[index]]
        if dynamic:
            self.set_velocities(dynamic, np.zeros((len(dynamic), 6)))
            self._sleepers.put(dynamic, asleep=True)

    def asleep(self) -> list[str]:
        """Paths of the bodies that sleep."""
        return [self.bodies[index] for index in self._sleepers.indices()]

    def forget_contacts(self) -> None:
        """Drop what the solver remembers of earlier contacts; after a teleport it would pull bodies back."""
        self.solver.reset(self._state)

    def set_gravity(self, gravity: Sequence[float]) -> None:
        import newton

        self.gravity = np.asarray(gravity, np.float64)
        self.model.set_gravity(tuple(gravity))
        self.solver.notify_model_changed(newton.ModelFlags.MODEL_PROPERTIES)
        self._apply_gravity()
        self.wake()

    def set_gravity_enabled(self, switched: Mapping[int, bool]) -> None:
        """Switch gravity on or off for single bodies."""
        for index, on in switched.items():
            self._gravity_on[index] = on and self._dynamic[index]
        self._apply_gravity()
        self.wake(list(switched))

    def set_damping(self, index: int, linear: float, angular: float) -> None:
        for name, damping in (("linear", linear), ("angular", angular)):
            array = getattr(self.model.steel, f"rigid_body_{name}_damping")
            values = array.numpy().copy()
            values[index] = damping
            array.assign(values)

    def set_enabled(self, switched: Mapping[int, bool]) -> None:
        """Switch colliders by shape index. The broad phase reads the group at every step, flags only when built."""
        if switched:
            groups = self.model.shape_collision_group.numpy().copy()
            self._intruders.appear([index for index, on in switched.items() if on and groups[index] == SWITCHED_OFF])
            self._intruders.vanish([index for index, on in switched.items() if not on])
            for index, on in switched.items():
                groups[index] = COLLIDES if on else SWITCHED_OFF
            self.model.shape_collision_group.assign(groups)

    def set_shape_poses(self, poses: Mapping[int, Sequence[float]]) -> None:
        """Move static colliders (7 numbers, world)."""

        transforms = self.model.shape_transform.numpy().reshape(-1, 7).copy()
        for index, pose in poses.items():
            transforms[index] = pose
        self.model.shape_transform.assign(transforms)
        if poses:
            enabled = self.model.shape_collision_group.numpy() == COLLIDES
            self._intruders.appear([index for index in poses if enabled[index]])
        for index in poses.keys() & self._meshes.keys():
            x, y, z, *rotation = poses[index]
            self._meshes[index] = replace(self._meshes[index], position=(x, y, z), rotation=tuple(rotation))
        self._box_meshes()
        self.wake()

    def move_kinematic(self, targets: Mapping[int, np.ndarray]) -> None:
        """Poses that kinematic bodies reach by the end of the next step, at constant velocity."""
        self._moving = dict(targets)
        if targets:
            self.wake()

    def step(self, dt: float) -> None:
        """Advance by `dt` seconds."""
        import warp as wp

        from usdsdg_physics.corrections.stabilization_kernels import settle

        count = self._substeps(dt)
        h = dt / count
        fall_energy = 0.5 * (REST_SHARE_OF_GRAVITY * float(np.linalg.norm(self.gravity)) * h) ** 2
        paths = self._kinematic_paths(dt)
        for substep in range(count):
            self._place_kinematic(paths, substep / count)
            self.pipeline.collide(self._state, self._contacts)
            self._sides.apply(self._contacts, self._state)
            if self._intruders.any:
                self._intruders.push(self._contacts, self._state)
            self._sleepers.rouse(self._contacts, self._state, h)
            self.solver.step(self._state, self._next, self._control, self._contacts, h)
            wp.launch(
                settle,
                dim=len(self.bodies),
                inputs=[
                    self._dynamic_wp,
                    self._pulled_wp,
                    self._gyration,
                    self._sleep_threshold,
                    self._sleepers.asleep,
                    self._max_velocity,
                    self._max_angular,
                    self._state.body_q,
                    h,
                    fall_energy,
                    REST_AFTER,
                ],
                outputs=[
                    self._next.joint_q,
                    self._next.joint_qd,
                    self._next.body_q,
                    self._next.body_qd,
                    self._quiet,
                    self._broken,
                ],
                device=self.model.device,
            )
            if self._intruders.any:
                self._intruders.calm(self._state, self._next, h)
            self._state, self._next = self._next, self._state
        self._place_kinematic(paths, 1.0)
        self._stop_kinematic()

    @property
    def lost_contacts(self) -> bool:
        """Whether a step met more contacts than there was room for, so that bodies may have passed into each other."""
        # The count stops at the room that there is.
        found = int(self._contacts.rigid_contact_count.numpy()[0])
        return found >= self.pipeline.rigid_contact_max or bool(self.solver.constraint_overflow.numpy().any())

    def take_broken(self) -> list[str]:
        """Paths of bodies whose step was taken back because it was not finite, since the last call."""
        broken = np.flatnonzero(self._broken.numpy())
        if len(broken):
            self._broken.zero_()
        return [self.bodies[index] for index in broken]

    def _box_meshes(self) -> None:
        """Boxes (M, 2, 3) around the static triangle meshes."""
        self._sheets = np.array([world_box(shape) for shape in self._meshes.values()]).reshape(-1, 2, 3)

    def _substeps(self, dt: float) -> int:
        count = max(1, math.ceil(dt * SUBSTEPS_PER_SECOND - 1e-6))
        if not len(self._sheets) or not self.bodies:
            return count
        at = self.poses()[:, None, :3]
        near = ((at > self._sheets[:, 0] - SHEET_DISTANCE) & (at < self._sheets[:, 1] + SHEET_DISTANCE)).all(axis=2)
        travel = np.linalg.norm(self.velocities()[:, :3], axis=1) * dt
        needed = np.where(near.any(axis=1), np.nan_to_num(travel / (SHEET_TRAVEL * self._thickness)), 0.0).max()
        return int(np.clip(np.ceil(needed), count, count * SHEET_SUBSTEPS))

    def _apply_gravity(self) -> None:
        """Bodies without gravity get the opposite force; it stays in both states, which nobody clears."""

        force = np.zeros((len(self.bodies), 6), np.float32)
        weightless = ~self._gravity_on & self._dynamic
        force[weightless, :3] = -self.mass[weightless, None] * self.gravity
        for state in (self._state, self._next):
            state.body_f.assign(force)
        self._pulled_wp.assign(self._gravity_on.astype(np.int32))

    def _kinematic_paths(self, dt: float) -> dict[int, Callable[[float], np.ndarray]]:
        if not self._moving:
            return {}
        poses = self.poses().astype(np.float64)
        indices = sorted(self._moving)
        paths, velocities = {}, np.zeros((len(indices), 6))
        for row, index in enumerate(indices):
            paths[index], velocities[row] = _screw(poses[index], self._moving[index], self.center[index], dt)
        self.set_velocities(indices, velocities)
        return paths

    def _place_kinematic(self, paths: Mapping[int, Callable[[float], np.ndarray]], share: float) -> None:
        if paths:
            self.set_poses(list(paths), np.array([path(share) for path in paths.values()]))

    def _stop_kinematic(self) -> None:
        if self._moving:
            indices = sorted(self._moving)
            self.set_velocities(indices, np.zeros((len(indices), 6)))
            self._moving = {}


def _screw(
    start: np.ndarray, end: np.ndarray, center: np.ndarray, dt: float
) -> tuple[Callable[[float], np.ndarray], np.ndarray]:
    """The motion between two poses at constant velocity: its pose at a share of the way, and its velocity (6,)."""
    from scipy.spatial.transform import Rotation

    first, last = Rotation.from_quat(start[3:]), Rotation.from_quat(end[3:])
    turn = (last * first.inv()).as_rotvec()
    from_center, to_center = start[:3] + first.apply(center), end[:3] + last.apply(center)

    def pose(share: float) -> np.ndarray:
        rotation = Rotation.from_rotvec(share * turn) * first
        at = from_center + share * (to_center - from_center) - rotation.apply(center)
        return np.concatenate([at, rotation.as_quat()])

    return pose, np.concatenate([(to_center - from_center) / dt, turn / dt])
