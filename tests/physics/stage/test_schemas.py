"""Nothing silent: every physics schema and attribute is read, or named once with what follows."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdPhysics, Vt

from tests.physics.mechanisms import drive, free_axes, joint
from tests.physics.scenes import add, new_stage, physics_material, playing, warnings_of
from usdsdg import errors
from usdsdg.stage.schemas import physx
from usdsdg_physics.parse.scene import parse
from usdsdg_physics.parse.schema_table import (
    READ,
    UNREAD,
    is_physics_attribute,
    is_physics_schema,
    unread_attribute,
    unread_schema,
)
from usdsdg_physics.parse.shapes.convex_hulls import HullCache

_USD_PROPERTIES = frozenset({"visibility", "purpose", "proxyPrim"})


def _registered() -> dict[str, list[str]]:
    """The physics schemas that USD knows here, with their properties: UsdPhysics, and our own of PhysX."""
    registry = Usd.SchemaRegistry()
    found = {}
    for name in map(Usd.SchemaRegistry.GetSchemaTypeName, Tf.Type.Find(Usd.SchemaBase).GetAllDerivedTypes()):
        definition = registry.FindAppliedAPIPrimDefinition(name) or registry.FindConcretePrimDefinition(name)
        if is_physics_schema(name) and definition:
            names = (each.replace("__INSTANCE_NAME__", "*") for each in definition.GetPropertyNames())
            found[name] = [each for each in names if each not in _USD_PROPERTIES]
    return found


def _of_nvidia() -> dict[str, list[str]]:
    """NVIDIA's schemas and their properties."""
    lines = (Path(__file__).parent / "physx_names.txt").read_text().splitlines()
    rows = (line.partition(":") for line in lines if not line.startswith("#"))
    return {schema: names.split() for schema, _, names in rows}


SCHEMAS = {**_registered(), **_of_nvidia()}
ATTRIBUTES = sorted({name for names in SCHEMAS.values() for name in names if is_physics_attribute(name)})


def test_the_registry_has_the_schemas_of_usdphysics_and_physx():
    assert {"PhysicsRigidBodyAPI", "PhysicsScene", "PhysxRigidBodyAPI"} <= _registered().keys()
    assert len(SCHEMAS) > 100
    assert len(ATTRIBUTES) > 400


@pytest.mark.parametrize("schema", sorted(SCHEMAS))
def test_every_schema_and_its_attributes_are_in_the_table(schema):
    unread = unread_schema(schema)
    assert unread is None or unread in UNREAD
    for name in SCHEMAS[schema]:
        row = unread_attribute(name) if is_physics_attribute(name) else unread
        read = name in READ.get(schema, "").split()
        # What is read of one schema may be a name that another one, which is not read, has too.
        assert row in UNREAD or read or (row is None and is_physics_attribute(name)), name


def test_actuators_and_settings_of_mujoco_and_newton_are_named():
    stage = new_stage()
    stage.DefinePrim("/Motor", "MjcActuator").CreateAttribute("mjc:ctrlRange:max", Sdf.ValueTypeNames.Double).Set(2.0)
    stage.DefinePrim("/Hinge", "PhysicsRevoluteJoint").CreateAttribute("newton:armature", Sdf.ValueTypeNames.Float).Set(
        1.0
    )
    with pytest.warns(errors.UsdsdgWarning, match=r"^/Motor, /Hinge: .*mjc:ctrlRange:max.*: schemas of MuJoCo and New"):
        parse(stage, hulls=HullCache())


def test_the_table_names_nothing_twice():
    read = {name for names in READ.values() for name in names.split()}
    listed = [name for row in UNREAD for name in row.names.split()]
    assert len(listed) == len(set(listed))
    assert not read & set(listed)
    assert not READ.keys() & set(listed)


def test_every_attribute_that_is_not_read_is_named_with_its_prim():
    stage = new_stage()
    expected = []
    for index, name in enumerate(ATTRIBUTES):
        if unread_attribute(name) is None:
            continue
        prim = stage.DefinePrim(f"/World/p{index}")
        prim.CreateAttribute(name.replace("*", "rotX"), Sdf.ValueTypeNames.String).Set("another value")
        expected.append((index, unread_attribute(name)))
    told = warnings_of(stage)
    for row in UNREAD:
        prims = [index for index, of in expected if of is row]
        if prims:
            (message,) = (text for text in told if row.follows in text)
            assert f"/World/p{prims[0]}" in message
    assert len(told) == len({row.follows for _, row in expected})


@pytest.mark.parametrize("schema", sorted(set(SCHEMAS) - set(READ)))
def test_every_applied_schema_that_is_not_read_is_named_with_its_prim(schema):
    stage = new_stage()
    prim = stage.DefinePrim("/World/thing", "" if schema.endswith("API") else schema)
    if schema.endswith("API"):
        prim.AddAppliedSchema(schema + ":rotX" * ("*" in "".join(SCHEMAS[schema])))
    (message,) = warnings_of(stage)
    assert "/World/thing" in message
    assert unread_schema(schema).follows in message


def test_schemas_that_nobody_knows_are_named():
    stage = new_stage()
    prim = stage.DefinePrim("/World/thing")
    prim.AddAppliedSchema("PhysxTeleportAPI:rotX")
    prim.CreateAttribute("physxTeleport:where", Sdf.ValueTypeNames.String).Set("there")
    (message,) = warnings_of(stage)
    assert "/World/thing" in message
    assert "physxTeleport:where, PhysxTeleportAPI" in message


def test_one_warning_for_a_thousand_prims():
    stage = new_stage()
    for index in range(1000):
        prim = stage.DefinePrim(f"/World/p{index}")
        prim.CreateAttribute("physxRigidBody:retainAccelerations", Sdf.ValueTypeNames.Bool).Set(True)
    (message,) = warnings_of(stage)
    assert "/World/p4 and 995 more" in message


def test_values_that_change_nothing_are_not_named():
    stage = new_stage()
    prim = add(stage, "/World/box")
    prim.CreateAttribute("physxRigidBody:enableCCD", Sdf.ValueTypeNames.Bool).Set(False)
    prim.CreateAttribute("physxRigidBody:solverPositionIterationCount", Sdf.ValueTypeNames.Int).Set(16)
    assert not warnings_of(stage)


@pytest.mark.parametrize(("leader", "is_named"), [("RevoluteJoint", False), ("PrismaticJoint", False), ("Joint", True)])
def test_the_axis_of_a_joint_that_is_mimicked_is_named_where_it_has_several(leader, is_named):
    stage = new_stage()
    joints = [stage.DefinePrim("/World/leader", f"Physics{leader}")]
    joints.append(stage.DefinePrim("/World/follower", "PhysicsRevoluteJoint"))
    for index, prim in enumerate(joints):
        add(stage, f"/World/arm_{index}")
        UsdPhysics.Joint(prim).CreateBody1Rel().SetTargets([f"/World/arm_{index}"])
    joints[1].AddAppliedSchema("PhysxMimicJointAPI:rotZ")
    joints[1].CreateRelationship("physxMimicJoint:rotZ:referenceJoint").SetTargets(["/World/leader"])
    joints[1].CreateAttribute("physxMimicJoint:rotZ:referenceJointAxis", Sdf.ValueTypeNames.Token).Set("rotZ")
    assert any("referenceJointAxis" in message for message in warnings_of(stage)) == is_named


def test_settings_of_a_scene_that_ask_for_what_is_done_anyway_are_not_named():
    stage = new_stage()
    scene = stage.DefinePrim("/PhysicsScene", "PhysicsScene")
    physx.PhysxSceneAPI.Apply(scene)
    for name, value in (("enableGPUDynamics", False), ("broadphaseType", "MBP"), ("enableCCD", True)):
        scene.GetAttribute(f"physxScene:{name}").Set(value)
    assert not warnings_of(stage)
    scene.GetAttribute("physxScene:broadphaseType").Set("ABP")
    (message,) = warnings_of(stage)
    assert "physxScene:broadphaseType: " in message


def test_prototypes_of_instances_are_named_once():
    stage = new_stage()
    part = stage.DefinePrim("/Asset/part")
    part.CreateAttribute("physxRigidBody:retainAccelerations", Sdf.ValueTypeNames.Bool).Set(True)
    stage.GetPrimAtPath("/Asset").SetSpecifier(Sdf.SpecifierClass)
    for index in range(3):
        prim = stage.DefinePrim(f"/World/i{index}", "Xform")
        prim.GetReferences().AddInternalReference("/Asset")
        prim.SetInstanceable(True)
    (message,) = warnings_of(stage)
    assert message.startswith("/World/i0/part: ")


def test_what_is_authored_while_playing_is_named():
    stage = new_stage()
    prim = add(stage, "/World/box")
    engine = playing(stage)
    engine.advance(1 / 60)
    errors.forget_warnings()
    prim.CreateAttribute("physxRigidBody:retainAccelerations", Sdf.ValueTypeNames.Bool).Set(True)
    with pytest.warns(errors.UsdsdgWarning, match="/World/box: physxRigidBody:retainAccelerations"):
        engine.advance(1 / 60)
    errors.forget_warnings()


# Attribute -> prim, value: another value than that of `_typical`, from which another scene follows.
_OTHER = {
    "physics:gravityDirection": ("/PhysicsScene", Gf.Vec3f(1, 0, 0)),
    "physics:gravityMagnitude": ("/PhysicsScene", 1.0),
    "physxScene:invertCollisionGroupFilter": ("/PhysicsScene", True),
    "physxScene:bounceThreshold": ("/PhysicsScene", 1.5),
    "physics:rigidBodyEnabled": ("/World/box", False),
    "physics:kinematicEnabled": ("/World/box", True),
    "physics:velocity": ("/World/box", Gf.Vec3f(1, 2, 3)),
    "physics:angularVelocity": ("/World/box", Gf.Vec3f(1, 2, 3)),
    "physics:startsAsleep": ("/World/box", True),
    "physics:mass": ("/World/box", 3.0),
    "physics:density": ("/World/box", 3.0),
    "physics:centerOfMass": ("/World/box", Gf.Vec3f(0.1, 0, 0)),
    "physics:diagonalInertia": ("/World/box", Gf.Vec3f(1, 1, 1)),
    "physics:principalAxes": ("/World/box", Gf.Quatf(0, 1, 0, 0)),
    "physics:collisionEnabled": ("/World/box", False),
    "physics:approximation": ("/World/mesh", "boundingCube"),
    "physics:dynamicFriction": ("/World/material", 0.7),
    "physics:restitution": ("/World/material", 0.7),
    "physics:invertFilteredGroups": ("/World/group", True),
    "physxRigidBody:disableGravity": ("/World/box", True),
    "physxRigidBody:linearDamping": ("/World/box", 0.3),
    "physxRigidBody:angularDamping": ("/World/box", 0.3),
    "physxRigidBody:maxLinearVelocity": ("/World/box", 0.3),
    "physxRigidBody:maxAngularVelocity": ("/World/box", 0.3),
    "physxRigidBody:maxDepenetrationVelocity": ("/World/box", 0.3),
    "physxRigidBody:sleepThreshold": ("/World/box", 0.3),
    "physxRigidBody:lockedPosAxis": ("/World/box", 3),
    "physxRigidBody:lockedRotAxis": ("/World/box", 3),
    "physxRigidBody:enableCCD": ("/World/box", True),
    "physxForce:force": ("/World/box", Gf.Vec3f(1, 2, 3)),
    "physxForce:torque": ("/World/box", Gf.Vec3f(1, 2, 3)),
    "physxForce:mode": ("/World/box", "force"),
    "physxForce:forceEnabled": ("/World/box", False),
    "physxForce:worldFrameEnabled": ("/World/box", True),
    "physxSurfaceVelocity:surfaceVelocity": ("/World/box", Gf.Vec3f(1, 2, 3)),
    "physxSurfaceVelocity:surfaceAngularVelocity": ("/World/box", Gf.Vec3f(1, 2, 3)),
    "physxSurfaceVelocity:surfaceVelocityEnabled": ("/World/box", False),
    "physxSurfaceVelocity:surfaceVelocityLocalSpace": ("/World/box", False),
    "physics:staticFriction": ("/World/material", 0.9),
    "physxMaterial:frictionCombineMode": ("/World/material", "max"),
    "physxMaterial:restitutionCombineMode": ("/World/material", "max"),
    "physxContactReport:threshold": ("/World/box", 5.0),
    "physxCollision:contactOffset": ("/World/box", 0.3),
    "physxCollision:restOffset": ("/World/box", 0.01),
}
# Attributes that are read elsewhere than in the parser, or that change what it warns of.
_ELSEWHERE = {
    "physxScene:timeStepsPerSecond": "read before every step: test_oracles",
    "physics:simulationOwner": "test_simulation_owners",
    "physxConvexDecompositionCollision:maxConvexHulls": "test_convex_parts",
    "physxConvexDecompositionCollision:hullVertexLimit": "test_convex_parts",
    "physxConvexDecompositionCollision:errorPercentage": "test_convex_parts",
    "physxContactReport:reportPairs": "test_contact_reports",
    "physxTrigger:triggeredCollisions": "written, not read: test_triggers",
    "physics:filteredGroups": "test_parse",
    "physics:filteredPairs": "test_parse",
    "physics:mergeGroup": "test_parse",
}
# Likewise of joints, where the instance of a schema is part of the name; values of relationships are targets.
_OTHER_OF_JOINTS = {
    "physics:body0": ("hinge", "/World/d"),
    "physics:body1": ("hinge", "/World/d"),
    "physics:localPos0": ("hinge", Gf.Vec3f(0.1, 0.2, 0.3)),
    "physics:localPos1": ("hinge", Gf.Vec3f(0.1, 0.2, 0.3)),
    "physics:localRot0": ("hinge", Gf.Quatf(0, 1, 0, 0)),
    "physics:localRot1": ("hinge", Gf.Quatf(0, 1, 0, 0)),
    "physics:excludeFromArticulation": ("hinge", True),
    "physics:jointEnabled": ("hinge", False),
    "physics:collisionEnabled": ("hinge", True),
    "physics:breakForce": ("hinge", 5.0),
    "physics:breakTorque": ("hinge", 5.0),
    "physics:axis": ("hinge", "Y"),
    "physics:lowerLimit": ("hinge", -5.0),
    "physics:upperLimit": ("hinge", 5.0),
    "physics:coneAngle0Limit": ("ball", 20.0),
    "physics:coneAngle1Limit": ("ball", 20.0),
    "physics:minDistance": ("rope", 0.1),
    "physics:maxDistance": ("rope", 0.9),
    "physxPhysicsDistanceJoint:springEnabled": ("rope", False),
    "physxPhysicsDistanceJoint:springStiffness": ("rope", 7.0),
    "physxPhysicsDistanceJoint:springDamping": ("rope", 7.0),
    "physics:gearRatio": ("gear", 3.0),
    "physics:hinge0": ("gear", "/World/slide"),
    "physics:hinge1": ("gear", "/World/slide"),
    "physics:ratio": ("mesh", 3.0),
    "physics:hinge": ("mesh", "/World/hinge"),
    "physics:prismatic": ("mesh", "/World/hinge"),
    "drive:angular:physics:targetPosition": ("hinge", 3.0),
    "drive:angular:physics:targetVelocity": ("hinge", 3.0),
    "drive:angular:physics:stiffness": ("hinge", 3.0),
    "drive:angular:physics:damping": ("hinge", 3.0),
    "drive:angular:physics:maxForce": ("hinge", 3.0),
    "drive:angular:physics:type": ("hinge", "acceleration"),
    "limit:transX:physics:low": ("general", -0.3),
    "limit:transX:physics:high": ("general", 0.3),
    "state:angular:physics:position": ("hinge", 3.0),
    "state:angular:physics:velocity": ("hinge", 3.0),
    "physxJoint:armature": ("slide", 3.0),
    "physxJoint:maxJointVelocity": ("slide", 3.0),
    "physxJoint:jointFriction": ("slide", 3.0),
    "physxJointAxis:angular:armature": ("hinge", 3.0),
    "physxJointAxis:angular:maxJointVelocity": ("hinge", 3.0),
    "physxJointAxis:angular:viscousFrictionCoefficient": ("hinge", 3.0),
    "physxJointAxis:angular:staticFrictionEffort": ("hinge", 3.0),
    "physxMimicJoint:rotX:referenceJoint": ("follower", "/World/slide"),
    "physxMimicJoint:rotX:gearing": ("follower", 3.0),
    "physxMimicJoint:rotX:offset": ("follower", 3.0),
    "physxArticulation:enabledSelfCollisions": ("a", False),
    "physxArticulation:articulationEnabled": ("a", False),
}


def _mechanism() -> Usd.Stage:
    """A chain of bodies with a joint of each type between two of them, and with every schema of joints."""
    stage, bodies = new_stage(), "abcdefgh"
    for index, name in enumerate(bodies):
        add(stage, f"/World/{name}", at=(index, 0, 0))
    root = stage.GetPrimAtPath("/World/a")
    UsdPhysics.ArticulationRootAPI.Apply(root)
    root.AddAppliedSchema("PhysxArticulationAPI")
    kinds = {
        "hinge": UsdPhysics.RevoluteJoint, "turn": UsdPhysics.RevoluteJoint, "slide": UsdPhysics.PrismaticJoint,
        "follower": UsdPhysics.RevoluteJoint, "ball": UsdPhysics.SphericalJoint, "general": UsdPhysics.Joint,
        "rope": UsdPhysics.DistanceJoint,
    }  # fmt: skip
    for index, (name, kind) in enumerate(kinds.items()):
        first, second = (f"/World/{body}" for body in bodies[index : index + 2])
        prim = joint(stage, f"/World/{name}", kind, first, second, (index + 0.5, 0, 0)).GetPrim()
        for attribute in ("physics:breakForce", "physics:breakTorque"):
            prim.GetAttribute(attribute).Set(1.0)
    hinge, follower, general, rope = (
        stage.GetPrimAtPath(f"/World/{name}") for name in ("hinge", "follower", "general", "rope")
    )
    drive(UsdPhysics.Joint(hinge), "angular", stiffness=1.0, damping=1.0, target=1.0)
    for schema in ("PhysicsJointStateAPI:angular", "PhysxJointAxisAPI:angular"):
        hinge.AddAppliedSchema(schema)
    free_axes(UsdPhysics.Joint(general), transX=(-1.0, 1.0))
    rope.AddAppliedSchema("PhysxPhysicsDistanceJointAPI")
    rope.CreateAttribute("physxPhysicsDistanceJoint:springEnabled", Sdf.ValueTypeNames.Bool).Set(True)
    follower.AddAppliedSchema("PhysxMimicJointAPI:rotX")
    follower.CreateRelationship("physxMimicJoint:rotX:referenceJoint").SetTargets(["/World/turn"])
    for name, kind, ends in (
        ("gear", "PhysxPhysicsGearJoint", {"hinge0": "hinge", "hinge1": "turn"}),
        ("mesh", "PhysxPhysicsRackAndPinionJoint", {"hinge": "turn", "prismatic": "slide"}),
    ):
        prim = stage.DefinePrim(f"/World/{name}", kind)
        for end, target in ends.items():
            prim.CreateRelationship(f"physics:{end}", custom=False).SetTargets([f"/World/{target}"])
    return stage


@pytest.mark.parametrize("name", sorted(_OTHER_OF_JOINTS))
def test_an_attribute_of_a_joint_that_is_read_changes_the_scene(name):
    stage = _mechanism()
    before = parse(stage, HullCache())
    path, value = _OTHER_OF_JOINTS[name]
    prim = stage.GetPrimAtPath(f"/World/{path}")
    if isinstance(value, str) and value.startswith("/"):
        prim.CreateRelationship(name, custom=False).SetTargets([value])
    else:
        types = {bool: Sdf.ValueTypeNames.Bool, float: Sdf.ValueTypeNames.Float, str: Sdf.ValueTypeNames.Token}
        attribute = prim.GetAttribute(name) or prim.CreateAttribute(name, types[type(value)])
        attribute.Set(value)
    assert parse(stage, HullCache()) != before


def _typical() -> Usd.Stage:
    stage = new_stage()
    material = physics_material(stage, "/World/material")
    box = add(stage, "/World/box", material=material)
    UsdPhysics.MassAPI.Apply(box).CreateDiagonalInertiaAttr((1, 2, 3))
    physx.PhysxForceAPI.Apply(box).CreateForceAttr((1, 0, 0))
    physx.PhysxSurfaceVelocityAPI.Apply(box).CreateSurfaceVelocityAttr((1, 0, 0))
    physx.PhysxContactReportAPI.Apply(box)
    physx.PhysxMaterialAPI.Apply(material.GetPrim())
    mesh = UsdGeom.Mesh.Define(stage, "/World/mesh")
    mesh.CreatePointsAttr(Vt.Vec3fArray([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]))
    mesh.CreateFaceVertexCountsAttr([3, 3, 3, 3])
    mesh.CreateFaceVertexIndicesAttr([0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3])
    UsdPhysics.CollisionAPI.Apply(mesh.GetPrim())
    UsdPhysics.MeshCollisionAPI.Apply(mesh.GetPrim()).CreateApproximationAttr("convexHull")
    group = UsdPhysics.CollisionGroup.Define(stage, "/World/group")
    group.GetCollidersCollectionAPI().IncludePath("/World")
    return stage


@pytest.mark.parametrize("name", sorted(_OTHER))
def test_an_attribute_that_is_read_changes_the_scene(name):
    stage = _typical()
    before = parse(stage, HullCache())
    path, value = _OTHER[name]
    prim = stage.GetPrimAtPath(path)
    attribute = prim.GetAttribute(name)
    if not attribute:
        types = {bool: Sdf.ValueTypeNames.Bool, float: Sdf.ValueTypeNames.Float, int: Sdf.ValueTypeNames.Int}
        attribute = prim.CreateAttribute(name, types[type(value)])
    attribute.Set(value)
    assert parse(stage, HullCache()) != before


def test_every_attribute_of_the_table_is_shown_to_be_read():
    read = {name for names in READ.values() for name in names.split() if not name.startswith("collection:")}
    of_joints = {re.sub(":(angular|transX|rotX):", ":*:", name) for name in _OTHER_OF_JOINTS}
    assert read == {*_OTHER, *_ELSEWHERE, *of_joints}
