"""What is authored where nothing reads it is named with its prim; what is read there is not."""

from __future__ import annotations

import math

import pytest
from pxr import Gf, Sdf, UsdGeom, UsdPhysics, UsdShade

from tests.physics.mechanisms import drive, free_axes, joint
from tests.physics.scenes import add, collide, new_stage, physics_material, playing, position, warnings_of

TYPES = Sdf.ValueTypeNames


# Type of a prim, schemas applied to it, an attribute of it and its value, what it lacks.
_WITHOUT = [
    ("Xform", ["PhysicsMassAPI"], "physics:mass", 5.0, "PhysicsRigidBodyAPI or PhysicsCollisionAPI"),
    ("Cube", ["PhysicsCollisionAPI"], "physics:mass", 5.0, "PhysicsMassAPI"),
    ("Xform", [], "physics:velocity", Gf.Vec3f(1, 0, 0), "PhysicsRigidBodyAPI"),
    ("Cube", ["PhysicsCollisionAPI"], "physics:kinematicEnabled", True, "PhysicsRigidBodyAPI"),
    ("Cube", ["PhysicsCollisionAPI"], "physxRigidBody:linearDamping", 1.0, "PhysicsRigidBodyAPI"),
    ("Cube", [], "physxCollision:contactOffset", 0.1, "PhysicsCollisionAPI"),
    ("Mesh", [], "physics:approximation", "convexHull", "PhysicsCollisionAPI"),
    ("Cube", ["PhysicsCollisionAPI"], "physxForce:force", Gf.Vec3f(1, 0, 0), "PhysxForceAPI"),
    ("Material", [], "physics:dynamicFriction", 0.5, "PhysicsMaterialAPI"),
    ("Xform", [], "physxScene:bounceThreshold", 0.5, "PhysicsScene"),
    ("Xform", [], "physxArticulation:enabledSelfCollisions", False, "PhysicsArticulationRootAPI"),
    ("PhysicsFixedJoint", [], "physics:lowerLimit", 1.0, "PhysicsRevoluteJoint or PhysicsPrismaticJoint"),
    ("PhysicsRevoluteJoint", [], "drive:angular:physics:stiffness", 1.0, "PhysicsDriveAPI:angular"),
    ("PhysicsJoint", [], "limit:rotX:physics:low", 1.0, "PhysicsLimitAPI:rotX"),
]


@pytest.mark.parametrize(("kind", "schemas", "name", "value", "lacks"), _WITHOUT)
def test_attributes_without_their_schema_are_named(kind, schemas, name, value, lacks):
    stage = new_stage()
    prim = stage.DefinePrim("/World/thing", kind)
    for schema in schemas:
        prim.AddAppliedSchema(schema)
    types = {float: TYPES.Float, bool: TYPES.Bool, str: TYPES.Token, Gf.Vec3f: TYPES.Float3}
    (prim.GetAttribute(name) or prim.CreateAttribute(name, types[type(value)])).Set(value)
    found = [text for text in warnings_of(stage) if name in text]
    assert found == [f"/World/thing: {name}: these have no effect on a prim without {lacks}."]


@pytest.mark.parametrize(
    ("kind", "axis"),
    [
        (UsdPhysics.RevoluteJoint, "linear"),
        (UsdPhysics.RevoluteJoint, "rotZ"),
        (UsdPhysics.PrismaticJoint, "angular"),
        (UsdPhysics.FixedJoint, "angular"),
        (UsdPhysics.SphericalJoint, "rotX"),
        (UsdPhysics.Joint, "transY"),
    ],
)
def test_drives_and_states_of_axes_that_a_joint_lacks_are_named(kind, axis):
    stage = new_stage()
    add(stage, "/World/box")
    made = joint(stage, "/World/joint", kind, "", "/World/box", (0, 0, 0))
    if kind is UsdPhysics.Joint:
        free_axes(made, "rotX")
    drive(made, axis, stiffness=1.0)
    made.GetPrim().AddAppliedSchema(f"PhysicsJointStateAPI:{axis}")
    made.GetPrim().CreateAttribute(f"state:{axis}:physics:position", TYPES.Float).Set(1.0)
    (message,) = warnings_of(stage)
    assert message.startswith(
        f"/World/joint: drive:{axis}:physics:stiffness, state:{axis}:physics:position: these have"
    )


def test_limits_by_axis_are_those_of_general_joints():
    stage = new_stage()
    add(stage, "/World/box")
    made = joint(stage, "/World/joint", UsdPhysics.RevoluteJoint, "", "/World/box", (0, 0, 0))
    UsdPhysics.LimitAPI.Apply(made.GetPrim(), "rotX").CreateLowAttr(-1.0)
    (message,) = warnings_of(stage)
    assert message.startswith("/World/joint: limit:rotX:physics:low: these have no effect: limits by axis are")


def test_a_spherical_joint_has_no_drive_as_in_physx():
    """With a cone limit a drive turned it, without one it did not."""
    stage = new_stage()
    box = add(stage, "/World/box", gravity=False)
    made = joint(stage, "/World/joint", UsdPhysics.SphericalJoint, "", "/World/box", (0, 0, 0))
    made.CreateConeAngle0LimitAttr(40.0)
    made.CreateConeAngle1LimitAttr(40.0)
    drive(made, "rotX", stiffness=10.0, damping=1.0, target=30.0)
    playing(stage).advance(1.0)
    turned = UsdGeom.XformCache().GetLocalToWorldTransform(box).RemoveScaleShear().ExtractRotation().GetAngle()
    assert turned == pytest.approx(0.0, abs=0.01)
    assert position(box) == pytest.approx([0, 0, 0], abs=1e-6)


def test_the_corners_of_a_cone_limit_are_named():
    """The angle between the axes is that of two turns of 30 degrees one after the other."""
    stage = new_stage()
    UsdPhysics.Scene(stage.GetPrimAtPath("/PhysicsScene")).CreateGravityDirectionAttr((0, 1, 1))
    box = add(stage, "/World/box", at=(0.5, 0, 0), scale=(0.5, 0.05, 0.05), angular_damping=8.0)
    made = joint(stage, "/World/joint", UsdPhysics.SphericalJoint, "", "/World/box", (0, 0, 0))
    made.CreateConeAngle0LimitAttr(30.0)
    assert not warnings_of(stage)
    made.CreateConeAngle1LimitAttr(30.0)
    (message,) = warnings_of(stage)
    assert message.startswith("/World/joint: physics:coneAngle0Limit: limits of a spherical joint are those of a pyr")
    playing(stage).advance(3.0)
    swung = math.degrees(math.acos(position(box)[0] / 0.5))
    assert swung == pytest.approx(math.degrees(math.acos(math.cos(math.radians(30.0)) ** 2)), abs=0.5)


def test_what_is_read_is_not_named():
    stage = new_stage()
    box = add(stage, "/World/box", material=physics_material(stage, "/World/material", density=3.0))
    UsdPhysics.MassAPI.Apply(box).CreateDensityAttr(2.0)
    UsdPhysics.RigidBodyAPI(box).CreateVelocityAttr((1, 0, 0))
    box.CreateAttribute("physxCollision:contactOffset", TYPES.Float).Set(0.01)
    made = joint(stage, "/World/joint", UsdPhysics.Joint, "", "/World/box", (0, 0, 0))
    free_axes(made, "rotX", transZ=(-1.0, 1.0))
    for axis in ("rotX", "transZ"):
        drive(made, axis, stiffness=1.0, target=0.5)
    made.CreateCollisionEnabledAttr(True)
    made.CreateBreakForceAttr(5.0)
    add(stage, "/World/other", at=(5, 0, 0))
    hinge = joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, "", "/World/other", (5, 0, 0))
    hinge.CreateLowerLimitAttr(-5.0)
    drive(hinge, "angular", stiffness=1.0)
    assert not warnings_of(stage)


def test_time_samples_that_physics_does_not_follow_are_named():
    stage = new_stage()
    box = add(stage, "/World/box")
    for attribute, values in (
        (UsdPhysics.CollisionAPI(box).CreateCollisionEnabledAttr(), (True, False)),
        (UsdPhysics.RigidBodyAPI(box).CreateVelocityAttr(), ((1, 0, 0), (2, 0, 0))),
    ):
        for time, value in zip((0, 24), values):
            attribute.Set(value, time)
    (message,) = warnings_of(stage)
    assert message.startswith("/World/box: physics:collisionEnabled, physics:velocity: physics does not follow time")


def test_recorded_velocities_beside_the_default_are_not_named():
    stage = new_stage()
    velocity = UsdPhysics.RigidBodyAPI(add(stage, "/World/box")).CreateVelocityAttr((0, 0, 0))
    velocity.Set((1, 0, 0), 0)
    velocity.Set((2, 0, 0), 24)
    assert not warnings_of(stage)


def test_filters_that_name_nothing_are_named():
    stage = new_stage()
    box = add(stage, "/World/box")
    UsdPhysics.FilteredPairsAPI.Apply(box).CreateFilteredPairsRel().SetTargets(["/World/gone"])
    group = UsdPhysics.CollisionGroup.Define(stage, "/World/group")
    group.CreateFilteredGroupsRel().SetTargets(["/World/box", "/World/group"])
    assert sorted(warnings_of(stage)) == [
        "/World/box: physics:filteredPairs names /World/gone, which is no prim, so it filters nothing. Correct it.",
        "/World/group: physics:filteredGroups names /World/box, which is no PhysicsCollisionGroup, so it filters "
        "nothing. Correct it.",
    ]


def test_triggers_materials_of_faces_and_skinned_meshes_are_named():
    stage = new_stage()
    stage.DefinePrim("/World/trigger", "Cube").AddAppliedSchema("PhysxTriggerAPI")
    mesh = UsdGeom.Mesh.Define(stage, "/World/mesh")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
    mesh.CreateFaceVertexCountsAttr([3, 3, 3, 3])
    mesh.CreateFaceVertexIndicesAttr([0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3])
    UsdPhysics.CollisionAPI.Apply(mesh.GetPrim())
    UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("skel:jointIndices", TYPES.IntArray).Set([0, 0, 0, 0])
    faces = UsdGeom.Subset.Define(stage, "/World/mesh/faces").GetPrim()
    material = physics_material(stage, "/World/material")
    UsdShade.MaterialBindingAPI.Apply(faces).Bind(material, UsdShade.Tokens.weakerThanDescendants, "physics")
    told = warnings_of(stage)
    assert len(told) == 3
    assert any(text.startswith("/World/trigger: PhysxTriggerAPI: nothing triggers without Phys") for text in told)
    assert any(text.startswith("/World/mesh/faces: material:binding:physics: a collider has one") for text in told)
    assert any(text.startswith("/World/mesh: primvars:skel:jointIndices: skinned meshes collide") for text in told)


def test_masses_of_static_colliders_and_forces_on_kinematic_bodies_are_named():
    stage = new_stage()
    floor = add(stage, "/World/floor", at=(0, 0, -1), body=False)
    hand = add(stage, "/World/hand", at=(0, 0, 1))
    UsdPhysics.RigidBodyAPI(hand).CreateKinematicEnabledAttr(True)
    hand.AddAppliedSchema("PhysxForceAPI")
    for prim in (floor, hand):
        UsdPhysics.MassAPI.Apply(prim)
    assert not warnings_of(stage)
    for prim in (floor, hand):
        UsdPhysics.MassAPI(prim).CreateMassAttr(2.0)
    hand.CreateAttribute("physxForce:torque", TYPES.Float3).Set((0, 0, 1))
    assert warnings_of(stage) == [
        "static colliders never move, so their mass has no effect: /World/floor. Apply RigidBodyAPI to what shall "
        "move, or remove the MassAPI.",
        "/World/hand: no force moves /World/hand, which is kinematic. Disable physics:kinematicEnabled, or move the "
        "body from a script or by time samples.",
    ]


def test_the_mass_of_a_body_that_is_disabled_waits_for_it_and_is_not_named():
    stage = new_stage()
    box = add(stage, "/World/box")
    UsdPhysics.RigidBodyAPI(box).CreateRigidBodyEnabledAttr(False)
    UsdPhysics.MassAPI.Apply(box).CreateMassAttr(2.0)
    assert not warnings_of(stage)


@pytest.mark.parametrize(("thickness", "named"), [(0.0, True), (0.02, False)])
def test_the_bounding_box_of_a_flat_mesh_is_named(thickness, named):
    stage = new_stage()
    sheet = UsdGeom.Mesh.Define(stage, "/World/sheet")
    sheet.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, thickness)])
    sheet.CreateFaceVertexCountsAttr([3, 3])
    sheet.CreateFaceVertexIndicesAttr([0, 1, 2, 1, 3, 2])
    collide(sheet.GetPrim(), approximation="boundingCube")
    found = warnings_of(stage)
    assert [text.startswith("/World/sheet is flat, so its bounding box has no volume") for text in found] == [
        True
    ] * named
