"""One play of a stage, from `play` to `stop`: the parsed scene, the running world, and the backup."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.errors import PhysicsError, warn_once
from usdsdg.stage.change_tracker import ChangeTracker
from usdsdg.stage.changes import Changes
from usdsdg.stage.physics.instances import split_instance
from usdsdg.stage.physics.scenes import steps_per_second
from usdsdg.stage.time_code import time_context
from usdsdg_physics.edits.apply_edits import apply_edits
from usdsdg_physics.edits.edit_reader import EditReader, Edits
from usdsdg_physics.edits.kinematic_bodies import KinematicBodies, carried_bodies
from usdsdg_physics.edits.stopped_bodies import StoppedBodies
from usdsdg_physics.edits.subtrees import with_subtrees
from usdsdg_physics.edits.time_samples import TimeSamples
from usdsdg_physics.edits.told_velocities import ToldVelocities
from usdsdg_physics.parse.scene import parse
from usdsdg_physics.parse.shapes.convex_hulls import HullCache
from usdsdg_physics.parse.units import Units
from usdsdg_physics.queries.scene_queries import SceneQueries
from usdsdg_physics.queries.triggers import Triggers
from usdsdg_physics.scene.events import ContactEvent, TriggerEvent
from usdsdg_physics.scene.records import Scene
from usdsdg_physics.scene.rigid_frames import rigid_pose
from usdsdg_physics.world.compile_kernels import Progress
from usdsdg_physics.world.contact_events import ContactEvents
from usdsdg_physics.world.continued import NOTHING
from usdsdg_physics.world.world import World
from usdsdg_physics.writeback.instancer_writer import InstancerWriter
from usdsdg_physics.writeback.joint_states import JointStateWriter
from usdsdg_physics.writeback.restore import Backup
from usdsdg_physics.writeback.stage_writer import StageWriter
from usdsdg_physics.writeback.trigger_states import TriggerStates


class PlaySession:
    """Reads the stage once, then only what changes; writes every step back. The world is built at the first step."""

    def __init__(
        self,
        stage: Usd.Stage,
        hulls: HullCache,
        *,
        time: Usd.TimeCode,
        device: str | None = None,
        progress: Progress | None = None,
        writes_velocities: bool = True,
    ) -> None:
        """`time` is that of the stage when the simulation begins."""
        self._time = time
        self.writes_velocities = writes_velocities
        self._stage, self._hulls, self._device, self._progress = stage, hulls, device, progress
        self._tracker = ChangeTracker(stage)
        self._backup = Backup()
        # Factor on the usual capacity of the contact buffers.
        self._capacity = 1.0
        self._must_rebuild = False
        self._joints_moved = False  # by states that were set since the world was built
        self._broken: set[str] = set()  # joints, until the end of the play
        self._unwritten = False  # whether the world is a step ahead of the stage
        self.world: World | None = None
        self._continued = NOTHING  # of the world before
        self._asleep: set[str] = set()  # bodies to put to sleep when the world is built
        self._trigger_states = TriggerStates(stage)
        self._inside: list[tuple[str, str]] = []  # triggers, and the colliders inside
        self._told = ToldVelocities()
        self._kinematic, self._stopped = KinematicBodies(), StoppedBodies()
        self._touching: set[tuple[str, str]] = set()  # colliders whose contacts are reported
        # Of the latest step.
        self.trigger_events: list[TriggerEvent] = []
        self.contact_events: list[ContactEvent] = []
        self._simulated: set[str] = set()  # bodies that have been in a world: startsAsleep no longer counts
        self.scene, self.poses = Scene({}, {}, (0.0, 0.0, 0.0), ""), np.zeros((0, 7))
        self._read_stage()

    def step(self, dt: float, time: Usd.TimeCode, *, write: bool = True) -> None:
        """Apply what users changed, advance by `dt` seconds to a time, write the result to the stage.

        Without `write` the next step does, which must follow before anybody reads the stage or edits it.
        """
        self._apply_stage_edits()
        before, self._time = self._time, time
        if all(body.is_collider for body in self.scene.bodies.values()):
            self.poses = self._time_samples.poses_at(time, self.poses)
            self._note_events(None, dt)
            return  # Newton is not even imported
        world = self._built_world()
        self._follow_time_samples(world, rewound=time < before)
        world.step(dt)
        self._handle_failures(world)
        # What time samples move may be below a body.
        if write or self.scene.animated:
            self._write_back(world)
        else:
            self.poses, self._unwritten = world.poses(), True
        self._note_events(world, dt)

    def _follow_time_samples(self, world: World, *, rewound: bool) -> None:
        """Move what time samples move: with the step, or at once where time went back, as at the end of a loop."""
        poses = self._time_samples.poses_at(self._time, self.poses)
        rows = [world.body_index[path] for path in self.scene.animated]
        moved = [row for row in rows if not np.allclose(poses[row], self.poses[row], rtol=0.0, atol=1e-7)]
        if moved and rewound:
            world.set_poses(moved, poses[moved])
            world.set_velocities(moved, np.zeros((len(moved), 6)))
        elif moved:
            world.add_kinematic_targets({row: poses[row] for row in moved})

    def write(self) -> None:
        """Write to the stage where bodies are, after steps that did not."""
        if self.world is not None:
            self._write_back(self.world)

    def catch_up(self) -> None:
        """As `write`, where the last step did not."""
        if self._unwritten:
            self._apply_stage_edits()  # or velocities that were set would be lost
            self.write()

    def reset(self, bodies: Collection[str]) -> None:
        """Restore the poses and velocities that bodies had before this play; takes effect at the next step."""
        self._backup.restore_prims(bodies)

    def steps_per_second(self) -> float:
        """Return the steps per second of the PhysicsScene, as it is now.

        Raises:
            PhysicsError: it is not positive.
        """
        path = self.scene.scene_path
        rate = steps_per_second(self._stage.GetPrimAtPath(path) if path else None)
        if not rate > 0.0:
            raise PhysicsError(f"{path}: physxScene:timeStepsPerSecond is {rate:g}; set a positive number of steps")
        return rate

    @property
    def queries(self) -> SceneQueries:
        """The scene queries of the last step."""
        if self._queries_are_stale:
            self._read_stage()
        return self._queries

    def end(self, *, restore: bool) -> None:
        """Stop listening to the stage; with `restore`, undo everything that was written to it."""
        self._tracker.close()
        if restore:
            self._backup.restore()
            self._trigger_states.restore()

    def show_edits(self) -> None:
        """Apply the edits of the stage, and write there where joints move other bodies to."""
        self._apply_stage_edits()
        if self.scene.joints and (self.world is not None or self._joints_moved):
            self._write_back(self._built_world())

    def current_scene(self) -> Scene:
        """Return the scene with the edits of the stage applied."""
        self._apply_stage_edits()
        return self.scene

    def current_world(self) -> World:
        """Return the world with the edits of the stage applied."""
        self._apply_stage_edits()
        return self._built_world()

    def _built_world(self) -> World:
        """Return the world; build it where there is none."""
        if self.world is None:
            options = {"device": self._device, "capacity": self._capacity, "progress": self._progress}
            self.world = World(self.scene, **options, continued=self._continued)
            self._joints_moved = False
            self.world.put_to_sleep([self.world.body_index[path] for path in self._asleep & self.scene.bodies.keys()])
            self._simulated |= self.scene.bodies.keys()
            self._kinematic.resume(self.world)
        return self.world

    def _write_back(self, world: World) -> None:
        self.poses, self._unwritten = world.poses(), False
        with self._tracker.muted(), time_context(self._time):
            self._writer.write(self.poses, world.velocities())
            self._instances.write(self.poses, world.velocities())
            if self._joint_writer.axes:
                self._joint_writer.write(*world.joint_state(self._joint_writer.axes))

    def _note_events(self, world: World | None, dt: float) -> None:
        """Find what entered and left triggers, and the contacts of a step of `dt` seconds that are reported.

        Without a world there are no bodies any more, so what was inside has left and what touched is lost.
        """
        self.trigger_events, self.contact_events = [], []
        if self._triggers.paths or self._inside:
            inside = self._triggers.inside(self.poses) if world is not None else []
            self.trigger_events = self._triggers.events(self._inside, inside)
            if self.trigger_events:
                with self._tracker.muted():
                    self._trigger_states.write({event.trigger for event in self.trigger_events}, inside)
            self._inside = inside
        if self.scene.reports or self._touching:
            units = self.units
            shapes, contacts = (world.shape_index, world.reported_contacts()) if world is not None else ({}, [])
            events = ContactEvents(
                self.scene, shapes, meters=units.meters, kilograms=units.kilograms, touching=self._touching
            )
            self.contact_events = events.of_step(contacts, dt)
            self._touching = events.touching

    def _read_stage(self, changes: Changes | None = None) -> None:
        """Read all of the stage again, after `changes`."""
        changes = changes or Changes()
        names = {name for names in changes.by_names for name in names if self._simulated}
        self._joints_moved |= any(name.startswith("state:") for name in names)
        self.units = Units.of(self._stage)
        scene = parse(self._stage, self._hulls, time=self._time, broken=self._broken)
        # An instancer has the velocities of its instances only where it has arrays of them.
        is_unwritten = (lambda path: split_instance(path) is not None) if self.writes_velocities else (lambda _: True)
        self._told.go_on(
            scene.bodies,
            self._velocities(),
            changes,
            is_unwritten=is_unwritten,
            is_same=self._is_kept(scene.instancers),
        )
        self._begin_with(scene, changes)

    def _velocities(self) -> dict[str, np.ndarray]:
        """Return the velocities (6,) [m/s, rad/s] of the bodies, by path, also where a new world is not built yet."""
        if self.world is not None:
            return dict(zip(self.scene.bodies, self.world.velocities().astype(np.float64)))
        return {path: np.array([*body.velocity, *body.angular_velocity]) for path, body in self.scene.bodies.items()}

    def _is_kept(self, instancers: Sequence[str]) -> Callable[[str], bool]:
        """Return a function that tells of the body at a path whether it is the one that was there before."""
        with time_context(self._time):
            kept = {path: self._instances.kept(path) for path in instancers} if self.scene.bodies else {}

        def is_kept(path: str) -> bool:
            found = split_instance(path)
            return found is None or found[1] in kept.get(found[0], ())

        return is_kept

    def _begin_with(self, scene: Scene, changes: Changes) -> None:
        """Go on with a scene that was read after `changes`, in a new world."""
        if self.world is not None:
            self._kinematic.note(self.scene.bodies, self.world)
            self._continued = self.world.continued()
        self._kinematic.begin(scene, changes)
        stopped = self._stopped.stop(scene.bodies, self.scene.bodies, self._simulated, changes)
        on_stage = initial_poses(scene)
        poses = dict(zip(self.scene.bodies, self.poses))
        for path, pose in carried_bodies(scene, self.scene, poses, changes).items():
            scene.bodies[path] = replace(scene.bodies[path], pose=tuple(pose.tolist()))
        self.scene = scene
        new = {path for path, body in self.scene.bodies.items() if body.starts_asleep and path not in self._simulated}
        self._asleep = new | set(self.world.asleep() if self.world is not None else ())
        self._tracker.take()
        self._reader = EditReader(
            self._stage, self.scene, self._hulls, moved_instances=lambda path: self._instances.moved(path)
        )
        self._queries = SceneQueries(self.scene)
        self._queries_are_stale = False
        self._triggers = Triggers(self.scene, self._queries)
        self._time_samples = TimeSamples(self._stage, self.scene, self.units.meters)
        self.poses = initial_poses(self.scene)
        self.world = None
        self._open_writer()
        with self._tracker.muted(), time_context(self._time):
            self._writer.stop(stopped)
        self._write_carried(on_stage)

    def _write_carried(self, on_stage: np.ndarray) -> None:
        """Write the poses of the bodies that begin elsewhere than the stage has them (N, 7)."""
        poses = self.poses.astype(np.float32)
        if not np.array_equal(poses, on_stage.astype(np.float32)):
            velocities = np.array([[*body.velocity, *body.angular_velocity] for body in self.scene.bodies.values()])
            velocities = velocities.astype(np.float32)
            with self._tracker.muted(), time_context(self._time):
                self._writer.set_written(on_stage, velocities)
                self._writer.write(poses, velocities)

    def _open_writer(self) -> None:
        with self._tracker.muted(), time_context(self._time):
            meters = self.units.meters
            bodies, velocities = self.scene.bodies, self.writes_velocities
            self._writer = StageWriter(
                self._stage,
                bodies,
                self._backup,
                meters_per_unit=meters,
                velocities=velocities,
                animated=self.scene.animated,
            )
            self._instances = InstancerWriter(
                self._stage, bodies, self._backup, meters_per_unit=meters, velocities=velocities
            )
            joints = self.scene.joints.values()
            self._joint_writer = JointStateWriter(self._stage, joints, self._backup, meters_per_unit=meters)
            self._backup.hold()
        self._note_written()

    def _note_written(self, edits: Edits | None = None) -> None:
        """Take the state of the world for that of the stage, of which it was read, unless it is steps ahead.

        Where the stage was edited it has that, and what joints do with it then is to be written: they take other bodies
        along, or put these back.
        """
        if self.world is None or self._unwritten:
            return
        edits = edits or Edits()
        poses, velocities = self.world.poses().copy(), self.world.velocities().copy()
        for path, pose in edits.poses.items():
            poses[self.world.body_index[path]] = pose
        for path, given in edits.velocities.items():
            row = self.world.body_index[path]
            velocities[row] = np.where(edits.velocities_set[path], given, velocities[row])
        self._writer.set_written(poses, velocities)

    def _read_edits(self, changes: Changes) -> Edits:
        with time_context(self._time):
            return self._reader.read(changes)

    def _apply_stage_edits(self) -> None:
        changes = self._tracker.take()
        self._stopped.note(changes)
        edits = self._read_edits(changes) if changes else Edits()
        if self._unwritten and (self._must_rebuild or edits.subtrees) and self.world is not None:
            self._write_back(self.world)
        stays = self.world is not None or not (self.scene.bodies or edits.subtrees)
        if edits.rebuild or self._must_rebuild or (edits and not stays):
            self._must_rebuild = False
            self._read_stage(changes)
            return
        if edits.subtrees:
            self._replace_subtrees(edits.subtrees, changes)
            # What else changed, of the scene that is now there.
            changes = changes.without_resynced()
            edits = self._read_edits(changes)
            if edits.rebuild or (edits and not self.scene.bodies):
                self._read_stage(changes)
                return
            if edits:
                self._built_world()
        # Without bodies nothing but a query asks where colliders are.
        self._queries_are_stale |= bool(edits) and self.world is None
        if edits and self.world is not None:
            self._note_written(edits)
            apply_edits(edits, self.world, self.scene, self._queries)
            self.poses = self.world.poses()
            self._told.note(edits.velocities)
        if self._writer.is_stale(changes):
            self._open_writer()

    def _replace_subtrees(self, subtrees: Mapping[str, Scene], changes: Changes) -> None:
        """Go on with what is now below some prims, and with all other bodies where and as fast as they are."""
        world, cache = self.world, UsdGeom.XformCache(self._time)
        assert world is not None
        for part in subtrees.values() if not self.writes_velocities else ():
            self._told.go_on(part.bodies, self._velocities(), changes)
        scene = with_subtrees(self._stage, self.scene, subtrees)
        poses, velocities = world.poses().tolist(), world.velocities().tolist()
        for path in scene.bodies.keys() - {path for part in subtrees.values() for path in part.bodies}:
            body, row = scene.bodies[path], world.body_index[path]
            pose = tuple(poses[row])
            if body.kinematic:  # it is still on its way to where it was put on the stage
                matrix = np.array(cache.GetLocalToWorldTransform(self._stage.GetPrimAtPath(path)))
                if not np.isfinite(matrix).all():
                    self._read_stage(changes)  # which leaves it out
                    return
                pose = tuple(rigid_pose(matrix, self.units.meters).tolist())
            velocity, angular = velocities[row][:3], velocities[row][3:]
            scene.bodies[path] = replace(body, pose=pose, velocity=tuple(velocity), angular_velocity=tuple(angular))
        x, y, z = world.gravity.tolist()
        self._begin_with(replace(scene, gravity=(x, y, z)), changes)

    def _handle_failures(self, world: World) -> None:
        """Warn of bodies whose step was not finite, enlarge contact buffers that overflowed, drop joints that broke."""
        for path in world.take_nonfinite():
            warn_once(
                f"{path}: the solver gave a pose that is not a number, so the body was stopped where it was. Look for "
                "an extreme mass, velocity or scale on it, or for colliders that start deep inside each other."
            )
        if world.contacts_overflowed:
            self._capacity *= 2.0
            self._must_rebuild = True
        if broken := world.broken_joints():
            self._broken |= set(broken)
            # The world is built anew without them.
            self._must_rebuild = True


def initial_poses(scene: Scene) -> np.ndarray:
    """Return the poses (N, 7) [m] of the bodies as they were read."""
    return np.array([body.pose for body in scene.bodies.values()]).reshape(-1, 7)
