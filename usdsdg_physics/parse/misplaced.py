"""What is authored for physics and not read as meant: without its schema, for an axis that a joint lacks, in part."""

from __future__ import annotations

from functools import cache

from pxr import Usd

from usdsdg_physics.parse.attributes import (
    COLLISION,
    CONTACT_REPORT,
    FORCE,
    MASS,
    RIGID_BODY,
    SURFACE_VELOCITY,
    finite,
    value,
)
from usdsdg_physics.parse.joints.joint_axes import free_axes
from usdsdg_physics.parse.joints.joint_types import is_supported
from usdsdg_physics.parse.schema_table import READ, Unread

_JOINT, _SCENE = "a joint", "PhysicsScene"
_ROOT, _MATERIAL = "PhysicsArticulationRootAPI", "PhysicsMaterialAPI"

# Schema -> what its attributes need on their prim: each group one of its names, an applied schema or the type.
_NEEDS: dict[str, tuple[tuple[str, ...], ...]] = {
    "PhysicsScene": ((_SCENE,),),
    "PhysicsRigidBodyAPI": ((RIGID_BODY,),),
    "PhysicsMassAPI": ((MASS,), (RIGID_BODY, COLLISION)),
    "PhysicsCollisionAPI": ((COLLISION,),),
    "PhysicsMeshCollisionAPI": ((COLLISION,),),
    "PhysicsMaterialAPI": ((_MATERIAL,),),
    "PhysicsFilteredPairsAPI": (("PhysicsFilteredPairsAPI",),),
    "PhysicsJoint": ((_JOINT,),),
    "PhysxSceneAPI": ((_SCENE,),),
    "PhysxRigidBodyAPI": ((RIGID_BODY,),),
    "PhysxCollisionAPI": ((COLLISION,),),
    "PhysxConvexDecompositionCollisionAPI": ((COLLISION,),),
    "PhysxForceAPI": ((FORCE,),),
    "PhysxSurfaceVelocityAPI": ((SURFACE_VELOCITY,),),
    "PhysxContactReportAPI": ((CONTACT_REPORT,),),
    "PhysxMaterialAPI": ((_MATERIAL,),),
    "PhysxPhysicsDistanceJointAPI": (("PhysxPhysicsDistanceJointAPI",), ("PhysicsDistanceJoint",)),
    "PhysxJointAPI": ((_JOINT,),),
    "PhysxArticulationAPI": ((_ROOT,),),
}
# Head of the attributes of schemas that a joint has for an axis.
_OF_AXES = {
    "drive": "PhysicsDriveAPI",
    "limit": "PhysicsLimitAPI",
    "state": "PhysicsJointStateAPI",
    "physxJointAxis": "PhysxJointAxisAPI",
    "physxMimicJoint": "PhysxMimicJointAPI",
}
_LIMITED = ("transX", "transY", "transZ", "rotX", "rotY", "rotZ", "distance")

_SAMPLED = Unread(
    "",
    "physics does not follow time samples and splines of these, which keep the value that they have when the "
    "simulation begins. Set them from a script while physics plays",
)
_OF_SUBSETS = Unread("", "a collider has one material, so those of subsets of its faces have no effect. Split the mesh")
_SKINNED = Unread(
    "",
    "skinned meshes collide in the shape of their points: skeletons do not move colliders. Make bodies of the bones, "
    "with colliders and physics:kinematicEnabled",
)
_PYRAMID = Unread(
    "",
    "limits of a spherical joint are those of a pyramid: in its corners, between the directions of both, it swings "
    "farther than PhysX's cone, with 30 degrees by 41",
)
_CONES = ("physics:coneAngle0Limit", "physics:coneAngle1Limit")
_WRITTEN = ("physics:velocity", "physics:angularVelocity")


def misplaced_attribute(prim: Usd.Prim, name: str) -> Unread | None:
    """Return what follows from an attribute that is read elsewhere but not on this prim; None where it is read."""
    head, _, rest = name.partition(":")
    if head in _OF_AXES and rest.partition(":")[2]:
        return _misplaced_axis(prim, head, rest.partition(":")[0])
    alternatives = _needs_of(name)
    if not alternatives or any(_fits(prim, needs) for needs in alternatives):
        return None
    missing = [next(group for group in needs if not _has_one(prim, group)) for needs in alternatives]
    listed = dict.fromkeys(name for group in missing for name in group)
    return Unread("", f"these have no effect on a prim without {' or '.join(listed)}")


def misplaced_schema(prim: Usd.Prim, schema: str) -> Unread | None:
    """Return what follows from an applied schema that another one lacks beside it."""
    if schema == "PhysxTriggerAPI" and not _is(prim, COLLISION):
        return Unread("", f"nothing triggers without {COLLISION}")
    return None


def sampled_attribute(attribute: Usd.Attribute) -> Unread | None:
    """Return what follows from time samples of an attribute that is read; None where there are none that vary."""
    name = attribute.GetName()
    # Targets are named where drives are read; what steps write may be recorded beside the default that is read.
    if ":target" in name or not attribute.ValueMightBeTimeVarying():
        return None
    written = name in _WRITTEN or name.startswith("state:") or name == "physxTrigger:triggeredCollisions"
    default = attribute.GetResolveInfo(Usd.TimeCode.Default()).GetSource() == Usd.ResolveInfoSourceDefault
    return None if written and default else _SAMPLED


def partly_read(prim: Usd.Prim, names: list[str]) -> tuple[str, Unread] | None:
    """Return a property that has less effect than it says, by what is beside it, and what follows; None for most."""
    if "material:binding:physics" in names and prim.GetTypeName() == "GeomSubset":
        return "material:binding:physics", _OF_SUBSETS
    if "primvars:skel:jointIndices" in names and _is(prim, COLLISION):
        return "primvars:skel:jointIndices", _SKINNED
    if _CONES[0] in names and all(finite(value(prim, name, -1.0), -1.0) > 0.0 for name in _CONES):
        return _CONES[0], _PYRAMID
    return None


def _misplaced_axis(prim: Usd.Prim, head: str, instance: str) -> Unread | None:
    schema = f"{_OF_AXES[head]}:{instance}"
    if head != "physxJointAxis" and schema not in prim.GetAppliedSchemas():  # these are read without it
        return Unread("", f"these have no effect on a prim without {schema}")
    if not _is(prim, _JOINT):
        return Unread("", "these have no effect on a prim that is no joint")
    if head == "physxMimicJoint" or not is_supported(prim):
        return None
    if head == "limit":
        if prim.GetTypeName() == "PhysicsJoint" and instance in _LIMITED:
            return None
        return Unread(
            "", f"these have no effect: limits by axis are those of a PhysicsJoint, for {', '.join(_LIMITED)}"
        )
    if instance in free_axes(prim) and not (head == "drive" and prim.GetTypeName() == "PhysicsSphericalJoint"):
        return None
    return Unread("", "these have no effect on a joint of such a type, or that locks the axis of that name")


def _fits(prim: Usd.Prim, needs: tuple[tuple[str, ...], ...]) -> bool:
    return all(_has_one(prim, group) for group in needs)


def _has_one(prim: Usd.Prim, group: tuple[str, ...]) -> bool:
    return any(_is(prim, need) for need in group)


def _is(prim: Usd.Prim, need: str) -> bool:
    kind = str(prim.GetTypeName())
    if need == _JOINT:
        return kind.startswith("Phys") and kind.endswith("Joint")
    return kind == need or need in prim.GetAppliedSchemas()


@cache
def _needs_of(name: str) -> tuple[tuple[tuple[str, ...], ...], ...]:
    """Return for each schema with such an attribute what it needs; nothing where one needs nothing."""
    found = [schema for schema, names in READ.items() if name in names.split()]
    if "PhysicsJoint" in found:  # the types of joints repeat its attributes
        found = [schema for schema in found if schema == "PhysicsJoint" or not schema.endswith("Joint")]
    needs = [_NEEDS.get(schema, ((schema,),) if schema.endswith(("Joint", "Group")) else ()) for schema in found]
    return tuple(needs) if all(needs) else ()
