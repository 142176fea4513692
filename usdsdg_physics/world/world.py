"""A Newton model in motion: states, forces, substeps, and setters that reach every array the solver reads."""

# Newton declares the arrays of models and states optional; after `finalize` all are there.
# pyright: reportOptionalMemberAccess=false, reportArgumentType=false

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.corrections.bodies.stabilization import REST_DELAY
from usdsdg_physics.corrections.contacts.contact_report import ContactRows
from usdsdg_physics.model.build import (
    COLLIDES,
    DISABLED,
    build_model,
    build_pipeline,
    build_solver,
    distance_joints,
    enable_surface_velocities,
)
from usdsdg_physics.scene.loop_cuts import cut_loops
from usdsdg_physics.scene.records import Drive, Force, Scene, SurfaceVelocity
from usdsdg_physics.world.compile_kernels import Progress, load_kernels, prepare_newton
from usdsdg_physics.world.halves import Halves
from usdsdg_physics.world.joints import Joints
from usdsdg_physics.world.kinematic_motion import KinematicMotion
from usdsdg_physics.world.static_motion import StaticMotion
from usdsdg_physics.world.steady_forces import SteadyForces
from usdsdg_physics.world.step_corrections import StepCorrections, StepKind
from usdsdg_physics.world.step_launches import StepLaunches
from usdsdg_physics.world.substeps import Substeps

if TYPE_CHECKING:
    import warp as wp


# Kinetic energy per mass [m²/s²] below which a body rests: that of 1 mm/s.
REST_ENERGY = 5e-7


class World:
    """All bodies and colliders of one scene, in SI units. Bodies and shapes are addressed by their indices."""

    def __init__(
        self, scene: Scene, *, device: str | None = None, capacity: float = 1.0, progress: Progress | None = None
    ) -> None:
        """Build the model and its solver.

        Args:
            device: "cpu", "cuda:0" or None for Warp's default.
            capacity: factor on the usual capacity of the contact and constraint buffers.
            progress: hears about kernels being compiled.
        """
        prepare_newton()
        scene = cut_loops(scene)
        built = build_model(scene, device=device)
        self.model = built.model
        extra_contacts = 2 * len(distance_joints(scene))
        self.pipeline = build_pipeline(self.model, capacity=capacity, extra=extra_contacts)
        load_kernels(self.pipeline, progress=progress)
        self.solver = build_solver(built, self.pipeline, capacity=capacity)
        self.solver.restitution_velocity_threshold = scene.bounce_threshold
        self.body_index, self.shape_index = built.body_index, built.shape_index
        self.mass, self.center = built.mass, built.center
        self._halves = Halves(scene, built.body_index)
        self.bodies = self._halves.bodies
        self._paths = list(built.body_index)
        self._inertia_per_mass = built.inertia_per_mass
        self.gravity = np.asarray(scene.gravity, np.float64)
        self._state, self._next = states = self.model.state(), self.model.state()
        self._contacts = self.pipeline.contacts()
        control = self.model.control()
        self.joints = Joints(scene, self.model, control, built.joints) if built.joints.trees else None
        self._coordinate, self._dof = built.coordinate, built.dof

        bodies = list(scene.bodies.values())
        self._dynamic = np.array([not body.kinematic for body in bodies], bool)
        self._gravity_enabled = np.array([body.gravity and not body.kinematic for body in bodies], bool)
        self._kinematic = KinematicMotion(self.model, built.center, built.pose_coordinate)
        self._wrenches: np.ndarray | None = None  # (N, 6) of the next step
        self._static_motion = StaticMotion(scene, built.shape_index)
        self._corrections = StepCorrections(scene, built, self._contacts)
        self._corrections.stabilization.set_gravity(self.gravity)
        self._breakable = built.joints.breakable
        jointed = self.joints is not None or self._corrections.distances is not None
        self._substeps = Substeps(scene, self.model, built.shape_index, jointed=jointed)
        self._launches = StepLaunches(
            states,
            control,
            self._contacts,
            pipeline=self.pipeline,
            solver=self.solver,
            corrections=self._corrections,
            kinematic=self._kinematic,
            joints=self.joints,
            extra_contacts=extra_contacts,
        )
        if any(body.surface for body in bodies):
            self._add_surfaces()
        parts = self._halves.parts
        self._forces = SteadyForces(
            built.body_index, built.mass * parts, built.center, built.inertia * parts[:, None, None]
        )
        self._forces.set(scene.forces.values())
        self._latest_substeps = 0
        self._triggers = {built.shape_index[c.path] for c in scene.colliders.values() if c.trigger}

        if self.model.device.is_cuda and bodies:
            self._launches.load_kernels(progress)
        if bodies:
            indices = np.arange(len(bodies))
            self.set_poses(indices, np.array([body.pose for body in bodies]))
            self.set_velocities(indices, np.array([[*b.velocity, *b.angular_velocity] for b in bodies]))
            if self.joints is not None:
                self.joints.start(self._state)
            self._apply_gravity()
        self.set_colliders_enabled({built.shape_index[c.path]: c.enabled for c in scene.colliders.values()})

    def poses(self) -> np.ndarray:
        """Return (N, 7) float32: x, y, z [m] and quaternion x, y, z, w of every body frame."""
        return self._all_poses()[: len(self.bodies)]

    def velocities(self) -> np.ndarray:
        """Return (N, 6) float32, world: velocity of the center of mass [m/s], angular velocity [rad/s]."""
        return self._all_velocities()[: len(self.bodies)]

    def set_poses(self, indices: Sequence[int] | np.ndarray, poses: np.ndarray) -> None:
        """Teleport bodies; their velocities stay."""
        q = self._all_poses()
        q[indices] = poses
        indices = self._halves.follow(q, indices)
        # The solver reads joint coordinates, the collision pipeline body poses.
        self._state.body_q.assign(q)
        _assign_rows(self._state.joint_q, self._coordinate, q)
        if self.joints is not None:
            self.joints.teleport(self._state, {self._paths[index]: q[index] for index in indices})
        self._corrections.tunneling_guard.mark_teleported(indices)
        self.wake(indices)

    def set_velocities(self, indices: Sequence[int] | np.ndarray, velocities: np.ndarray) -> None:
        """Set rows of `velocities()`."""
        qd = self._all_velocities()
        qd[indices] = velocities
        indices = self._halves.follow(qd, indices)
        self._state.body_qd.assign(qd)
        _assign_rows(self._state.joint_qd, self._dof, qd)
        if self.joints is not None:
            self.joints.push(self._state, {self._paths[index]: qd[index] for index in indices})
        self.wake(indices)

    def set_drives(self, drives: Mapping[tuple[str, str], Drive]) -> None:
        """Replace drives, by path of the joint and name of the axis; those of joints that close loops do not act."""
        if self.joints is not None:
            self.joints.set_drives(drives, self._state)
            self.wake()

    def joint_state(self, axes: Sequence[tuple[str, str]]) -> tuple[np.ndarray, np.ndarray]:
        """Return positions and velocities (n,) of axes, by path of the joint and name of the axis [m, rad].

        Those of joints that close loops are zeros.
        """
        state = np.zeros((2, len(axes)))
        if self.joints is not None:
            rows = [self.joints.rows.get(key, -1) for key in axes]
            found = np.array(rows) >= 0
            both = self.joints.positions(self._state), self.joints.velocities(self._state)
            for values, all_values in zip(state, both):
                values[found] = all_values[np.array(rows)[found]]
        return state[0], state[1]

    def add_joint_efforts(self, efforts: Mapping[tuple[str, str], float]) -> None:
        """Push axes during the next step [N, N m]; efforts add up."""
        if self.joints is not None:
            self.joints.add_efforts(efforts)
            self.wake()

    def set_joint_state(
        self, positions: Mapping[tuple[str, str], float], velocities: Mapping[tuple[str, str], float]
    ) -> None:
        """Move axes at once [m, rad], and set their velocities, by path of the joint and name of the axis."""
        if self.joints is not None:
            self.joints.set_state(self._state, positions, velocities)
            self.wake()

    def wake(self, indices: Sequence[int] | np.ndarray | None = None) -> None:
        """Let bodies move again that are held at rest or asleep; None: all that are held at rest."""
        self._corrections.stabilization.wake(indices)
        self._substeps.forget_rest()
        if indices is not None:
            self._corrections.sleeping.set_asleep(indices, False)

    def put_to_sleep(self, indices: Sequence[int]) -> None:
        """Zero the velocities of bodies and hold them where they are; kinematic ones stay as they are."""
        dynamic = [index for index in indices if self._dynamic[index]]
        if dynamic:
            self.set_velocities(dynamic, np.zeros((len(dynamic), 6)))
            self._corrections.sleeping.set_asleep(dynamic, True)

    def asleep(self) -> list[str]:
        """Return the paths of the bodies that are asleep."""
        return [self.bodies[index] for index in self._corrections.sleeping.indices()]

    def discard_contact_history(self) -> None:
        """Discard warm-start impulses and friction anchors; after a teleport they would pull bodies back."""
        self.solver.reset(self._state)

    def set_gravity(self, gravity: Sequence[float]) -> None:
        """Set the scene's gravity (3,) [m/s²]."""
        import newton

        self.gravity = np.asarray(gravity, np.float64)
        x, y, z = gravity
        self.model.set_gravity((x, y, z))
        self.solver.notify_model_changed(newton.ModelFlags.MODEL_PROPERTIES)
        self._corrections.stabilization.set_gravity(self.gravity)
        self._apply_gravity()
        self.wake()

    def set_gravity_enabled(self, enabled: Mapping[int, bool]) -> None:
        """Switch gravity on or off for single bodies."""
        for index, on in enabled.items():
            self._gravity_enabled[self._halves.whole == index] = on and self._dynamic[index]
        self._apply_gravity()
        self.wake(list(enabled))

    def set_damping(self, index: int, linear: float, angular: float) -> None:
        """Set the damping of one body [1/s]."""
        for name, damping in (("linear", linear), ("angular", angular)):
            array = getattr(self.model.steel, f"rigid_body_{name}_damping")
            values = array.numpy().copy()
            values[: len(self._halves)][self._halves.whole == index] = damping
            array.assign(values)

    def set_least_damping(self, scene: Scene, damping: float) -> None:
        """Give every body at least this linear and angular damping [1/s], or its own where that is more."""
        bodies = scene.bodies.values()
        for name, own in (
            ("linear", [body.linear_damping for body in bodies]),
            ("angular", [body.angular_damping for body in bodies]),
        ):
            getattr(self.model.steel, f"rigid_body_{name}_damping").assign(
                np.maximum(own, damping).astype(np.float32)[self._halves.whole]
            )

    def stop_bodies(self) -> None:
        """Zero the velocities of all bodies but kinematic ones."""
        dynamic = np.flatnonzero(self._dynamic[: len(self.bodies)])
        self.set_velocities(dynamic, np.zeros((len(dynamic), 6)))

    def moving(self) -> list[str]:
        """Return the paths of the bodies that are faster than 1 mm/s, or turn as fast."""
        velocities = self.velocities().astype(np.float64)
        energy = 0.5 * (velocities[:, :3] ** 2).sum(axis=1)
        count = len(self.bodies)
        energy += 0.5 * self._inertia_per_mass[:count] * (velocities[:, 3:] ** 2).sum(axis=1)
        return [self.bodies[index] for index in np.flatnonzero(self._dynamic[:count] & (energy > REST_ENERGY))]

    def add_wrenches(self, indices: Sequence[int] | np.ndarray, wrenches: np.ndarray) -> None:
        """Push bodies during the next step: force [N] and torque about the center of mass [N m] (n, 6), world.

        Wrenches add up; kinematic bodies have none.
        """
        if self._wrenches is None:
            self._wrenches = np.zeros((len(self._halves), 6))
        np.add.at(self._wrenches, indices, wrenches)
        self._wrenches[~self._dynamic] = 0.0
        self.wake(indices)

    def set_colliders_enabled(self, enabled: Mapping[int, bool]) -> None:
        """Switch colliders on or off, by shape index."""
        # The broad phase reads the collision group at every step, the shape's flags only when it is built.
        if enabled:
            groups = self.model.shape_collision_group.numpy().copy()
            self._corrections.depenetration.activate(
                [index for index, on in enabled.items() if on and groups[index] == DISABLED]
            )
            self._corrections.depenetration.deactivate([index for index, on in enabled.items() if not on])
            for index, on in enabled.items():
                groups[index] = COLLIDES if on and index not in self._triggers else DISABLED
            self.model.shape_collision_group.assign(groups)

    def set_shape_poses(self, poses: Mapping[int, Sequence[float]]) -> None:
        """Move static colliders, by shape index (7 numbers, world)."""
        transforms = self.model.shape_transform.numpy().reshape(-1, 7).copy()
        for index, pose in poses.items():
            self._static_motion.note(index, transforms[index], np.asarray(pose))
            transforms[index] = pose
        self.model.shape_transform.assign(transforms)
        if poses:
            enabled = self.model.shape_collision_group.numpy() == COLLIDES
            self._corrections.depenetration.activate([index for index in poses if enabled[index]])
        self._substeps.set_static_poses(poses)
        self.wake()

    def set_surfaces(self, surfaces: Mapping[int, SurfaceVelocity | None]) -> None:
        """Set the velocities of the surfaces of bodies."""
        if self._corrections.surfaces is not None and surfaces:
            self._corrections.surfaces.set_velocities(surfaces)
            self.wake()

    def set_forces(self, forces: Iterable[Force]) -> None:
        """Set the forces that act at every step."""
        self._forces.set(forces)

    def set_kinematic_targets(self, targets: Mapping[int, np.ndarray]) -> None:
        """Set the poses (7,) that kinematic bodies reach by the end of the next step, at constant velocity."""
        self._kinematic.set_targets(targets)
        if targets:
            self.wake()

    def add_kinematic_targets(self, targets: Mapping[int, np.ndarray]) -> None:
        """Set the targets of further kinematic bodies."""
        self._kinematic.add_targets(targets)
        if targets:
            self.wake()

    def step(self, dt: float) -> None:
        """Advance by `dt` seconds."""
        moving = self._kinematic.bodies
        kind = StepKind(
            dt,
            self._substeps_of(dt),
            bool(moving),
            self._corrections.depenetration.active,
            self._corrections.sleeping.any,
        )
        targets = np.zeros((0, 7))
        if moving:
            targets, velocities = self._kinematic.begin(self.poses(), dt, kind.substeps)
            self.set_velocities(moving, velocities)
        if self._corrections.report is not None and self._corrections.report.reserve(kind.substeps):
            self._launches.forget()
        self._latest_substeps = kind.substeps
        self._move_surfaces(dt)
        if self._forces:
            self.add_wrenches(*self._forces.wrenches(self.poses()))
        if self._wrenches is not None:
            self._set_forces(self._wrenches)

        self._launches.run(kind)

        if self._wrenches is not None:
            self._wrenches = None
            self._set_forces()
        if self.joints is not None:
            self.joints.clear_efforts()
        if moving:
            self.set_poses(moving, targets)
            self.set_velocities(moving, np.zeros((len(moving), 6)))
            self._kinematic.clear()
        if kind.depenetrates:
            self._corrections.depenetration.finish()
        if kind.has_sleepers:
            self._corrections.sleeping.finish()

    def _move_surfaces(self, dt: float) -> None:
        """Let static colliders that move carry what they touch during a step of `dt` seconds."""
        motion = self._static_motion.take(dt)
        if motion and self._corrections.surfaces is None:
            self._add_surfaces()
        if self._corrections.surfaces is not None:
            self._corrections.surfaces.set_motion(motion)

    def _add_surfaces(self) -> None:
        self._corrections.add_surfaces()
        enable_surface_velocities(self.solver)
        self._launches.forget()

    def reported_contacts(self) -> list[ContactRows]:
        """Return the contacts of the latest step whose shapes are reported, by substep."""
        return [] if self._corrections.report is None else self._corrections.report.rows(self._latest_substeps)

    @property
    def contacts_overflowed(self) -> bool:
        """Whether a step had more contacts than the buffers hold, so that bodies may have passed into each other."""
        # The count stops at the capacity.
        found = int(self._contacts.rigid_contact_count.numpy()[0])
        return found >= self.pipeline.rigid_contact_max or bool(self.solver.constraint_overflow.numpy().any())

    def broken_joints(self) -> list[str]:
        """Return the paths of the joints that have borne more than they can since the world was built."""
        found = [] if self._corrections.distances is None else self._corrections.distances.broken()
        if self._corrections.loads is not None and self._breakable:
            found += [self._breakable[row][0] for row in self._corrections.loads.broken()]
        return found

    def take_nonfinite(self) -> list[str]:
        """Return the paths of bodies with a step, since the last call, that was reverted because it was not finite."""
        found = dict.fromkeys(
            int(self._halves.whole[index]) for index in self._corrections.stabilization.take_nonfinite()
        )
        return [self.bodies[index] for index in found]

    def _all_poses(self) -> np.ndarray:
        """Return `poses`, with those of halves."""
        return self._state.body_q.numpy().reshape(-1, 7).copy()

    def _all_velocities(self) -> np.ndarray:
        """Return `velocities`, with those of halves."""
        return self._state.body_qd.numpy().reshape(-1, 6).copy()

    def _substeps_of(self, dt: float) -> int:
        """Return how many substeps the next step takes, of `dt` seconds."""
        if not self._substeps.vary:
            return self._substeps.least(dt)
        held = self._corrections.stabilization.rest_time.numpy() >= REST_DELAY
        pushed = bool(self._kinematic.bodies) or self._wrenches is not None or bool(self._forces)
        return self._substeps.of_step(dt, self._all_poses(), self._all_velocities(), held=held, is_pushed=pushed)

    def _apply_gravity(self) -> None:
        self._set_forces()
        self._corrections.stabilization.set_gravity_enabled(self._gravity_enabled)

    def _set_forces(self, wrenches: np.ndarray | None = None) -> None:
        """Give bodies without gravity the opposite force, and all their `wrenches`; both states keep them."""
        force = np.zeros((len(self._halves), 6)) if wrenches is None else wrenches.copy()
        weightless = ~self._gravity_enabled & self._dynamic
        force[weightless, :3] -= self.mass[weightless, None] * self.gravity
        for state in (self._state, self._next):
            state.body_f.assign(force.astype(np.float32))


def _assign_rows(array: wp.array, starts: np.ndarray, rows: np.ndarray) -> None:
    """Write rows (N, K) to where each starts in a flat array; rows that start below zero are left out."""
    numbers = array.numpy().copy()
    chosen = np.flatnonzero(starts >= 0)
    numbers[starts[chosen, None] + np.arange(rows.shape[1])] = rows[chosen]
    array.assign(numbers)
