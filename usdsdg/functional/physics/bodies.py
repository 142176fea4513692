"""Make prims rigid bodies and colliders, and set their physics attributes."""

from typing import Any

from pxr import Usd, UsdPhysics, UsdShade

from usdsdg.arguments.prims import prims_of
from usdsdg.arguments.registry import near_misses
from usdsdg.errors import ArgumentError, BadPrim, warn_once
from usdsdg.functional.arguments import per_prim
from usdsdg.functional.physics.scenes import take_owner
from usdsdg.functional.physics.schema_attributes import set_attributes
from usdsdg.stage.attributes import attribute_of, set_value
from usdsdg.stage.physics.rigid_bodies import (
    apply_collision_schemas,
    apply_rigid_body_schemas,
    gprims_below,
    set_approximation,
    set_simulation_owner,
)
from usdsdg.stage.poses.transforms import meters_per_unit
from usdsdg.stage.schemas import physx

VALID_COLLIDER_APPROXIMATIONS = [
    "none", "convexDecomposition", "convexHull", "boundingSphere", "boundingCube", "meshSimplification", "sdf",
    "sphereFill",
]  # fmt: skip
# Those of Replicator, velocities in m/s. Of these `apply_rigid_body` gives `_LIMITS` and the approximation by default.
DEFAULTS_RIGID_BODY: dict[str, Any] = {
    "maxDepenetrationVelocity": 100000, "angularDamping": 0.001, "maxLinearVelocity": 1000, "maxAngularVelocity": 2500,
    "enableCCD": True, "solverPositionIterationCount": 128, "approximation": "convexHull",
}  # fmt: skip
_LIMITS = ("maxLinearVelocity", "maxDepenetrationVelocity")
_MATERIAL_ATTRIBUTES = ("physics:staticFriction", "physics:dynamicFriction", "physics:restitution")
_INSTANCER_ATTRIBUTES = {"physics:velocity": "velocities", "physics:angularVelocity": "angularVelocities"}
_DRIVE_ATTRIBUTES = {"rep:physics:resolveStiffness": "stiffness", "rep:physics:resolveDamping": "damping"}
_DRIVE_OF_JOINT = {"PhysicsPrismaticJoint": "linear", "PhysicsRevoluteJoint": "angular"}


def apply_rigid_body(
    prims: Any, physics_scene: Any = None, overwrite_rigid_body: bool = True, with_collider: bool = True,
    approximation: str | None = None, **attributes: Any,
) -> None:  # fmt: skip
    """Make prims rigid bodies.

    Args:
        physics_scene: Path or prim of the PhysicsScene that simulates them; a path may be that of a later one.
        overwrite_rigid_body: Whether rigid bodies below a prim stop being rigid bodies, since they must not nest;
            otherwise a prim with such a body is left as it is, with a warning.
        with_collider: Whether all gprims at and below a prim become colliders, as by `apply_collider`.
        approximation: Of meshes; "convexHull" by default.
        attributes: Attributes of RigidBodyAPI and PhysxRigidBodyAPI, with or without the prefix: `velocity` [stage
            units/s], `angularVelocity` [degrees/s], `kinematicEnabled`, `disableGravity`, ... The maximum linear
            velocity is 1000 m/s and the maximum depenetration velocity 100000 m/s unless given.

    Raises:
        BadPrim: there is no such attribute, or `physics_scene` is no PhysicsScene.
    """
    owner = take_owner(attributes, physics_scene)
    given = {name.rpartition(":")[2].casefold() for name in attributes}
    for prim in prims_of(prims):
        nested = [each for each in Usd.PrimRange(prim) if each != prim and each.HasAPI(UsdPhysics.RigidBodyAPI)]
        if nested and not overwrite_rigid_body:
            warn_once(f"{prim.GetPath()} is not made a rigid body: {nested[0].GetPath()} below it is one already")
            continue
        remove_rigid_body(nested)
        apply_rigid_body_schemas(prim)
        unit = 1.0 / meters_per_unit(prim.GetStage())
        defaults = {name: DEFAULTS_RIGID_BODY[name] * unit for name in _LIMITS}
        missing = {name: value for name, value in defaults.items() if name.casefold() not in given}
        set_attributes(prim, missing | attributes, ("physics", "physxRigidBody"))
        set_simulation_owner(prim, owner)
        if with_collider:
            apply_collider(prim, owner, approximation or DEFAULTS_RIGID_BODY["approximation"])


def apply_collider(prims: Any, physics_scene: Any = None, approximation: str | None = None, **attributes: Any) -> None:
    """Make every gprim at and below prims a collider.

    A prim without gprims becomes one itself, as in Replicator, with a warning: nothing collides with it.

    Args:
        physics_scene: Path or prim of the PhysicsScene that simulates them; a path may be that of a later one.
        approximation: Of meshes: "none" (the triangles; the default, for static colliders), "convexHull",
            "convexDecomposition", "boundingSphere", "boundingCube", "meshSimplification", "sdf", "sphereFill".
        attributes: Attributes of CollisionAPI and PhysxCollisionAPI, with or without the prefix: `collisionEnabled`,
            `contactOffset` and `restOffset` [stage units], ...

    Raises:
        BadPrim: there is no such attribute, or `physics_scene` is no PhysicsScene.
        ArgumentError: unknown approximation.
    """
    if approximation is not None and approximation not in VALID_COLLIDER_APPROXIMATIONS:
        near = near_misses(approximation, VALID_COLLIDER_APPROXIMATIONS)
        hint = f"did you mean {near[0]!r}?" if near else f"expected one of {', '.join(VALID_COLLIDER_APPROXIMATIONS)}"
        raise ArgumentError(f"approximation is {approximation!r}; {hint}")
    owner = take_owner(attributes, physics_scene)
    for prim in prims_of(prims):
        _uninstance(prim)
        gprims = list(gprims_below(prim))
        if not gprims:
            warn_once(
                f"{prim.GetPath()} has no shape or mesh at or below it: it is a collider without a shape, and nothing "
                "collides with it"
            )
        for gprim in gprims or [prim]:
            apply_collision_schemas(gprim, sdf=approximation == "sdf")
            if approximation is not None:
                set_approximation(gprim, approximation)
            set_attributes(gprim, attributes, ("physics", "physxCollision"))
            set_simulation_owner(gprim, owner)


def remove_rigid_body(prims: Any) -> None:
    """Remove the schemas of rigid bodies from prims; the prims below them stay as they are."""
    for prim in prims_of(prims):
        _remove(prim, UsdPhysics.RigidBodyAPI, physx.PhysxRigidBodyAPI)


def remove_collider(prims: Any) -> None:
    """Remove the schemas of colliders from every prim at or below prims."""
    apis = (
        UsdPhysics.CollisionAPI, UsdPhysics.MeshCollisionAPI, physx.PhysxCollisionAPI, physx.PhysxSDFMeshCollisionAPI,
    )  # fmt: skip
    for prim in prims_of(prims):
        for each in Usd.PrimRange(prim):
            _remove(each, *apis)


def modify_attribute(prims: Any, attribute_name: str, value: Any) -> None:
    """Set a physics attribute, by its full name, to one value or to one per prim.

    Friction and restitution of a prim that is no material are set on the material bound to it.
    "rep:physics:resolveStiffness" and "rep:physics:resolveDamping" mean the drive of a prismatic or revolute joint.
    The velocities of a PointInstancer are those of its instances.

    Raises:
        BadPrim: a prim has no such attribute, no material bound, or is another kind of joint.
        BadValue: the attribute does not take the value.
    """
    targets = prims_of(prims)
    values = per_prim(value, len(targets)) if isinstance(prims, (list, tuple)) else [value] * len(targets)
    for prim, each in zip(targets, values):
        set_value(_attribute(prim, attribute_name), each)


def _attribute(prim: Usd.Prim, name: str) -> Usd.Attribute:
    """Return the attribute that `modify_attribute` sets."""
    if prim.GetTypeName() == "PointInstancer" and name in _INSTANCER_ATTRIBUTES:
        return prim.GetAttribute(_INSTANCER_ATTRIBUTES[name])
    if name in _DRIVE_ATTRIBUTES:
        kind = _DRIVE_OF_JOINT.get(str(prim.GetTypeName()))
        if kind is None:
            raise BadPrim(
                f"{prim.GetPath()} is a {prim.GetTypeName()}; {name} needs a prismatic or revolute joint. Pass the "
                "full name of the attribute instead, such as drive:rotX:physics:stiffness"
            )
        return attribute_of(prim, f"drive:{kind}:physics:{_DRIVE_ATTRIBUTES[name]}")
    if name in _MATERIAL_ATTRIBUTES and not prim.IsA(UsdShade.Material):
        api = UsdShade.MaterialBindingAPI(prim)
        material = api.ComputeBoundMaterial("physics")[0] or api.ComputeBoundMaterial()[0]
        if not material:
            raise BadPrim(
                f"{prim.GetPath()} has no material, so it has no {name}; bind one with UsdPhysics.MaterialAPI"
            )
        prim = material.GetPrim()
    if name == "physics:approximation" and prim.HasAPI(UsdPhysics.CollisionAPI):
        return UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr()
    return attribute_of(prim, name)


def _uninstance(root: Usd.Prim) -> None:
    """Make instances at and below a prim ordinary prims, since gprims inside of an instance cannot be edited."""
    pending = [root]
    while pending:
        prim = pending.pop()
        if prim.IsInstance():
            warn_once(f"{prim.GetPath()} is an instance; to make its gprims colliders it becomes an ordinary prim")
            prim.SetInstanceable(False)
        pending.extend(prim.GetChildren())


def _remove(prim: Usd.Prim, *apis: type) -> None:
    for api in apis:
        if prim.HasAPI(api):
            prim.RemoveAPI(api)
