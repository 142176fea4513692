"""A Newton model in motion: states, forces, substeps, and setters that reach every array the solver reads."""

# Newton declares the arrays of models and states optional; after `finalize` all are there.
# pyright: reportOptionalMemberAccess=false, reportArgumentType=false

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from usdsdg_physics.corrections.bodies.stabilization import REST_DELAY
from usdsdg_physics.corrections.contacts.contact_report import ContactRows
from usdsdg_physics.corrections.friction.friction_anchors import center_friction
from usdsdg_physics.model.build import (
    build_model,
    build_pipeline,
    build_solver,
    distance_joints,
    enable_surface_velocities,
)
from usdsdg_physics.scene.loop_cuts import cut_loops
from usdsdg_physics.scene.records import Drive, Force, Scene, SurfaceVelocity
from usdsdg_physics.world.body_forces import BodyForces
from usdsdg_physics.world.body_states import BodyStates, Indices
from usdsdg_physics.world.colliders import Colliders
from usdsdg_physics.world.compile_kernels import Progress, load_kernels, prepare_newton
from usdsdg_physics.world.continued import NOTHING, Continued, continued_of
from usdsdg_physics.world.damping import Damping
from usdsdg_physics.world.halves import Halves
from usdsdg_physics.world.joints import Joints
from usdsdg_physics.world.kinematic_loads import KinematicLoads
from usdsdg_physics.world.kinematic_motion import KinematicMotion
from usdsdg_physics.world.steady_forces import SteadyForces
from usdsdg_physics.world.step_corrections import StepCorrections, StepKind
from usdsdg_physics.world.step_launches import StepLaunches
from usdsdg_physics.world.substeps.substeps import Substeps

# Kinetic energy per mass [m²/s²] below which a body rests: that of 1 mm/s.
REST_ENERGY = 5e-7


class World:
    """All bodies and colliders of one scene, in SI units. Bodies and shapes are addressed by their indices."""

    def __init__(
        self,
        scene: Scene,
        *,
        device: str | None = None,
        capacity: float = 1.0,
        progress: Progress | None = None,
        continued: Continued = NOTHING,
    ) -> None:
        """Build the model and its solver.

        Args:
            device: "cpu", "cuda:0" or None for Warp's default.
            capacity: factor on the usual capacity of the contact and constraint buffers.
            progress: hears about kernels being compiled.
            continued: what the world that this one replaces had.
        """
        prepare_newton()
        scene = cut_loops(scene)
        built = build_model(scene, device=device)
        self.model = built.model
        extra_contacts = 2 * len(distance_joints(scene))
        self.pipeline = build_pipeline(self.model, capacity=capacity, extra=extra_contacts)
        load_kernels(self.pipeline, progress=progress)
        self.solver = build_solver(built, self.pipeline, capacity=capacity)
        center_friction(self.solver)
        self.solver.restitution_velocity_threshold = scene.bounce_threshold
        self.body_index, self.shape_index = built.body_index, built.shape_index
        self._halves = Halves(scene, built.body_index)
        self.bodies = self._halves.bodies
        # Of whole bodies: kg, m in the body's frame, kg m² about the center of mass.
        parts = self._halves.parts
        self.mass, self.center, self.inertia = built.mass * parts, built.center, built.inertia * parts[:, None, None]
        self._inertia_per_mass = built.inertia_per_mass
        self.gravity = np.asarray(scene.gravity, np.float64)
        self._state, self._next = states = self.model.state(), self.model.state()
        self._contacts = self.pipeline.contacts()
        control = self.model.control()
        self.joints = Joints(scene, self.model, control, built.joints) if built.joints.trees else None
        self._body_states = BodyStates(self._state, self._halves, built, self.joints)
        self._damping = Damping(self.model, self._halves)
        bodies = list(scene.bodies.values())
        self._dynamic = np.array([not body.kinematic for body in bodies], bool)
        self._pushes = BodyForces(scene, built, states, self._halves)
        self._kinematic = KinematicMotion(self.model, built.center, built.pose_coordinate)
        self._corrections = StepCorrections(scene, built, self._contacts)
        self.joint_forces = self._corrections.joint_forces
        self._corrections.stabilization.set_gravity(self.gravity)
        self._colliders = Colliders(scene, self.model, built.shape_index, self._corrections.depenetration)
        self._breakable = built.joints.breakable
        self._kinematic_loads = KinematicLoads(built) if self._corrections.loads is not None else None
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
        self._forces = SteadyForces(built.body_index, self.mass, self.center, self.inertia)
        self._forces.set(scene.forces.values())
        self._latest_substeps = 0
        if self.model.device.is_cuda and bodies:
            self._launches.load_kernels(progress)
        if bodies:
            indices = np.arange(len(bodies))
            self.set_poses(indices, np.array([body.pose for body in bodies]))
            self.set_velocities(indices, np.array([[*b.velocity, *b.angular_velocity] for b in bodies]))
            if self.joints is not None:
                self.joints.start(self._state, continued.positions)
            self._pushes.apply()
            self._corrections.stabilization.set_gravity_enabled(self._pushes.gravity_enabled)
        self.set_colliders_enabled({built.shape_index[c.path]: c.enabled for c in scene.colliders.values()})
        self.add_joint_efforts(continued.efforts)
        self.add_wrenches(*continued.pushed(self.body_index))

    def continued(self) -> Continued:
        """Return what a world that replaces this one goes on with."""
        return continued_of(self.bodies, self._pushes, self.joints, self._state)

    def poses(self) -> np.ndarray:
        """Return (N, 7) float32: x, y, z [m] and quaternion x, y, z, w of every body frame."""
        return self._body_states.poses()[: len(self.bodies)]

    def velocities(self) -> np.ndarray:
        """Return (N, 6) float32, world: velocity of the center of mass [m/s], angular velocity [rad/s]."""
        return self._body_states.velocities()[: len(self.bodies)]

    def set_poses(self, indices: Indices, poses: np.ndarray) -> None:
        """Teleport bodies; their velocities stay."""
        indices = self._body_states.set_poses(indices, poses)
        self._corrections.tunneling_guard.mark_teleported(indices)
        self.wake(indices)

    def set_velocities(self, indices: Indices, velocities: np.ndarray) -> None:
        """Set rows of `velocities()`."""
        self.wake(self._body_states.set_velocities(indices, velocities))
        self._kinematic.note_velocities(indices)

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
        if self.joints is not None and efforts:
            self.joints.add_efforts(efforts)
            self.wake()

    def set_joint_state(
        self, positions: Mapping[tuple[str, str], float], velocities: Mapping[tuple[str, str], float]
    ) -> None:
        """Move axes at once [m, rad], and set their velocities, by path of the joint and name of the axis."""
        if self.joints is not None:
            self.joints.set_state(self._state, positions, velocities)
            self.wake()

    def wake(self, indices: Indices | None = None) -> None:
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
        self.model.set_gravity(tuple(self.gravity.tolist()))
        self.solver.notify_model_changed(newton.ModelFlags.MODEL_PROPERTIES)
        self._corrections.stabilization.set_gravity(self.gravity)
        self._pushes.set_gravity(self.gravity)
        self._substeps.set_gravity(self.gravity, self._pushes.gravity_enabled)
        self.wake()

    def set_gravity_enabled(self, enabled: Mapping[int, bool]) -> None:
        """Switch gravity on or off for single bodies."""
        self._pushes.enable_gravity(enabled)
        self._corrections.stabilization.set_gravity_enabled(self._pushes.gravity_enabled)
        self._substeps.set_gravity(self.gravity, self._pushes.gravity_enabled)
        self.wake(list(enabled))

    def set_damping(self, index: int, linear: float, angular: float) -> None:
        """Set the damping of one body [1/s]."""
        self._damping.set(index, linear, angular)

    def set_least_damping(self, scene: Scene, damping: float) -> None:
        """Give every body at least this linear and angular damping [1/s], or its own where that is more."""
        self._damping.set_least(scene, damping)

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

    def add_wrenches(self, indices: Indices, wrenches: np.ndarray) -> None:
        """Push bodies during the next step: force [N] and torque about the center of mass [N m] (n, 6), world.

        Wrenches add up; kinematic bodies have none.
        """
        self._pushes.add_wrenches(indices, wrenches)
        self.wake(indices)

    def set_colliders_enabled(self, enabled: Mapping[int, bool]) -> None:
        """Switch colliders on or off, by shape index."""
        self._colliders.enable(enabled)

    def set_shape_poses(self, poses: Mapping[int, Sequence[float]]) -> None:
        """Move static colliders, by shape index (7 numbers, world)."""
        self._colliders.set_poses(poses)
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

    def add_kinematic_targets(self, targets: Mapping[int, np.ndarray]) -> None:
        """Set the poses (7,) that kinematic bodies reach by the end of the next step, at constant velocity.

        They have that velocity until the step after, which stops those without another target.
        """
        self._kinematic.add_targets(targets)
        if targets:
            self.wake()

    def kinematic_velocities(self) -> dict[int, np.ndarray]:
        """Return the velocities (6,) [m/s, rad/s] of the kinematic bodies that moved in the latest step, by index."""
        rows = self._kinematic.moving
        return dict(zip(rows, self.velocities()[rows].astype(np.float64))) if rows else {}

    def resume_kinematic(self, velocities: Mapping[int, np.ndarray]) -> None:
        """Go on from `kinematic_velocities` of the world that this one replaces."""
        if velocities:
            self.set_velocities(list(velocities), np.array(list(velocities.values())))
            self._kinematic.resume(velocities)

    def step(self, dt: float) -> None:
        """Advance by `dt` seconds."""
        moving, stopping = self._kinematic.bodies, self._kinematic.stopping
        kind = StepKind(
            dt,
            self._substeps_of(dt),
            bool(moving),
            self._corrections.depenetration.active,
            self._corrections.sleeping.any,
        )
        targets, velocities = np.zeros((0, 7)), np.zeros((0, 6))
        if moving:
            targets, velocities = self._kinematic.begin(self.poses(), dt, kind.substeps)
        self._set_kinematic_velocities([*moving, *stopping], np.vstack([velocities, np.zeros((len(stopping), 6))]), dt)
        if self._corrections.report is not None and self._corrections.report.reserve(kind.substeps):
            self._launches.forget()
        self._latest_substeps = kind.substeps
        self._move_surfaces(dt)
        if self._forces:
            self.add_wrenches(*self._forces.wrenches(self.poses()))
        if self._pushes.push:
            self._pushes.apply()
        if self.joints is not None:
            self.joints.follow_inertia(self._state)

        self._launches.run(kind)

        self._pushes.forget_wrenches()
        if self.joints is not None:
            self.joints.clear_efforts()
        if moving:
            self.set_poses(moving, targets)
        self._kinematic.finish()
        if kind.depenetrates:
            self._corrections.depenetration.finish()
        if kind.has_sleepers:
            self._corrections.sleeping.finish()

    def _set_kinematic_velocities(self, indices: list[int], velocities: np.ndarray, dt: float) -> None:
        """Set the velocities (n, 6) that kinematic bodies have during a step of `dt` seconds."""
        before = self._body_states.velocities() if indices and self._kinematic_loads is not None else None
        if indices:
            self.set_velocities(indices, velocities)
        if self._kinematic_loads is not None and self._corrections.loads is not None:
            wrenches = None
            if before is not None:
                poses, after = self._body_states.poses().astype(np.float64), self._body_states.velocities()
                wrenches = self._kinematic_loads.wrenches(poses, before, after, dt)
            self._corrections.loads.add(wrenches)

    def _move_surfaces(self, dt: float) -> None:
        """Let static colliders that move carry what they touch during a step of `dt` seconds."""
        motion = self._colliders.motion.take(dt)
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

    def _substeps_of(self, dt: float) -> int:
        """Return how many substeps the next step takes, of `dt` seconds."""
        if not self._substeps.vary:
            return self._substeps.least(dt)
        held = self._corrections.stabilization.rest_time.numpy() >= REST_DELAY
        velocities = self._body_states.velocities()
        velocities[self._kinematic.moving] = 0.0  # nothing stops those
        axes = self._substeps.triple_axes
        return self._substeps.of_step(
            dt,
            self._body_states.poses(),
            velocities,
            speeds=self._state.joint_qd.numpy()[axes] if len(axes) else np.zeros(0),
            targets=self._kinematic.targets,
            held=held,
            is_pushed=bool(self._kinematic.targets) or self._pushes.push or bool(self._forces),
        )
