"""Translate stage edits since the last step into world updates, or request a rebuild."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg.stage.changes import Changes
from usdsdg.stage.paths import at_or_below
from usdsdg.stage.physics.instances import split_instance
from usdsdg.stage.time_code import is_sampled
from usdsdg_physics.edits.subtrees import SubtreeReader, nearly_equal, same_geometry, same_place
from usdsdg_physics.parse.attributes import COLLISION, has_api, value
from usdsdg_physics.parse.bodies import read_angular_velocity, read_body, read_velocity
from usdsdg_physics.parse.body_transforms import BodyXformCache
from usdsdg_physics.parse.colliders import collider_shapes, frame_from_prim
from usdsdg_physics.parse.forces import read_force
from usdsdg_physics.parse.joints.joints import read_joint
from usdsdg_physics.parse.materials import bound_materials, default_material
from usdsdg_physics.parse.point_instancers import read_instances
from usdsdg_physics.parse.scene import read_gravity
from usdsdg_physics.parse.shapes.convex_hulls import HullCache
from usdsdg_physics.parse.units import Units
from usdsdg_physics.parse.unread import warn_unread
from usdsdg_physics.scene.prim_paths import paths_below
from usdsdg_physics.scene.records import STATIC, Body, Collider, Force, Joint, Scene
from usdsdg_physics.scene.rigid_frames import body_from_prim, rigid_pose

_LINEAR = frozenset({"physics:velocity", "velocities"})  # of bodies, and of the instances of a PointInstancer
_ANGULAR = frozenset({"physics:angularVelocity", "angularVelocities"})
_VELOCITIES = frozenset({"physics:velocity", "physics:angularVelocity"})
_LIVE_BODY_ATTRIBUTES = frozenset(
    {"physxRigidBody:disableGravity", "physxRigidBody:linearDamping", "physxRigidBody:angularDamping"}
)
_SURFACE = "physxSurfaceVelocity:"
_FORCE = "physxForce:"
_CONTACT_REPORT = "physxContactReport:"
_COLLISION_ENABLED = "physics:collisionEnabled"
_STARTS_ASLEEP = "physics:startsAsleep"
_GRAVITY = frozenset({"physics:gravityDirection", "physics:gravityMagnitude"})
_JOINT_STATES = (":physics:position", ":physics:velocity")
_LIVE_DRIVE_ATTRIBUTES = (
    ":physics:targetPosition",
    ":physics:targetVelocity",
    ":physics:stiffness",
    ":physics:damping",
    ":physics:maxForce",
)
_JOINT_PREFIXES = ("physics:", "physx", "drive:", "limit:", "state:")
# Prefixes of attributes whose change needs a rebuild, unless they are among the above.
_REBUILD_PREFIXES = (
    "physics:",
    "physxRigidBody:",
    "physxCollision:",
    "physxConvex",
    "physxArticulation:",
    "material:binding:physics",
)
_SCENE_SETTINGS = frozenset({"physxScene:bounceThreshold", "physxScene:invertCollisionGroupFilter"})
_BINDINGS = frozenset({"material:binding", "material:binding:physics"})
_SHAPE_ATTRIBUTES = frozenset(
    {"size", "radius", "radiusTop", "radiusBottom", "height", "width", "length", "axis"}
    | {"points", "faceVertexIndices", "faceVertexCounts", "holeIndices", "orientation"}
)
_INSTANCE_POSES = frozenset({"positions", "orientations", "orientationsf"})
_INSTANCE_VELOCITIES = frozenset({"velocities", "angularVelocities"})
_INSTANCE_COUNTS = frozenset({"protoIndices", "prototypes", "scales", "ids"})
_INSTANCES = _INSTANCE_POSES | _INSTANCE_VELOCITIES | _INSTANCE_COUNTS
# Of attributes that matter where nothing is simulated yet.
_PHYSICS_PREFIXES = ("phys", "collection:", "drive:", "limit:", "state:")
# Likewise on prims that are neither bodies nor colliders yet.
_NEW_PRIM_PREFIXES = (
    "physics:rigidBodyEnabled",
    "physics:simulationOwner",
    "physics:filteredGroups",
    "physics:filteredPairs",
    "physics:invertFilteredGroups",
    "physics:mergeGroup",
    "physics:jointEnabled",
    "physics:body0",
    "physics:body1",
    "physics:gearRatio",
    "physics:ratio",
    "physics:hinge",
    "physics:prismatic",
    "physxArticulation:",
    "collection:",
)


@dataclass
class Edits:
    """World updates to apply before the next step.

    `rebuild` supersedes the others: the whole stage is read again. With `subtrees` the others were not read.
    """

    rebuild: bool = False
    subtrees: dict[str, Scene] = field(default_factory=dict)  # what is now at and below prims, which needs a new world
    velocities: dict[str, np.ndarray] = field(default_factory=dict)  # by body: (6,) m/s, rad/s
    velocities_set: dict[str, np.ndarray] = field(default_factory=dict)  # which of these: (6,) bool
    poses: dict[str, np.ndarray] = field(default_factory=dict)  # by body: (7,) m
    bodies: dict[str, Body] = field(default_factory=dict)  # whose gravity switch or damping changed
    colliders: dict[str, Collider] = field(default_factory=dict)  # that were switched or moved
    joints: dict[str, Joint] = field(default_factory=dict)  # with new drives, or a new state
    moved_joints: set[str] = field(default_factory=set)  # those of `joints` whose position or velocity was set
    gravity: tuple[float, float, float] | None = None
    forces: dict[str, Force] = field(default_factory=dict)  # that changed, by prim

    def __bool__(self) -> bool:
        edits = (self.velocities, self.poses, self.bodies, self.colliders, self.joints, self.gravity, self.forces)
        return self.rebuild or bool(self.subtrees) or any(edits)


def _names_physics(changes: Changes) -> bool:
    """Return whether a property of a physics schema is among the changes."""
    return any(name.startswith(_PHYSICS_PREFIXES) for names in changes.by_names for name in names)


class EditReader:
    """Reads from the prims of one scene what changed on the stage."""

    def __init__(
        self, stage: Usd.Stage, scene: Scene, hulls: HullCache, *, moved_instances: Callable[[str], set[int]]
    ) -> None:
        """`moved_instances` returns the indices of a PointInstancer's instances that users moved."""
        self._moved = moved_instances
        self._stage, self._scene, self._hulls = stage, scene, hulls
        self._units = Units.of(stage)
        self._subtrees = SubtreeReader(stage, scene, hulls)
        self._animated = set(scene.animated)
        self._sampled: set[Sdf.Path] = set()  # dynamic bodies of whose poses a script makes samples, as a record

    def read(self, changes: Changes) -> Edits:
        """Read the edits that changes of the stage mean; values are those of now, at the time of the context."""
        edits = Edits()
        subtrees = None if Sdf.Path.absoluteRootPath in changes.changed else self._subtrees.read(changes.resynced)
        if subtrees is None:
            edits.rebuild = True
            return edits
        if subtrees:
            edits.subtrees = subtrees
            return edits
        if self._scene.is_empty and not _names_physics(changes):
            return edits
        changed = changes.changed if not changes.resynced else self._with_resynced(changes)
        self._note_sampled(changed)
        cache = BodyXformCache(self._sampled)
        for path, names in changed.items():
            self._read_prim(str(path), names, path in changes.metadata, cache, edits)
            if edits.rebuild:
                break
        return edits

    def _with_resynced(self, changes: Changes) -> dict[Sdf.Path, set[str]]:
        """Return what changed, also on prims that were read again and are the same but for poses and velocities."""
        below = changes.changed_below_resynced.items()
        return changes.changed | {path: names for path, names in below if self._stage.GetPrimAtPath(path)}

    def _note_sampled(self, changed: dict[Sdf.Path, set[str]]) -> None:
        for path, names in changed.items():
            body = self._scene.bodies.get(str(path))
            if body is not None and not body.kinematic:
                ops = (path.AppendProperty(name) for name in names if name.startswith("xformOp:"))
                attributes = map(self._stage.GetAttributeAtPath, ops)
                if any(attribute and is_sampled(attribute) for attribute in attributes):
                    self._sampled.add(path)

    def _read_prim(
        self, path: str, names: set[str], has_metadata: bool, cache: UsdGeom.XformCache, edits: Edits
    ) -> None:
        warn_unread(self._stage.GetPrimAtPath(path), names)
        # inactiveIds is metadata of the instancer, and notices give no names of metadata.
        if path in self._scene.instancers and (names & _INSTANCES or has_metadata):
            self._read_instances(path, names, cache, edits)
        if any(name.startswith("xformOp") for name in names):
            edits.rebuild |= any(at_or_below(p, path) or at_or_below(path, p) for p in self._scene.prototypes)
            self._read_poses(path, cache, edits)
        if names & _BINDINGS:
            edits.rebuild |= self._material_changed(path)
        edits.rebuild |= any(name.startswith(_CONTACT_REPORT) for name in names)
        if path in self._scene.forces and any(name.startswith((_FORCE, "xformOp")) for name in names):
            self._read_force(path, cache, edits)
        if path == self._scene.scene_path:
            edits.rebuild |= bool(names & _SCENE_SETTINGS)
            if names & _GRAVITY:
                edits.gravity = read_gravity(self._stage, self._stage.GetPrimAtPath(path), self._units)
        elif path in self._scene.joints:
            self._read_joint(path, names, cache, edits)
        elif path in self._subtrees.materials:
            edits.rebuild |= any(name.startswith(("physics:", "physxMaterial:")) for name in names)
        elif path in self._scene.bodies or path in self._scene.colliders:
            self._read_body_or_collider(path, names, cache, edits)
        elif any(at_or_below(path, prototype) for prototype in self._scene.prototypes):
            others = names - _INSTANCES
            edits.rebuild |= any(name.startswith(_REBUILD_PREFIXES) for name in others)
            edits.rebuild |= bool(others & _SHAPE_ATTRIBUTES)
        else:
            edits.rebuild |= any(name.startswith((*_NEW_PRIM_PREFIXES, "material:binding:physics")) for name in names)
            edits.rebuild |= self._may_have_shape(path, names)

    def _may_have_shape(self, path: str, names: set[str]) -> bool:
        """Return whether a collider has another shape now, or one where it had none."""
        prim = self._stage.GetPrimAtPath(path) if names & _SHAPE_ATTRIBUTES else None
        return bool(prim) and has_api(prim, COLLISION)

    def _read_body_or_collider(self, path: str, names: set[str], cache: UsdGeom.XformCache, edits: Edits) -> None:
        prim = self._stage.GetPrimAtPath(path)
        body, collider = self._scene.bodies.get(path), self._scene.colliders.get(path)
        others = names - _VELOCITIES - _LIVE_BODY_ATTRIBUTES - {_COLLISION_ENABLED, _STARTS_ASLEEP}
        edits.rebuild |= any(name.startswith(_REBUILD_PREFIXES) for name in others)
        edits.rebuild |= self._may_have_shape(path, others)
        if collider is not None and _COLLISION_ENABLED in names:
            enabled = bool(value(prim, _COLLISION_ENABLED, True))
            for part in self._subtrees.parts_of(path):
                before = edits.colliders.get(part, self._scene.colliders[part])
                edits.colliders[part] = replace(before, enabled=enabled)
        if body is not None and names & _VELOCITIES:
            velocities = np.array([*read_velocity(prim, self._units), *read_angular_velocity(prim)])
            edits.velocities[path], edits.velocities_set[path] = velocities, _set(names)
        if body is not None and (names & _LIVE_BODY_ATTRIBUTES or any(name.startswith(_SURFACE) for name in names)):
            edits.bodies[path] = replace(read_body(prim, cache, self._units), kinematic=body.kinematic, held=body.held)

    def _read_joint(self, path: str, names: set[str], cache: UsdGeom.XformCache, edits: Edits) -> None:
        """Read new drives and states of a joint; whatever else changed about it needs a rebuild."""
        names = {name for name in names if name.startswith(_JOINT_PREFIXES)}
        states = {name for name in names if name.startswith("state:") and name.endswith(_JOINT_STATES)}
        drives = {name for name in names if name.startswith("drive:") and name.endswith(_LIVE_DRIVE_ATTRIBUTES)}
        edits.rebuild |= bool(names - states - drives)
        if edits.rebuild or not names:
            return
        joint, before = read_joint(self._stage.GetPrimAtPath(path), cache, self._units), self._scene.joints[path]
        same_axes = joint is not None and [axis.name for axis in joint.axes] == [axis.name for axis in before.axes]
        if joint is None or not same_axes:
            edits.rebuild = True
            return
        # Of its frames nothing but their rounding changed.
        edits.joints[path] = replace(before, axes=joint.axes)
        if states:
            edits.moved_joints.add(path)

    def _read_instances(self, path: str, names: set[str], cache: UsdGeom.XformCache, edits: Edits) -> None:
        """Read new poses and velocities of the instances of a PointInstancer; other changes need a rebuild."""
        now = read_instances(
            self._stage.GetPrimAtPath(path), cache, self._units, self._hulls, self._scene.default_material
        )
        before = self._of_instancer(path, self._scene.bodies)
        counted = names & _INSTANCE_COUNTS or set(now.bodies) != before
        if counted or not now.colliders.keys() <= self._scene.colliders.keys():
            edits.rebuild = True
            return
        # Of those that are inactive now, if metadata changed.
        edits.rebuild |= set(now.colliders) != self._of_instancer(path, self._scene.colliders)
        if edits.rebuild:
            return
        moved = self._moved(path) if names & _INSTANCE_POSES else set()
        for name, body in now.bodies.items():
            found = split_instance(name)
            if found is not None and found[1] in moved:
                edits.poses[name] = np.array(body.pose)
            if names & _INSTANCE_VELOCITIES:
                edits.velocities[name] = np.array([*body.velocity, *body.angular_velocity])
                edits.velocities_set[name] = _set(names)
        for name, collider in now.colliders.items():
            old = self._scene.colliders[name]
            if collider.body == STATIC and collider.shape != old.shape:
                edits.rebuild |= not same_geometry(collider.shape, old.shape)
                edits.colliders[name] = replace(old, shape=collider.shape)

    def _of_instancer(self, path: str, names: Iterable[str]) -> set[str]:
        return {name for name in names if (split_instance(name) or ("",))[0] == path}

    def _read_force(self, path: str, cache: UsdGeom.XformCache, edits: Edits) -> None:
        owner = self._stage.GetPrimAtPath(self._scene.forces[path].body)
        force = read_force(self._stage.GetPrimAtPath(path), owner, cache, self._units)
        if force is not None:
            edits.forces[path] = force

    def _read_poses(self, path: str, cache: UsdGeom.XformCache, edits: Edits) -> None:
        """Read poses after a transform changed: those of bodies below, and of colliders relative to their owners."""
        for body in paths_below(self._subtrees.bodies, path):
            if body in self._animated:
                continue  # `PlaySession` moves it at every step
            local_to_world = np.array(cache.GetLocalToWorldTransform(self._stage.GetPrimAtPath(body)))
            if not np.isfinite(local_to_world).all():
                edits.rebuild = True
                return
            edits.poses[body] = rigid_pose(local_to_world, self._units.meters)
            to_frame = body_from_prim(local_to_world, self._units.meters)
            before = self._scene.bodies[body]
            if not nearly_equal(to_frame, before.body_from_prim):
                edits.rebuild = True
        for name in paths_below(self._subtrees.colliders, path):
            collider = edits.colliders.get(name, self._scene.colliders[name])
            if collider.body == STATIC or not at_or_below(collider.body, path):
                self._read_collider_pose(collider, cache, edits)

    def _read_collider_pose(self, collider: Collider, cache: UsdGeom.XformCache, edits: Edits) -> None:
        prim = self._stage.GetPrimAtPath(collider.path)
        if not np.isfinite(cache.GetLocalToWorldTransform(prim)).all():
            edits.rebuild = True
            return
        owner = self._stage.GetPrimAtPath(collider.body) if collider.body != STATIC else None
        to_frame = frame_from_prim(prim, owner, cache, self._units)
        shapes = collider_shapes(prim, owner, to_frame, self._hulls)
        # Where it is on a body that moves by itself, there is some of the body's mass.
        has_mass = collider.body != STATIC and not self._scene.bodies[collider.body].kinematic
        for part, shape in zip(self._subtrees.parts_of(collider.path), shapes):
            before = edits.colliders.get(part, self._scene.colliders[part])
            edits.rebuild |= not same_geometry(shape, before.shape)
            edits.rebuild |= has_mass and not same_place(shape, before.shape)
            edits.colliders[part] = replace(before, shape=shape)
        edits.rebuild |= len(shapes) != collider.parts

    def _material_changed(self, path: str) -> bool:
        default = self._scene.default_material
        if at_or_below(self._scene.scene_path, path):
            scene_prim = self._stage.GetPrimAtPath(self._scene.scene_path)
            if default_material(scene_prim, self._units) != default:
                return True
        colliders = paths_below(self._subtrees.colliders, path)
        materials = bound_materials([self._stage.GetPrimAtPath(name) for name in colliders], self._units, default)
        return any(self._scene.colliders[name].material != new for name, new in zip(colliders, materials))


def velocities_set(path: str, changes: Changes) -> np.ndarray:
    """Return which (6,) of the linear and the angular velocity of a body changed on the stage."""
    owner = Sdf.Path((split_instance(path) or (path,))[0])
    return _set(changes.changed.get(owner, set()) | changes.changed_below_resynced.get(owner, set()))


def _set(names: set[str]) -> np.ndarray:
    return np.repeat([bool(names & _LINEAR), bool(names & _ANGULAR)], 3)
