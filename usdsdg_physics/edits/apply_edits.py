"""Apply edits to the running world, the scene queries, and the records of the scene."""

from dataclasses import replace

import numpy as np

from usdsdg_physics.edits.edit_reader import Edits
from usdsdg_physics.queries.scene_queries import SceneQueries
from usdsdg_physics.scene.records import Scene
from usdsdg_physics.world.world import World


def apply_edits(edits: Edits, world: World, scene: Scene, queries: SceneQueries) -> None:
    """Update `world` and `queries`; the records of `scene` follow, except for the poses of bodies."""
    _apply_poses(edits, world, scene)
    if edits.velocities:
        rows = [world.body_index[path] for path in edits.velocities]
        given = np.array(list(edits.velocities.values()))
        is_set = np.array([edits.velocities_set[path] for path in edits.velocities])
        world.set_velocities(rows, np.where(is_set, given, world.velocities()[rows]))
    if edits.gravity is not None:
        world.set_gravity(edits.gravity)
    for path, body in edits.bodies.items():
        world.set_damping(world.body_index[path], body.linear_damping, body.angular_damping)
        scene.bodies[path] = replace(body, pose=scene.bodies[path].pose)
    if edits.bodies:
        world.set_gravity_enabled({world.body_index[path]: body.gravity for path, body in edits.bodies.items()})
        world.set_surfaces({world.body_index[path]: body.surface for path, body in edits.bodies.items()})
    if edits.forces:
        scene.forces.update(edits.forces)
        world.set_forces(scene.forces.values())
    _apply_joints(edits, world, scene)
    _apply_colliders(edits, world, scene, queries)
    world.wake()  # what is at rest may have lost what it lay on


def _apply_poses(edits: Edits, world: World, scene: Scene) -> None:
    kinematic = {path for path in edits.poses if scene.bodies[path].kinematic}
    world.add_kinematic_targets({world.body_index[path]: edits.poses[path] for path in kinematic})
    teleported = [path for path in edits.poses if path not in kinematic]
    if teleported:
        indices = [world.body_index[path] for path in teleported]
        world.set_poses(indices, np.array([edits.poses[path] for path in teleported]))
        world.discard_contact_history()


def _apply_joints(edits: Edits, world: World, scene: Scene) -> None:
    for path, joint in edits.joints.items():
        world.set_drives({(path, axis.name): axis.drive for axis in joint.axes if axis.drive is not None})
        scene.joints[path] = joint
    for path in sorted(edits.moved_joints):
        axes = edits.joints[path].axes
        positions = {(path, axis.name): axis.position for axis in axes if axis.position is not None}
        velocities = {(path, axis.name): axis.velocity for axis in axes if axis.velocity is not None}
        world.set_joint_state(positions, velocities)


def _apply_colliders(edits: Edits, world: World, scene: Scene, queries: SceneQueries) -> None:
    enabled, moved = {}, {}
    for path, collider in edits.colliders.items():
        before, index = scene.colliders[path], world.shape_index[path]
        if collider.enabled != before.enabled:
            enabled[index] = collider.enabled
            queries.set_enabled(path, collider.enabled)
        if collider.shape != before.shape:
            moved[index] = (*collider.shape.position, *collider.shape.rotation)
            queries.set_pose(path, collider.shape)
        scene.colliders[path] = collider
    world.set_colliders_enabled(enabled)
    if moved:
        world.set_shape_poses(moved)
