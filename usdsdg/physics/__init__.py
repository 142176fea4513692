"""UsdPhysics schemas and their randomization. Authors the stage, simulates nothing. Mirrors `rep.physics`."""

from __future__ import annotations

from typing import Any

from pxr import Gf, Usd, UsdGeom, UsdPhysics

from usdsdg.arguments.values import vector
from usdsdg.distribution import draw
from usdsdg.errors import GraphError, NoCollider, warn_once
from usdsdg.functional.physics import apply_collider
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act
from usdsdg.graph.node import Node, ReplicatorItem, current_prims, prim_paths, why_no_prims
from usdsdg.modify.numbers import draw_numbers
from usdsdg.modify.prims import prim_at, prims_of
from usdsdg.physics.properties import drive_properties, physics_material
from usdsdg.physics.steps import reset, simulate
from usdsdg.stage.attribute_batch import write_batch
from usdsdg.stage.geometry.populations import SAMPLED
from usdsdg.stage.physics.rigid_bodies import apply_rigid_body_schemas, set_simulation_owner

__all__ = ["collider", "drive_properties", "mass", "physics_material", "reset", "rigid_body", "simulate"]


def _colliders(prim: Usd.Prim) -> list[Usd.Prim]:
    below = Usd.PrimRange(prim, Usd.TraverseInstanceProxies())
    return [child for child in below if child.IsA(UsdGeom.Gprim) and child.HasAPI(UsdPhysics.CollisionAPI)]


def _collide(prim: Usd.Prim, approximation: str | None, **attributes: Any) -> None:
    try:
        apply_collider(prim, None, approximation, **attributes)
    except NoCollider as error:
        # A group may hold lights and cameras beside things.
        warn_once(str(error))


def _scene_of(physics_scene: Any) -> Usd.Prim | None:
    """Return the PhysicsScene given as prim, path or item; None for None."""
    if physics_scene is None:
        return None
    scenes = [prim for prim in map(prim_at, prim_paths(physics_scene)) if prim.IsA(UsdPhysics.Scene)]
    if len(scenes) != 1:
        raise GraphError(f"physics_scene={physics_scene!r} is not one PhysicsScene; define it with UsdPhysics.Scene")
    return scenes[0]


def collider(
    approximation_shape: str = "convexHull", contact_offset: float | None = None, rest_offset: float | None = None,
    physics_scene: Any = None, input_prims: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Make every shape at and below the prims collide, now. A prim without a shape is left out, with a warning.

    Instances become ordinary prims, with a warning, since the shapes inside of an instance cannot be edited.

    Args:
        approximation_shape: of meshes, as for `functional.physics.apply_collider`.
        contact_offset: distance at which contacts are made [stage units].
        rest_offset: distance that things keep when they lie on each other [stage units].
        physics_scene: item, prim or path, which becomes their simulationOwner. Our own engine simulates everything in
            the stage's first scene, and warns where there are several.

    Raises:
        BadPrim: there is no prim at `physics_scene`.
        GraphError: it is not a PhysicsScene, there is no such approximation, or there are no prims.
    """
    prims, scene = prim_paths(input_prims) or current_prims(), _scene_of(physics_scene)
    if not prims:
        raise GraphError(f"physics.collider has no prims: {why_no_prims(input_prims)}")
    offsets = dict(contactOffset=contact_offset, restOffset=rest_offset)
    for prim in map(prim_at, prims):
        _collide(prim, approximation_shape, collisionEnabled=True, **offsets)
        for shape in _colliders(prim):
            set_simulation_owner(shape, scene)
    return ReplicatorItem(Node(kind="OgnCollider", prims=prims))


def rigid_body(
    velocity: Any = (0.0, 0.0, 0.0), angular_velocity: Any = None, contact_offset: float | None = None,
    rest_offset: float | None = None, overwrite: bool = False, physics_scene: Any = None, input_prims: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Make prims rigid bodies, with convex colliders where they have none, and set their velocities at each firing.

    What `randomizer.instantiate` draws later gets colliders too, at the firing that shows it.

    Args:
        velocity: (x, y, z) along world axes [stage units / s], for all, per prim or drawn.
        angular_velocity: about world axes [degrees / s], likewise.
        contact_offset: of the colliders, also of those that were there, as is `rest_offset`; see `collider`.
        overwrite: give prims new colliders and a new body where they have some.
        physics_scene: as for `collider`.

    Raises:
        BadPrim, GraphError: as `collider`; GraphError at execution, where a velocity is not three numbers.
    """
    scene = _scene_of(physics_scene)
    offsets = dict(contactOffset=contact_offset, restOffset=rest_offset)
    velocities = dict(velocity=velocity, angular_velocity=angular_velocity)
    item = act("OgnRigidBody", input_prims, attribute="physics:velocity", **velocities, **offsets)
    for path in item.prims:
        prim = prim_at(path)
        if overwrite or not (there := _colliders(prim)):
            _collide(prim, "convexHull", collisionEnabled=True, **offsets)
        elif any(offset is not None for offset in offsets.values()):
            for shape in there:
                _collide(shape, None, **offsets)
        if overwrite or not prim.HasAPI(UsdPhysics.RigidBodyAPI):
            apply_rigid_body_schemas(prim).CreateRigidBodyEnabledAttr(True)
        set_simulation_owner(prim, scene)
    return item


def _collide_drawn(node: Node) -> None:
    """Give colliders to members of populations that show another asset by now."""
    offsets = {name: node.inputs.get(name) for name in ("contactOffset", "restOffset")}
    for path in node.prims:
        if path.startswith(f"{SAMPLED}/") and not _colliders(prim_at(path)):
            _collide(prim_at(path), "convexHull", collisionEnabled=True, **offsets)


@action("OgnRigidBody")
def _write_velocities(node: Node, execution: int) -> None:
    _collide_drawn(node)
    linear = draw(node.inputs["velocity"], node, execution, "velocity")
    turning = node.inputs.get("angular_velocity")
    angular = None if turning is None else draw(turning, node, execution, "angular_velocity")
    bodies = [UsdPhysics.RigidBodyAPI(prim) for prim in prims_of(node)]
    if not write_batch(node.state, "linear", lambda: [body.CreateVelocityAttr() for body in bodies], linear):
        for body, value in zip(bodies, linear):
            body.CreateVelocityAttr().Set(Gf.Vec3f(vector("velocity", value)))
    if angular is None:
        return
    if not write_batch(node.state, "angular", lambda: [body.CreateAngularVelocityAttr() for body in bodies], angular):
        for body, value in zip(bodies, angular):
            body.CreateAngularVelocityAttr().Set(Gf.Vec3f(vector("angular_velocity", value)))


def mass(
    mass: Any = None, density: Any = None, center_of_mass: Any = None, diagonal_inertia: Any = None,
    principal_axes: Any = None, input_prims: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Author mass properties at each firing; each is one for all, a list of one per prim, or a distribution.

    Args:
        mass: kilograms, in units of the stage's kilogramsPerUnit.
        density: mass per cubic stage unit; used where there is no mass.
        center_of_mass: (x, y, z) in the prim's own space [stage units].
        diagonal_inertia: moments of inertia about the principal axes [mass × stage units²].
        principal_axes: rotation from the prim's axes to the principal ones, as a quaternion (w, x, y, z).

    Raises:
        GraphError: at execution, a value has another shape.
    """
    given = dict(
        mass=mass, density=density, centerOfMass=center_of_mass, diagonalInertia=diagonal_inertia,
        principalAxes=principal_axes,
    )  # fmt: skip
    return act("OgnMass", input_prims, attribute="mass", **given)


@action("OgnMass")
def _write_mass(node: Node, execution: int) -> None:
    for name, value in node.inputs.items():
        if name in _MASS:
            of_numbers = name in ("mass", "density")
            drawn = draw_numbers(name, node, execution).tolist() if of_numbers else draw(value, node, execution, name)
            _write_mass_property(node, name, drawn)


# The attributes of MassAPI that `mass` writes, by input.
_MASS = {
    "mass": "CreateMassAttr",
    "density": "CreateDensityAttr",
    "centerOfMass": "CreateCenterOfMassAttr",
    "diagonalInertia": "CreateDiagonalInertiaAttr",
    "principalAxes": "CreatePrincipalAxesAttr",
}


def _write_mass_property(node: Node, name: str, values: list[Any]) -> None:
    def find() -> list[Usd.Attribute]:
        return [getattr(UsdPhysics.MassAPI.Apply(prim), _MASS[name])() for prim in prims_of(node)]

    if name != "principalAxes" and write_batch(node.state, name, find, values):
        return
    for attribute, value in zip(find(), values):
        attribute.Set(_mass_value(name, value))


def _mass_value(name: str, value: Any) -> Any:
    if name == "principalAxes":
        w, *xyz = vector("principal_axes", value, 4)
        return Gf.Quatf(w, Gf.Vec3f(xyz)).GetNormalized()
    words = {"centerOfMass": "center_of_mass", "diagonalInertia": "diagonal_inertia"}
    return Gf.Vec3f(vector(words[name], value)) if name in words else float(value)
