"""What rep.physics authors on the stage."""

import pytest
from pxr import UsdGeom, UsdPhysics, UsdShade

from usdsdg import distribution, physics, trigger, utils
from usdsdg.errors import BadPrim, GraphError
from usdsdg.graph import evaluate
from usdsdg.stage.context import new_stage


@pytest.fixture
def stage():
    evaluate.reset()
    stage = new_stage()
    UsdPhysics.Scene.Define(stage, "/World/Second")
    stage.DefinePrim("/World/box", "Cube")
    return stage


def owners(stage, api):
    return [str(path) for path in api(stage.GetPrimAtPath("/World/box")).GetSimulationOwnerRel().GetTargets()]


@pytest.mark.parametrize(
    ("author", "api"), [(physics.collider, UsdPhysics.CollisionAPI), (physics.rigid_body, UsdPhysics.RigidBodyAPI)]
)
def test_the_physics_scene_becomes_the_simulation_owner(stage, author, api):
    author(input_prims="/World/box")
    assert owners(stage, api) == []
    author(physics_scene="/World/Second", input_prims="/World/box")
    assert owners(stage, api) == ["/World/Second"]
    author(physics_scene=stage.GetPrimAtPath("/World/Second"), input_prims="/World/box")
    assert owners(stage, api) == ["/World/Second"]


def test_what_is_no_physics_scene_is_named(stage):
    with pytest.raises(GraphError, match="/World/box"):
        physics.collider(physics_scene="/World/box", input_prims="/World/box")
    with pytest.raises(BadPrim, match="/World/nowhere"):
        physics.rigid_body(physics_scene="/World/nowhere", input_prims="/World/box")


def values(stage, path, *names):
    return [stage.GetPrimAtPath(path).GetAttribute(f"physics:{name}").Get() for name in names]


def test_all_mass_properties_are_written(stage):
    physics.mass(
        mass=2.0, center_of_mass=(0, 0, 0.5), diagonal_inertia=(1, 2, 3), principal_axes=(0, 0, 0, 2),
        input_prims="/World/box",
    )  # fmt: skip
    evaluate.graph().evaluate()
    mass, center, inertia, axes = values(
        stage, "/World/box", "mass", "centerOfMass", "diagonalInertia", "principalAxes"
    )
    assert (mass, tuple(center), tuple(inertia)) == (2.0, (0, 0, 0.5), (1, 2, 3))
    # Real part first, and of unit length.
    assert (axes.GetReal(), tuple(axes.GetImaginary())) == (0, (0, 0, 1))


def test_drives_of_joints(stage):
    UsdPhysics.RevoluteJoint.Define(stage, "/World/arm/elbow")
    UsdPhysics.PrismaticJoint.Define(stage, "/World/arm/slide")
    UsdPhysics.FixedJoint.Define(stage, "/World/arm/foot")
    physics.drive_properties(stiffness=distribution.uniform(5, 6), damping=0.5, input_prims="/World/arm")
    evaluate.graph().evaluate()
    for path, drive in (("/World/arm/elbow", "angular"), ("/World/arm/slide", "linear")):
        api = UsdPhysics.DriveAPI(stage.GetPrimAtPath(path), drive)
        assert 5 <= api.GetStiffnessAttr().Get() < 6
        assert api.GetDampingAttr().Get() == 0.5
    assert not stage.GetPrimAtPath("/World/arm/foot").GetAppliedSchemas()
    physics.drive_properties(1.0, input_prims="/World/box")
    with pytest.raises(GraphError, match="/World/box has no joint"):
        evaluate.graph().evaluate()


def test_physics_materials_are_made_where_there_is_none(stage):
    stage.DefinePrim("/World/ball", "Sphere")
    both = ["/World/box", "/World/ball"]
    shared = UsdShade.Material.Define(stage, "/World/rubber")
    UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath("/World/ball")).Bind(shared, materialPurpose="physics")
    physics.physics_material(static_friction=[0.2, 0.9], restitution=0.5, input_prims=both)
    evaluate.graph().evaluate()
    assert values(stage, "/World/box/PhysicsMaterial", "staticFriction", "restitution") == pytest.approx([0.2, 0.5])
    assert values(stage, "/World/rubber", "staticFriction", "restitution") == pytest.approx([0.9, 0.5])
    bound, binding = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath("/World/box")).ComputeBoundMaterial("physics")
    assert str(bound.GetPath()) == "/World/box/PhysicsMaterial"
    assert UsdShade.MaterialBindingAPI.GetMaterialBindingStrength(binding) == "weakerThanDescendants"


def test_bodies_fall_at_once_and_by_a_trigger(stage):
    box = stage.GetPrimAtPath("/World/box")
    UsdGeom.XformCommonAPI(box).SetTranslate((0, 0, 100))
    physics.rigid_body(input_prims="/World/box")
    evaluate.graph().evaluate()
    physics.simulate(0.5)
    height = box.GetAttribute("xformOp:translate").Get()[2]
    assert 100 - height == pytest.approx(9.81 * 0.5**2 / 2, rel=0.05)
    with trigger.on_custom_event("fall"):
        physics.simulate(0.5)
    utils.send_og_event("fall")
    evaluate.graph().evaluate()
    assert 100 - box.GetAttribute("xformOp:translate").Get()[2] == pytest.approx(9.81 / 2, rel=0.05)
    physics.reset()


def test_the_simulated_scene_is_the_first(stage):
    with pytest.raises(GraphError, match="2 prims; give one"):
        physics.simulate(1.0, physics_scene=["/World/Second", "/World/box"])
