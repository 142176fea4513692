"""The schemas and attributes that rep.physics authors on the stage."""

import pytest
from pxr import UsdGeom, UsdPhysics, UsdShade

from usdsdg import create, distribution, physics, trigger, utils
from usdsdg.errors import BadPrim, GraphError, UsdsdgWarning
from usdsdg.functional import create as shapes
from usdsdg.graph import evaluate


@pytest.fixture
def stage(stage):
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


def test_errors_name_a_prim_that_is_not_a_physics_scene(stage):
    with pytest.raises(GraphError, match="/World/box"):
        physics.collider(physics_scene="/World/box", input_prims="/World/box")
    with pytest.raises(BadPrim, match="/World/nowhere"):
        physics.rigid_body(physics_scene="/World/nowhere", input_prims="/World/box")


@pytest.fixture
def shelf(stage):
    """An Xform with a mesh and a sphere."""
    stage.DefinePrim("/World/shelf", "Xform")
    shapes.cube(parent="/World/shelf", name="board")
    shapes.sphere(parent="/World/shelf", name="ball", as_mesh=False)
    return stage.GetPrimAtPath("/World/shelf"), *stage.GetPrimAtPath("/World/shelf").GetChildren()


def offsets(prim):
    return [prim.GetAttribute(f"physxCollision:{name}").Get() for name in ("contactOffset", "restOffset")]


def test_every_shape_below_collides_with_the_offsets_given(shelf):
    group, board, ball = shelf
    physics.collider("boundingCube", contact_offset=0.25, rest_offset=0.125, input_prims=group)
    for shape in (board, ball):
        assert UsdPhysics.CollisionAPI(shape).GetCollisionEnabledAttr().Get() is True
        assert offsets(shape) == [0.25, 0.125]
    assert UsdPhysics.MeshCollisionAPI(board).GetApproximationAttr().Get() == "boundingCube"
    assert not ball.HasAPI(UsdPhysics.MeshCollisionAPI)
    assert not group.HasAPI(UsdPhysics.CollisionAPI)
    with create.group(group):
        physics.collider()
    assert UsdPhysics.MeshCollisionAPI(board).GetApproximationAttr().Get() == "convexHull"
    assert offsets(board) == [0.25, 0.125]


def test_a_body_gets_colliders_only_where_it_has_none(shelf):
    group, board, ball = shelf
    physics.collider("none", rest_offset=0.125, input_prims=board)
    physics.rigid_body(contact_offset=0.5, input_prims=group)
    assert group.HasAPI(UsdPhysics.RigidBodyAPI)
    assert offsets(board) == [0.5, 0.125]
    assert UsdPhysics.MeshCollisionAPI(board).GetApproximationAttr().Get() == "none"
    assert not ball.HasAPI(UsdPhysics.CollisionAPI)
    physics.rigid_body(overwrite=True, rest_offset=0.25, input_prims=group)
    assert UsdPhysics.MeshCollisionAPI(board).GetApproximationAttr().Get() == "convexHull"
    assert offsets(board) == [0.5, 0.25]
    assert ball.HasAPI(UsdPhysics.CollisionAPI)


def test_velocities_are_written_when_the_trigger_fires(stage):
    spin = distribution.uniform((0, 0, 90), (0, 0, 180))
    with trigger.on_custom_event("go"):
        physics.rigid_body(velocity=(1, 2, 3), angular_velocity=spin, input_prims="/World/box")
    assert stage.GetPrimAtPath("/World/box").HasAPI(UsdPhysics.RigidBodyAPI)
    assert values(stage, "/World/box", "velocity") == [(0, 0, 0)]
    turns = set()
    for _ in range(2):
        utils.send_og_event("go")
        evaluate.graph().evaluate()
        velocity, turning = values(stage, "/World/box", "velocity", "angularVelocity")
        assert velocity == (1, 2, 3)
        assert turning[0] == turning[1] == 0
        assert 90 <= turning[2] < 180
        turns.add(turning[2])
    assert len(turns) == 2


def test_instances_become_editable_for_their_colliders(stage, shelf):
    copy = stage.DefinePrim("/World/copy")
    copy.GetReferences().AddInternalReference("/World/shelf")
    copy.SetInstanceable(True)
    with pytest.warns(UsdsdgWarning, match="/World/copy is an instance"):
        physics.rigid_body(input_prims="/World/copy")
    assert all(child.HasAPI(UsdPhysics.CollisionAPI) for child in copy.GetChildren())


def test_prims_that_cannot_collide_are_warned_about(stage):
    light = create.light()
    with pytest.warns(UsdsdgWarning, match=f"{light.prims[0]} has no shape or mesh"):
        physics.collider(input_prims=[*light.prims, "/World/box"])
    assert stage.GetPrimAtPath("/World/box").HasAPI(UsdPhysics.CollisionAPI)
    with pytest.raises(GraphError, match=r"approximation is 'convexHul'; did you mean 'convexHull'\?"):
        physics.collider("convexHul", input_prims="/World/box")
    with pytest.raises(GraphError, match=r"physics\.collider has no prims"):
        physics.collider()
    with pytest.raises(BadPrim, match="no prim /World/boks"):
        physics.collider(input_prims="/World/boks")


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


def test_densities_are_written_and_randomized_masses_differ(stage):
    stage.DefinePrim("/World/other", "Cube")
    both = ["/World/box", "/World/other"]
    with trigger.on_custom_event("go"):
        physics.mass(mass=distribution.uniform(1, 2), density=[10, 20], input_prims=both)
    utils.send_og_event("go")
    evaluate.graph().evaluate()
    (first, ten), (second, twenty) = (values(stage, path, "mass", "density") for path in both)
    assert 1 <= first < 2
    assert 1 <= second < 2
    assert first != second
    assert (ten, twenty) == (10, 20)


def test_drives_of_joints_are_authored(stage):
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


def test_physics_materials_are_created_if_there_is_none(stage):
    stage.DefinePrim("/World/ball", "Sphere")
    both = ["/World/box", "/World/ball"]
    shared = UsdShade.Material.Define(stage, "/World/rubber")
    UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath("/World/ball")).Bind(shared, materialPurpose="physics")
    physics.physics_material(static_friction=[0.2, 0.9], dynamic_friction=0.1, restitution=0.5, input_prims=both)
    evaluate.graph().evaluate()
    written = ("staticFriction", "dynamicFriction", "restitution")
    assert values(stage, "/World/box/PhysicsMaterial", *written) == pytest.approx([0.2, 0.1, 0.5])
    assert values(stage, "/World/rubber", *written) == pytest.approx([0.9, 0.1, 0.5])
    bound, binding = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath("/World/box")).ComputeBoundMaterial("physics")
    assert str(bound.GetPath()) == "/World/box/PhysicsMaterial"
    assert UsdShade.MaterialBindingAPI.GetMaterialBindingStrength(binding) == "weakerThanDescendants"


def test_of_materials_the_friction_is_their_own(stage):
    looks = create.material_omnipbr(count=2)
    physics.physics_material(static_friction=[0.2, 0.9], input_prims=looks)
    evaluate.graph().evaluate()
    assert [values(stage, path, "staticFriction")[0] for path in looks.prims] == pytest.approx([0.2, 0.9])
    assert not stage.GetPrimAtPath(f"{looks.prims[0]}/PhysicsMaterial")


def test_bodies_are_simulated_at_once_or_by_a_trigger(stage):
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
