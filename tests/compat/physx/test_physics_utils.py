"""`omni.physx.scripts.physicsUtils`: what is authored, read back with pxr, and how it falls."""

import pytest
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdShade

from usdsdg.app.app import get_app
from usdsdg.compat.omni.physx.scripts import physicsUtils
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.schemas import physx

SHAPES = {"box": "Cube", "sphere": "Sphere", "capsule": "Capsule", "cylinder": "Cylinder", "cone": "Cone"}


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_are_seen_collide_or_fall(stage, name):
    seen = getattr(physicsUtils, f"add_{name}")(stage, f"/seen_{name}", position=Gf.Vec3f(1, 2, 3))
    static = getattr(physicsUtils, f"add_collider_{name}")(stage, f"/static_{name}", color=Gf.Vec3f(1, 0, 0))
    body = getattr(physicsUtils, f"add_rigid_{name}")(
        stage, f"/body_{name}", density=500.0, lin_velocity=Gf.Vec3f(0, 0, 1), ang_velocity=Gf.Vec3f(90, 0, 0)
    )
    assert [prim.GetTypeName() for prim in (seen, static, body)] == [SHAPES[name]] * 3
    assert [prim.HasAPI(UsdPhysics.CollisionAPI) for prim in (seen, static, body)] == [False, True, True]
    assert [prim.HasAPI(UsdPhysics.RigidBodyAPI) for prim in (seen, static, body)] == [False, False, True]
    assert UsdPhysics.MassAPI(body).GetDensityAttr().Get() == 500.0
    assert UsdPhysics.RigidBodyAPI(body).GetVelocityAttr().Get() == (0, 0, 1)
    assert UsdPhysics.RigidBodyAPI(body).GetAngularVelocityAttr().Get() == (90, 0, 0)
    assert physicsUtils.get_translation(seen) == (1, 2, 3)
    assert UsdGeom.Gprim(static).GetDisplayColorAttr().Get()[0] == (1, 0, 0)
    ops = [op.GetOpName() for op in UsdGeom.Xformable(body).GetOrderedXformOps()]
    assert ops == ["xformOp:translate", "xformOp:orient", "xformOp:scale"]
    # The extent that is authored is the one that USD computes.
    found = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(body), Usd.TimeCode.Default())
    assert UsdGeom.Boundable(body).GetExtentAttr().Get() == found


def test_sizes_and_paths(stage):
    root = UsdGeom.Xform.Define(stage, "/World")
    stage.SetDefaultPrim(root.GetPrim())
    first = physicsUtils.add_rigid_box(stage, "/box", size=Gf.Vec3f(2, 3, 4), density=0.0)
    second = physicsUtils.add_rigid_cube(stage, "/box", 0.5)
    assert [str(prim.GetPath()) for prim in (first, second)] == ["/World/box", "/World/box_01"]
    assert first.GetAttribute("xformOp:scale").Get() == (2, 3, 4)
    assert not first.HasAPI(UsdPhysics.RigidBodyAPI)  # as its density is 0
    assert second.GetAttribute("xformOp:scale").Get() == (0.5, 0.5, 0.5)
    capsule = physicsUtils.add_capsule(stage, "/capsule", radius=0.2, height=1.5, axis="Z")
    assert [capsule.GetAttribute(name).Get() for name in ("radius", "height", "axis")] == [0.2, 1.5, "Z"]
    assert physicsUtils.get_stage_next_free_path(stage, "capsule", False) == "/capsule"


def test_a_ball_falls_onto_a_ground_plane(stage):
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    ground = physicsUtils.add_ground_plane(stage, "/World/ground", "Z", 5.0, Gf.Vec3f(0, 0, -1), Gf.Vec3f(0.5))
    assert ground == "/World/ground"
    assert stage.GetPrimAtPath("/World/ground/CollisionPlane").HasAPI(UsdPhysics.CollisionAPI)
    square = UsdGeom.Mesh(stage.GetPrimAtPath("/World/ground/CollisionMesh"))
    assert square.GetNormalsAttr().Get()[0] == (0, 0, 1)
    assert max(point[0] for point in square.GetPointsAttr().Get()) == 5.0
    ball = physicsUtils.add_rigid_sphere(stage, "/World/ball", radius=0.1, position=Gf.Vec3f(0, 0, 0), density=1000.0)
    get_timeline().play()
    for _ in range(90):
        get_app().update()
    assert physicsUtils.get_translation(ball)[2] == pytest.approx(-0.9, abs=2e-3)


@pytest.mark.parametrize("axis", ["X", "Y", "Z"])
def test_faces_of_meshes_point_outwards(stage, axis):
    square = physicsUtils.create_mesh_square_axis(stage, "/square", axis, 2.0)
    assert normals(square) == [square.GetNormalsAttr().Get()[0]]
    cube = physicsUtils.create_mesh_cube(stage, "/cube", 1.0)
    points = cube.GetPointsAttr().Get()
    for number, normal in enumerate(normals(cube)):
        face = list(cube.GetFaceVertexIndicesAttr().Get())[4 * number : 4 * number + 4]
        assert Gf.Dot(normal, sum((points[index] for index in face), Gf.Vec3f(0))) > 0


def normals(mesh):
    """Normals of faces with four corners, by the order of these."""
    points, indices = mesh.GetPointsAttr().Get(), list(mesh.GetFaceVertexIndicesAttr().Get())
    corners = [[points[index] for index in indices[start : start + 4]] for start in range(0, len(indices), 4)]
    return [Gf.Cross(b - a, c - a).GetNormalized() for a, b, c, _ in corners]


def test_other_grounds_collide(stage):
    physicsUtils.add_quad_plane(stage, "/World/quad", "Y", 3.0, Gf.Vec3f(0), Gf.Vec3f(1))
    physicsUtils.add_cube_ground_plane(stage, "/World/slab", "Z", 4.0, Gf.Vec3f(0), Gf.Vec3f(1))
    assert stage.GetPrimAtPath("/World/quad").HasAPI(UsdPhysics.CollisionAPI)
    slab = stage.GetPrimAtPath("/World/slab")
    assert slab.GetAttribute("xformOp:scale").Get() == Gf.Vec3f(1, 1, 0.01)


def test_masses_forces_and_materials(stage):
    prim = physicsUtils.add_rigid_xform(stage, "/World/body")
    assert prim.HasAPI(UsdPhysics.RigidBodyAPI)
    physicsUtils.add_mass(stage, "/World/body", 3.0)
    physicsUtils.add_density(stage, "/World/body", 20.0)
    mass = UsdPhysics.MassAPI(prim)
    assert (mass.GetMassAttr().Get(), mass.GetDensityAttr().Get()) == (3.0, 20.0)
    force = physicsUtils.add_force_torque(stage, "/World/body", force=Gf.Vec3f(1, 0, 0), isWorldSpace=True)
    assert prim.HasAPI(physx.PhysxForceAPI)
    assert (force.GetForceAttr().Get(), force.GetModeAttr().Get()) == (Gf.Vec3f(1, 0, 0), "acceleration")
    assert force.GetWorldFrameEnabledAttr().Get()
    UsdShade.Material.Define(stage, "/rubber")
    physicsUtils.add_physics_material_to_prim(stage, prim, "/rubber")
    binding = UsdShade.MaterialBindingAPI(prim).GetDirectBinding("physics")
    assert str(binding.GetMaterialPath()) == "/rubber"


def test_a_fixed_joint_holds(stage):
    anchor = physicsUtils.add_collider_box(stage, "/World/anchor")
    body = physicsUtils.add_rigid_box(stage, "/World/body", position=Gf.Vec3f(0, 0, 2), density=10.0)
    joint = physicsUtils.add_joint_fixed(
        stage, "/World/joint", anchor.GetPath(), body.GetPath(), Gf.Vec3f(0, 0, 2), Gf.Quatf(1), Gf.Vec3f(0),
        Gf.Quatf(1), 1e9, 2e9,
    )  # fmt: skip
    assert (joint.GetBreakForceAttr().Get(), joint.GetBreakTorqueAttr().Get()) == (1e9, 2e9)
    get_timeline().play()
    for _ in range(30):
        get_app().update()
    assert physicsUtils.get_translation(body)[2] == pytest.approx(2.0, abs=1e-3)


def test_collision_groups_hold_colliders(stage):
    UsdPhysics.CollisionGroup.Define(stage, "/group")
    physicsUtils.add_collision_to_collision_group(stage, "/World/box", "/group")
    assert physicsUtils.is_in_collision_group(stage, "/World/box", "/group")
    physicsUtils.remove_collision_from_collision_group(stage, "/World/box", "/group")
    assert not physicsUtils.is_in_collision_group(stage, "/World/box", "/group")
    assert not physicsUtils.is_in_collision_group(stage, "/World/box", "/nothing")


def test_ops_are_added_or_set_in_the_precision_that_they_have(stage):
    prim = UsdGeom.Xform.Define(stage, "/prim")
    prim.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(0))
    move, turn, size = physicsUtils.set_or_add_scale_orient_translate(
        prim, Gf.Vec3f(2), Gf.Quatf(0, 1, 0, 0), Gf.Vec3f(1, 2, 3)
    )
    assert (type(move.Get()), type(turn.Get()), type(size.Get())) == (Gf.Vec3d, Gf.Quatf, Gf.Vec3f)
    assert physicsUtils.set_or_add_orient_op(prim, Gf.Quatd(1)).Get() == Gf.Quatf(1)
    assert physicsUtils.set_or_add_translate_op(prim, Gf.Vec3f(4, 0, 0)).Get() == (4, 0, 0)
    assert len(prim.GetOrderedXformOps()) == 3


def test_other_ops_become_translate_orient_and_scale(stage):
    prim = UsdGeom.Xform.Define(stage, "/prim")
    prim.AddRotateXYZOp().Set(Gf.Vec3f(10, 20, 30))
    prim.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    prim.AddScaleOp().Set(Gf.Vec3f(2))
    before = prim.GetLocalTransformation()
    other = UsdGeom.Xform.Define(stage, "/other")
    physicsUtils.copy_transform_as_scale_orient_translate(prim, other)
    physicsUtils.setup_transform_as_scale_orient_translate(prim)
    for each in (prim, other):
        names = [op.GetOpName() for op in each.GetOrderedXformOps()]
        assert names == ["xformOp:translate", "xformOp:orient", "xformOp:scale"]
        assert Gf.IsClose(each.GetLocalTransformation(), before, 1e-5)
