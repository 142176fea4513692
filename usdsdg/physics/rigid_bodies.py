"""Rigid bodies and colliders. Mirrors `rep.physics.rigid_body` and `collider`."""

from typing import Any

from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from usdsdg.arguments.prims import prim_at
from usdsdg.arguments.values import vector
from usdsdg.distribution import Distribution, draw
from usdsdg.errors import GraphError, let_pass, warn_once
from usdsdg.functional.physics import DEFAULTS_PHYSICS_SCENE, apply_collider, create_physics_scene
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act, act_now
from usdsdg.graph.node import Node, ReplicatorItem, current_prims, prim_paths, why_no_prims
from usdsdg.modify.prims import target_prims
from usdsdg.stage.attribute_batch import write_batch
from usdsdg.stage.geometry.instancers import SAMPLED_ASSETS
from usdsdg.stage.physics import scenes
from usdsdg.stage.physics.rigid_bodies import apply_rigid_body_schemas, set_simulation_owner


def collider(
    approximation_shape: str = "convexHull", contact_offset: float | None = None, rest_offset: float | None = None,
    physics_scene: Any = None, input_prims: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Make every gprim at and below the prims a collider, at once; warn of a prim without a gprim, and leave it out.

    Instances become ordinary prims, with a warning, since gprims inside of an instance cannot be edited.

    Args:
        approximation_shape: approximation of meshes, as for `functional.physics.apply_collider`.
        contact_offset: distance below which contacts are generated [stage units].
        rest_offset: distance that colliders keep at rest [stage units].
        physics_scene: item, prim or path of the PhysicsScene that becomes their simulationOwner. Our own engine
            simulates everything in the stage's first PhysicsScene, and warns where there are several.

    Raises:
        BadPrim: there is no prim at `physics_scene`.
        GraphError: it is not a PhysicsScene, there is no such approximation, or there are no prims.
    """
    prims, scene = prim_paths(input_prims) or current_prims(), _scene_of(physics_scene)
    if not prims:
        let_pass(GraphError(f"physics.collider has no prims: {why_no_prims(input_prims)}"))
    offsets = dict(contactOffset=contact_offset, restOffset=rest_offset)
    for prim in map(prim_at, prims):
        _add_colliders(prim, approximation_shape, collisionEnabled=True, **offsets)
        for shape in _colliders(prim):
            set_simulation_owner(shape, scene)
    return ReplicatorItem(Node(kind="OgnCollider", prims=prims))


def rigid_body(
    velocity: Any = (0.0, 0.0, 0.0), angular_velocity: Any = None, contact_offset: float | None = None,
    rest_offset: float | None = None, overwrite: bool = False, physics_scene: Any = None, input_prims: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Make prims rigid bodies, with convex colliders where they have none, and set their velocities.

    Inside a trigger velocities are written each time it fires; outside, at once, those that a distribution draws at the
    next evaluation of the graph or when the timeline begins to play. Assets that `randomizer.instantiate` draws later
    get colliders too, at the execution that shows them.

    A stage without PhysicsScene gets Replicator's: /PhysicsScene with 240 steps per second, CCD, and no GPU dynamics.

    Args:
        velocity: (x, y, z) along world axes [stage units / s]: one for all, a list of one per prim, or a distribution.
        angular_velocity: about world axes [degrees / s], likewise.
        contact_offset: of new and existing colliders, as is `rest_offset`; see `collider`.
        overwrite: apply the schemas also where prims have colliders or are rigid bodies.
        physics_scene: as for `collider`.

    Raises:
        BadPrim: as `collider`, or there is no PhysicsScene and another prim is at /PhysicsScene.
        GraphError: as `collider`, or a velocity is not three numbers; at execution, where it is written then.
    """
    scene = _scene_of(physics_scene)
    offsets: dict[str, Any] = dict(contactOffset=contact_offset, restOffset=rest_offset)
    velocities: dict[str, Any] = dict(velocity=velocity, angular_velocity=angular_velocity)
    prims = prim_paths(input_prims) or current_prims()
    drawn_later = any(isinstance(each, Distribution) for each in velocities.values()) or any(map(_is_sampled, prims))
    start = act if drawn_later or not prims else act_now
    item = start("OgnRigidBody", input_prims, attribute="physics:velocity", **velocities, **offsets)
    if item.prims and scenes.physics_scene(prim_at(item.prims[0]).GetStage()) is None:
        create_physics_scene(**DEFAULTS_PHYSICS_SCENE)
    for path in item.prims:
        prim = prim_at(path)
        if not prim.IsActive():
            pass  # its asset gets colliders when it is shown
        elif overwrite or not (existing := _colliders(prim)):
            _add_colliders(prim, "convexHull", collisionEnabled=True, **offsets)
        elif any(offset is not None for offset in offsets.values()):
            for shape in existing:
                _add_colliders(shape, None, **offsets)
        if overwrite or not prim.HasAPI(UsdPhysics.RigidBodyAPI):
            apply_rigid_body_schemas(prim).CreateRigidBodyEnabledAttr(True)
        set_simulation_owner(prim, scene)
    return item


def _is_sampled(path: str) -> bool:
    """Return whether an execution of `randomizer.instantiate` decides which asset is at a path."""
    return path.startswith(f"{SAMPLED_ASSETS}/")


def _add_colliders_to_sampled(node: Node) -> None:
    """Make members of populations colliders that have changed to another asset."""
    offsets = {name: node.inputs.get(name) for name in ("contactOffset", "restOffset")}
    for path in node.prims:
        if _is_sampled(path) and prim_at(path).IsActive() and not _colliders(prim_at(path)):
            _add_colliders(prim_at(path), "convexHull", collisionEnabled=True, **offsets)


@action("OgnRigidBody", "angular_velocity", "contactOffset", "restOffset")
def _write_velocities(node: Node, execution: int) -> None:
    _add_colliders_to_sampled(node)
    linear = draw(node.inputs["velocity"], node, execution, "velocity")
    turning = node.inputs.get("angular_velocity")
    angular = None if turning is None else draw(turning, node, execution, "angular_velocity")
    bodies = [UsdPhysics.RigidBodyAPI(prim) for prim in target_prims(node)]
    if not write_batch(node.state, "linear", lambda: [body.CreateVelocityAttr() for body in bodies], linear):
        for body, value in zip(bodies, linear):
            body.CreateVelocityAttr().Set(Gf.Vec3f(vector("velocity", value)))
    if angular is None:
        return
    if not write_batch(node.state, "angular", lambda: [body.CreateAngularVelocityAttr() for body in bodies], angular):
        for body, value in zip(bodies, angular):
            body.CreateAngularVelocityAttr().Set(Gf.Vec3f(vector("angular_velocity", value)))


def _colliders(prim: Usd.Prim) -> list[Usd.Prim]:
    """Return the colliders at and below a prim, those inside instances included."""
    below = Usd.PrimRange(prim, Usd.TraverseInstanceProxies())
    return [child for child in below if child.IsA(UsdGeom.Gprim) and child.HasAPI(UsdPhysics.CollisionAPI)]


def _add_colliders(prim: Usd.Prim, approximation: str | None, **attributes: Any) -> None:
    """Make the gprims at and below a prim colliders; warn where there are none."""
    if any(each.IsA(UsdGeom.Gprim) for each in Usd.PrimRange(prim, Usd.TraverseInstanceProxies())):
        apply_collider(prim, None, approximation, **attributes)
    else:
        # A group may hold lights and cameras too.
        warn_once(f"{prim.GetPath()} has no shape or mesh at or below it that could collide")


def _scene_of(physics_scene: Any) -> Sdf.Path | None:
    """Return the path of the PhysicsScene given as prim, path or item; None for None."""
    if physics_scene is None:
        return None
    scenes = [prim for prim in map(prim_at, prim_paths(physics_scene)) if prim.IsA(UsdPhysics.Scene)]
    if len(scenes) != 1:
        raise GraphError(f"physics_scene={physics_scene!r} is not one PhysicsScene; define it with UsdPhysics.Scene")
    return scenes[0].GetPath()
