"""What users changed on the stage since the last step → changes of the world, or the word that it must be rebuilt."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg.stage.changes import Changes
from usdsdg_physics.parse.attributes import value
from usdsdg_physics.parse.collision_shapes import read_shape
from usdsdg_physics.parse.convex_hulls import HullCache
from usdsdg_physics.parse.scene import (
    Units,
    bound_material,
    frame_from_prim,
    parse,
    read_angular_velocity,
    read_body,
    read_gravity,
    read_velocity,
)
from usdsdg_physics.scene.prim_paths import at_or_below, below
from usdsdg_physics.scene.records import STATIC, Body, Collider, Scene, Shape
from usdsdg_physics.scene.rigid_frames import body_from_prim, rigid_pose

_VELOCITIES = frozenset({"physics:velocity", "physics:angularVelocity"})
_LIVE = frozenset({"physxRigidBody:disableGravity", "physxRigidBody:linearDamping", "physxRigidBody:angularDamping"})
_SWITCH = "physics:collisionEnabled"
_AT_START = "physics:startsAsleep"
_GRAVITY = frozenset({"physics:gravityDirection", "physics:gravityMagnitude"})
_STRUCTURE = ("physics:", "physxRigidBody:", "physxCollision:", "physxConvex", "material:binding:physics")
_GEOMETRY = frozenset(
    {"size", "radius", "radiusTop", "radiusBottom", "height", "width", "length", "axis"}
    | {"points", "faceVertexIndices", "faceVertexCounts", "orientation"}
)
# On prims that are no bodies or colliders yet.
_ELSEWHERE = ("physics:rigidBodyEnabled", "physics:filteredGroups", "physics:invertFilteredGroups", "collection:")


@dataclass
class Edits:
    """What to do before the next step. `rebuild` makes the rest void: everything is read anew."""

    rebuild: bool = False
    velocities: dict[str, np.ndarray] = field(default_factory=dict)  # body -> (6,) m/s, rad/s
    poses: dict[str, np.ndarray] = field(default_factory=dict)  # body -> (7,)
    bodies: dict[str, Body] = field(default_factory=dict)  # body whose gravity switch or damping changed
    colliders: dict[str, Collider] = field(default_factory=dict)  # collider that was switched or moved
    gravity: tuple[float, float, float] | None = None

    def __bool__(self) -> bool:
        return bool(self.rebuild or self.velocities or self.poses or self.bodies or self.colliders or self.gravity)


class EditReader:
    """Knows which prims matter for one scene, and reads from them only what changed."""

    def __init__(self, stage: Usd.Stage, scene: Scene, hulls: HullCache) -> None:
        self._stage, self._scene, self._hulls = stage, scene, hulls
        self._units = Units.of(stage)
        self._bodies = sorted(scene.bodies)
        self._colliders = sorted(scene.colliders)
        self._materials = {collider.material.path for collider in scene.colliders.values()} - {""}

    def read(self, changes: Changes) -> Edits:
        """Sort changes by what they mean; values are those on the stage now."""
        edits = Edits()
        if Sdf.Path.absoluteRootPath in changes.changed or any(map(self._restructures, changes.resynced)):
            edits.rebuild = True
            return edits
        cache = UsdGeom.XformCache(Usd.TimeCode.Default())
        for path, names in changes.changed.items():
            self._read_prim(str(path), names, cache, edits)
            if edits.rebuild:
                break
        return edits

    def _restructures(self, root: Sdf.Path) -> bool:
        """Whether what is below a resynced path differs, physically, from what the scene has there."""
        path = str(root)
        if root == Sdf.Path.absoluteRootPath or any(at_or_below(p, path) for p in self._materials):
            return True
        now = parse(self._stage, self._hulls, root=root)
        if now.scene_path or now.filtered or at_or_below(self._scene.scene_path, path):
            return True
        before_bodies, before_colliders = below(self._bodies, path), below(self._colliders, path)
        return not (
            set(now.bodies) == set(before_bodies)
            and set(now.colliders) == set(before_colliders)
            and all(_same_body(now.bodies[p], self._scene.bodies[p]) for p in before_bodies)
            and all(_same_collider(now.colliders[p], self._scene.colliders[p]) for p in before_colliders)
        )

    def _read_prim(self, path: str, names: set[str], cache: UsdGeom.XformCache, edits: Edits) -> None:
        if any(name.startswith("xformOp") for name in names):
            self._read_moved(path, cache, edits)
        if "material:binding" in names:
            edits.rebuild |= self._other_material(path)
        if path == self._scene.scene_path:
            if names & _GRAVITY:
                edits.gravity = read_gravity(self._stage, self._stage.GetPrimAtPath(path), self._units)
        elif path in self._materials:
            edits.rebuild |= any(name.startswith(("physics:", "physxMaterial:")) for name in names)
        elif path in self._scene.bodies or path in self._scene.colliders:
            self._read_known(path, names, cache, edits)
        else:
            edits.rebuild |= any(name.startswith((*_ELSEWHERE, "material:binding:physics")) for name in names)

    def _read_known(self, path: str, names: set[str], cache: UsdGeom.XformCache, edits: Edits) -> None:
        prim = self._stage.GetPrimAtPath(path)
        body, collider = self._scene.bodies.get(path), self._scene.colliders.get(path)
        structure = names - _VELOCITIES - _LIVE - {_SWITCH, _AT_START}
        edits.rebuild |= any(name.startswith(_STRUCTURE) for name in structure)
        edits.rebuild |= collider is not None and bool(structure & _GEOMETRY)
        if collider is not None and _SWITCH in names:
            collider = edits.colliders.get(path, collider)
            edits.colliders[path] = replace(collider, enabled=bool(value(prim, _SWITCH, True)))
        if body is not None and names & _VELOCITIES:
            velocity, angular = read_velocity(prim, self._units), read_angular_velocity(prim)
            edits.velocities[path] = np.array([*velocity, *angular])
        if body is not None and names & _LIVE:
            edits.bodies[path] = read_body(prim, cache, self._units)

    def _read_moved(self, path: str, cache: UsdGeom.XformCache, edits: Edits) -> None:
        """A transform changed: bodies at or below teleport, colliders take another place on what they belong to."""
        for body in below(self._bodies, path):
            local_to_world = np.array(cache.GetLocalToWorldTransform(self._stage.GetPrimAtPath(body)))
            if not np.isfinite(local_to_world).all():
                edits.rebuild = True
                return
            edits.poses[body] = rigid_pose(local_to_world, self._units.meters)
            to_frame = body_from_prim(local_to_world, self._units.meters)
            if not _close(to_frame, self._scene.bodies[body].body_from_prim):
                edits.rebuild = True
        for name in below(self._colliders, path):
            collider = edits.colliders.get(name, self._scene.colliders[name])
            if collider.body == STATIC or not at_or_below(collider.body, path):
                self._read_moved_collider(collider, cache, edits)

    def _read_moved_collider(self, collider: Collider, cache: UsdGeom.XformCache, edits: Edits) -> None:
        prim = self._stage.GetPrimAtPath(collider.path)
        if not np.isfinite(cache.GetLocalToWorldTransform(prim)).all():
            edits.rebuild = True
            return
        owner = self._stage.GetPrimAtPath(collider.body) if collider.body != STATIC else None
        to_frame = frame_from_prim(prim, owner, cache, self._units)
        shape = read_shape(prim, to_frame, self._hulls, dynamic=owner is not None)
        if shape is None or not _same_geometry(shape, collider.shape):
            edits.rebuild = True
        else:
            edits.colliders[collider.path] = replace(collider, shape=shape)

    def _other_material(self, path: str) -> bool:
        return any(
            bound_material(self._stage.GetPrimAtPath(name), self._units) != self._scene.colliders[name].material
            for name in below(self._colliders, path)
        )


def _same_body(a: Body, b: Body) -> bool:
    moved = replace(
        a, pose=b.pose, velocity=b.velocity, angular_velocity=b.angular_velocity, body_from_prim=b.body_from_prim
    )
    return moved == b and _close(a.body_from_prim, b.body_from_prim)


def _same_collider(a: Collider, b: Collider) -> bool:
    return (
        replace(a, shape=b.shape) == b
        and _same_geometry(a.shape, b.shape)
        and bool(np.allclose(a.shape.position, b.shape.position, atol=1e-6))
        and bool(abs(np.dot(a.shape.rotation, b.shape.rotation)) > 1.0 - 1e-9)
    )


def _same_geometry(a: Shape, b: Shape) -> bool:
    return a.kind == b.kind and a.solid == b.solid and _close(a.size, b.size)


def _close(a: object, b: object) -> bool:
    """Equal but for the rounding of single-precision ops."""
    return bool(np.allclose(a, b, rtol=1e-4, atol=1e-9))
