"""UsdPhysics schemas and their randomization. Authors the stage, simulates nothing. Mirrors `rep.physics`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pxr import Gf, Usd, UsdGeom, UsdPhysics

from usdsdg.distribution import draw
from usdsdg.errors import GraphError
from usdsdg.graph.evaluate import act
from usdsdg.graph.kinds import action
from usdsdg.graph.node import Node, ReplicatorItem, current_prims, prim_paths
from usdsdg.modify.prims import prim_at, prims_of
from usdsdg.physics_properties import drive_properties, physics_material
from usdsdg.physics_steps import reset, simulate
from usdsdg.stage.attribute_batch import write_batch
from usdsdg.stage.schemas import physx
from usdsdg.values import vector

__all__ = ["collider", "drive_properties", "mass", "physics_material", "reset", "rigid_body", "simulate"]


def _gprims(prim: Usd.Prim) -> list[Usd.Prim]:
    return [child for child in Usd.PrimRange(prim) if child.IsA(UsdGeom.Gprim)]


def _apply_collider(
    prim: Usd.Prim, approximation: str | None, contact_offset: float | None, rest_offset: float | None
) -> None:
    for gprim in _gprims(prim):
        UsdPhysics.CollisionAPI.Apply(gprim).CreateCollisionEnabledAttr(True)
        if gprim.IsA(UsdGeom.Mesh) and approximation is not None:
            UsdPhysics.MeshCollisionAPI.Apply(gprim).CreateApproximationAttr(approximation)
        if contact_offset is not None or rest_offset is not None:
            api = physx.PhysxCollisionAPI.Apply(gprim)
            if contact_offset is not None:
                api.CreateContactOffsetAttr(float(contact_offset))
            if rest_offset is not None:
                api.CreateRestOffsetAttr(float(rest_offset))


def _scene_path(physics_scene: Any) -> str | None:
    """The path of a PhysicsScene given as prim, path or item."""
    if physics_scene is None:
        return None
    scenes = [path for path in prim_paths(physics_scene) if prim_at(path).IsA(UsdPhysics.Scene)]
    if len(scenes) != 1:
        raise GraphError(f"physics_scene={physics_scene!r} is not one PhysicsScene; define it with UsdPhysics.Scene")
    return scenes[0]


def _assign_scene(prims: Iterable[Usd.Prim], scene: str | None) -> None:
    for prim in prims if scene else ():
        prim.CreateRelationship("physics:simulationOwner", custom=False).SetTargets([scene])


def collider(
    approximation_shape: str = "convexHull", contact_offset: float | None = None, rest_offset: float | None = None,
    physics_scene: Any = None, input_prims: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Make every gprim below the prims collide; meshes through `approximation_shape`.

    `physics_scene` becomes their simulationOwner. Our own engine simulates everything in the stage's first scene, and
    warns where there are several.

    Raises:
        BadPrim: there is no prim at `physics_scene`.
        GraphError: it is not a PhysicsScene.
    """
    prims, scene = prim_paths(input_prims) or current_prims(), _scene_path(physics_scene)
    for path in prims:
        _apply_collider(prim_at(path), approximation_shape, contact_offset, rest_offset)
        _assign_scene(_gprims(prim_at(path)), scene)
    return ReplicatorItem(Node(kind="OgnCollider", prims=prims))


def rigid_body(
    velocity: Any = (0.0, 0.0, 0.0), angular_velocity: Any = None, contact_offset: float | None = None,
    rest_offset: float | None = None, overwrite: bool = False, physics_scene: Any = None, input_prims: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Make prims rigid bodies (with colliders where they have none) and set their velocities at each firing.

    `velocity` is in stage units per second and `angular_velocity` in degrees per second, both along world axes.
    `physics_scene` is as for `collider`.
    """

    scene = _scene_path(physics_scene)
    velocities = dict(velocity=velocity, angular_velocity=angular_velocity)
    item = act("OgnRigidBody", input_prims, attribute="physics:velocity", **velocities)
    for path in item.prims:
        prim = prim_at(path)
        if overwrite or not any(gprim.HasAPI(UsdPhysics.CollisionAPI) for gprim in _gprims(prim)):
            _apply_collider(prim, "convexHull", contact_offset, rest_offset)
        if overwrite or not prim.HasAPI(UsdPhysics.RigidBodyAPI):
            UsdPhysics.RigidBodyAPI.Apply(prim).CreateRigidBodyEnabledAttr(True)
            physx.PhysxRigidBodyAPI.Apply(prim)
    _assign_scene(map(prim_at, item.prims), scene)
    return item


@action("OgnRigidBody")
def _write_velocities(node: Node, execution: int) -> None:
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
    """Author mass properties at each firing.

    Args:
        mass: kilograms, in units of the stage's kilogramsPerUnit.
        density: mass per cubic stage unit; used where there is no mass.
        center_of_mass: (x, y, z) in the prim's own space [stage units].
        diagonal_inertia: moments of inertia about the principal axes [mass × stage units²].
        principal_axes: rotation from the prim's axes to the principal ones, as a quaternion (w, x, y, z).
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
            _write_mass_property(node, name, draw(value, node, execution, name))


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
