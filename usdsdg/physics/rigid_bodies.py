"""Rigid bodies and colliders. Mirrors `rep.physics.rigid_body` and `collider`."""

from functools import partial
from itertools import compress
from typing import Any

from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from usdsdg.arguments.prims import prim_at
from usdsdg.arguments.values import vector
from usdsdg.distribution import Distribution, draw
from usdsdg.errors import GraphError, let_pass, warn_once
from usdsdg.functional.physics import (
    DEFAULTS_PHYSICS_SCENE,
    apply_collider,
    apply_rigid_body,
    create_physics_scene,
    remove_rigid_body,
)
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act, act_now
from usdsdg.graph.node import Node, ReplicatorItem, current_prims, prim_paths, why_no_prims
from usdsdg.modify.numbers import draw_numbers
from usdsdg.modify.prims import target_prims
from usdsdg.stage.attribute_batch import write_batch
from usdsdg.stage.geometry.instancers import SAMPLED_ASSETS
from usdsdg.stage.physics import scenes
from usdsdg.stage.physics.rigid_bodies import set_simulation_owner


def collider(
    approximation_shape: str = "convexHull", contact_offset: Any = None, rest_offset: Any = None,
    physics_scene: Any = None, input_prims: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Make every gprim at and below the prims a collider, at once; warn of a prim without a gprim, and leave it out.

    Instances become ordinary prims, with a warning, since gprims inside of an instance cannot be edited.

    Args:
        approximation_shape: approximation of meshes, as for `functional.physics.apply_collider`.
        contact_offset: distance below which contacts are generated [stage units], or a distribution of which one is
            drawn for each prim at each execution.
        rest_offset: distance that colliders keep at rest [stage units], likewise.
        physics_scene: item, prim or path of the PhysicsScene that becomes their simulationOwner. Our own engine
            simulates everything in the stage's first PhysicsScene, and warns where there are several.

    Raises:
        BadPrim: there is no prim at `physics_scene`.
        GraphError: it is not a PhysicsScene, there is no such approximation, or there are no prims.
    """
    prims, scene = prim_paths(input_prims) or current_prims(), _scene_of(physics_scene)
    if not prims:
        let_pass(GraphError(f"physics.collider has no prims: {why_no_prims(input_prims)}"))
    fixed, drawn = _offsets(contact_offset, rest_offset)
    for prim in map(prim_at, prims):
        _add_colliders(prim, approximation_shape, collisionEnabled=True, **fixed)
        for shape in _colliders(prim):
            set_simulation_owner(shape, scene)
    _draw_offsets(prims, drawn)
    return ReplicatorItem(Node(kind="OgnCollider", prims=prims))


def rigid_body(
    velocity: Any = (0.0, 0.0, 0.0), angular_velocity: Any = None, contact_offset: Any = None,
    rest_offset: Any = None, overwrite: bool = False, physics_scene: Any = None, input_prims: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Make prims rigid bodies, with convex colliders where they have none, and set their velocities.

    Inside a trigger velocities are written each time it fires; outside, at once, those that a distribution draws at the
    next evaluation of the graph or when the timeline begins to play. Assets that `randomizer.instantiate` draws later
    get colliders too, at the execution that shows them.

    A stage without PhysicsScene gets Replicator's: /PhysicsScene with 240 steps per second, CCD, and no GPU dynamics.

    Bodies do not nest: a prim above a rigid body is left as it is, with a warning, unless `overwrite`. New bodies get
    the highest velocities of `functional.physics.DEFAULTS_RIGID_BODY`.

    Args:
        velocity: (x, y, z) along world axes [stage units / s]: one for all, a list of one per prim, or a distribution;
            None leaves it as it is.
        angular_velocity: about world axes [degrees / s], likewise.
        contact_offset: of new and existing colliders, as is `rest_offset`; see `collider`.
        overwrite: apply the schemas also where prims have colliders or are rigid bodies; rigid bodies below stop being
            some.
        physics_scene: as for `collider`.

    Raises:
        BadPrim: as `collider`, or there is no PhysicsScene and another prim is at /PhysicsScene.
        GraphError: as `collider`, or a velocity is not three numbers; at execution, where it is written then.
    """
    scene = _scene_of(physics_scene)
    offsets, drawn_offsets = _offsets(contact_offset, rest_offset)
    velocities: dict[str, Any] = dict(velocity=velocity, angular_velocity=angular_velocity)
    prims = prim_paths(input_prims) or current_prims()
    drawn_later = any(isinstance(each, Distribution) for each in velocities.values()) or any(map(_is_sampled, prims))
    if prims and scenes.physics_scene(prim_at(prims[0]).GetStage()) is None:
        create_physics_scene(**DEFAULTS_PHYSICS_SCENE)
    for prim in map(prim_at, prims):
        if not _keeps_bodies_below(prim, overwrite):
            _make_body(prim, overwrite, offsets)
            set_simulation_owner(prim, scene)
    start = act if drawn_later or not prims else act_now
    item = start("OgnRigidBody", input_prims, attribute="physics:velocity", **velocities, **offsets)
    _draw_offsets(prims, drawn_offsets)
    return item


def _offsets(contact_offset: Any, rest_offset: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the offsets of colliders that are fixed, and those that are drawn, by the names of their attributes."""
    given = dict(contactOffset=contact_offset, restOffset=rest_offset)
    drawn = {name: value for name, value in given.items() if isinstance(value, Distribution)}
    return {name: None if name in drawn else value for name, value in given.items()}, drawn


def _draw_offsets(prims: tuple[str, ...], drawn: dict[str, Any]) -> None:
    if drawn:
        act("OgnColliderOffsets", prims, attribute=",".join(f"physxCollision:{name}" for name in drawn), **drawn)


@action("OgnColliderOffsets", "contactOffset", "restOffset")
def _write_offsets(node: Node, execution: int) -> None:
    for name in (name for name in ("contactOffset", "restOffset") if name in node.inputs):
        for prim, offset in zip(target_prims(node), draw_numbers(name, node, execution).tolist()):
            for shape in (each for each in _colliders(prim) if not each.IsInstanceProxy()):
                shape.GetAttribute(f"physxCollision:{name}").Set(offset)


def _keeps_bodies_below(prim: Usd.Prim, overwrite: bool) -> bool:
    """Whether bodies below a prim keep it from being one; where they are overwritten they stop being bodies instead."""
    nested = [each for each in Usd.PrimRange(prim) if each != prim and each.HasAPI(UsdPhysics.RigidBodyAPI)]
    if nested and not overwrite:
        warn_once(
            f"physics.rigid_body: {prim.GetPath()} is not made a rigid body and gets no velocity, since "
            f"{nested[0].GetPath()} below it is a rigid body already; give overwrite=True to make it one instead of "
            "what is below, or give the prims below, as by rep.get.prims"
        )
        return True
    remove_rigid_body(nested)
    return False


def _make_body(prim: Usd.Prim, overwrite: bool, offsets: dict[str, Any]) -> None:
    if not prim.IsActive():
        pass  # its asset gets colliders when it is shown
    elif overwrite or not (existing := _colliders(prim)):
        _add_colliders(prim, "convexHull", collisionEnabled=True, **offsets)
    elif any(offset is not None for offset in offsets.values()):
        for shape in existing:
            _add_colliders(shape, None, **offsets)
    if overwrite or not prim.HasAPI(UsdPhysics.RigidBodyAPI):
        apply_rigid_body(prim, overwrite_rigid_body=False, with_collider=False, rigidBodyEnabled=True)


def _is_sampled(path: str) -> bool:
    """Return whether an execution of `randomizer.instantiate` decides which asset is at a path."""
    return path.startswith(f"{SAMPLED_ASSETS}/")


def _add_colliders_to_sampled(node: Node) -> None:
    """Make members of populations colliders that have changed to another asset."""
    offsets = {name: node.inputs.get(name) for name in ("contactOffset", "restOffset")}
    for path in node.prims:
        if _is_sampled(path) and prim_at(path).IsActive() and not _colliders(prim_at(path)):
            _add_colliders(prim_at(path), "convexHull", collisionEnabled=True, **offsets)


@action("OgnRigidBody", "velocity", "angular_velocity", "contactOffset", "restOffset")
def _write_velocities(node: Node, execution: int) -> None:
    _add_colliders_to_sampled(node)
    prims = target_prims(node)
    # Prims above other bodies are none.
    are_bodies = [prim.HasAPI(UsdPhysics.RigidBodyAPI) for prim in prims]
    bodies = [UsdPhysics.RigidBodyAPI(prim) for prim in compress(prims, are_bodies)]
    create = {
        "velocity": UsdPhysics.RigidBodyAPI.CreateVelocityAttr,
        "angular_velocity": UsdPhysics.RigidBodyAPI.CreateAngularVelocityAttr,
    }
    for role in (role for role in create if role in node.inputs):
        values = list(compress(draw(node.inputs[role], node, execution, role), are_bodies))
        if not write_batch(node.state, role, partial(list, map(create[role], bodies)), values):
            for body, value in zip(bodies, values):
                create[role](body).Set(Gf.Vec3f(vector(role, value)))


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
