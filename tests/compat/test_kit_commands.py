"""`omni.kit.commands`: commands by name."""

import pytest
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from usdsdg.compat.omni import usd
from usdsdg.compat.omni.kit import commands, undo
from usdsdg.compat.omni.kit.commands import execute
from usdsdg.compat.omni.kit.viewport.utility import get_active_viewport
from usdsdg.compat.omni.usd import get_context
from usdsdg.errors import ArgumentError, BadPrim, Unsupported
from usdsdg.session.session import current


def world(prim):
    return UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())


def test_prims_are_created_below_the_default_prim_with_attributes(stage):
    done, path = execute("CreatePrimCommand", prim_type="Sphere", attributes={"radius": 3.0})
    assert (done, path) == (True, "/World/Sphere")
    assert stage.GetPrimAtPath(path).GetAttribute("radius").Get() == 3.0
    assert execute("CreatePrim", prim_type="Sphere", select_new_prim=False) == (True, "/World/Sphere_01")
    assert get_context().get_selection().get_selected_prim_paths() == ["/World/Sphere"]
    path = execute("CreateMeshPrimWithDefaultXform", prim_type="Cube", prim_path="/World/a/box")[1]
    bounds = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default"]).ComputeWorldBound(stage.GetPrimAtPath(path))
    assert (path, bounds.ComputeAlignedRange().GetSize()) == ("/World/a/box", Gf.Vec3d(1, 1, 1))


def test_meshes_are_nested(stage):
    _, above = execute("CreateMeshPrimCommand", prim_type="Cube", prim_path="/World/Cube")
    done, path = execute("CreateMeshPrimCommand", prim_type="Cube", prim_path="/World/Cube/Nested")
    assert (done, path) == (True, f"{above}/Nested")
    assert stage.GetPrimAtPath(path).IsA(UsdGeom.Mesh)


def test_properties_of_the_viewports_cameras_change_where_they_are_defined(stage):
    get_active_viewport().get_render_product_path()
    execute("ChangeProperty", prop_path="/OmniverseKit_Persp.horizontalAperture", value=6.0, prev=0)
    assert UsdGeom.Camera(stage.GetPrimAtPath("/OmniverseKit_Persp")).GetHorizontalApertureAttr().Get() == 6.0
    assert not stage.GetRootLayer().GetPrimAtPath("/OmniverseKit_Persp")


def test_prims_are_moved_in_place_copied_and_deleted(stage):
    for path, x in (("/World/a", 1.0), ("/World/b", 20.0), ("/World/a/child", 300.0)):
        UsdGeom.Xform.Define(stage, path).AddTranslateOp().Set((x, 0, 0))
    execute("MovePrim", path_from="/World/a/child", path_to="/World/b/moved")
    assert not stage.GetPrimAtPath("/World/a/child")
    assert world(stage.GetPrimAtPath("/World/b/moved")).ExtractTranslation() == Gf.Vec3d(301, 0, 0)
    assert execute("CopyPrim", path_from="/World/b")[1] == "/World/b_01"
    assert stage.GetPrimAtPath("/World/b_01/moved")
    execute("DeletePrims", paths=["/World/b", "/World/nowhere"])
    assert not stage.GetPrimAtPath("/World/b")


def test_prims_of_a_reference_are_deactivated(stage):
    source = Usd.Stage.CreateInMemory()
    UsdGeom.Cube.Define(source, "/root/inner")
    stage.DefinePrim("/World/ref").GetReferences().AddReference(source.GetRootLayer().identifier, "/root")
    execute("DeletePrimsCommand", paths=["/World/ref/inner"])
    assert not stage.GetPrimAtPath("/World/ref/inner").IsActive()


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
def test_rotations_turn_in_their_order(stage, order):
    prim = UsdGeom.Cube.Define(stage, "/World/cube").GetPrim()
    execute(
        "TransformPrimSRT", path=prim.GetPath(), new_translation=(1, 2, 3), new_rotation_euler=(10, 20, 30),
        new_rotation_order=order, new_scale=(2, 2, 2),
    )  # fmt: skip
    expected = Gf.Matrix4d().SetScale(2.0)
    for axis in order:
        direction = Gf.Vec3d(*(float(i == axis) for i in range(3)))
        expected *= Gf.Matrix4d().SetRotate(Gf.Rotation(direction, (10.0, 20.0, 30.0)[axis]))
    expected.SetTranslateOnly((1, 2, 3))
    assert Gf.IsClose(world(prim), expected, 1e-6)
    execute("TransformPrim", path="/World/cube", new_transform_matrix=Gf.Matrix4d().SetTranslate((7, 0, 0)))
    assert Gf.IsClose(world(prim), Gf.Matrix4d().SetTranslate((7, 0, 0)), 1e-6)


@pytest.mark.parametrize("op", ["AddRotateXYZOp", "AddRotateZYXOp"])
def test_scale_rotation_and_translation_are_read_as_they_are_written(stage, op):
    cube = UsdGeom.Cube.Define(stage, "/World/cube")
    cube.AddTranslateOp().Set((1, 2, 3))
    getattr(cube, op)().Set((10, 20, 30))
    cube.AddScaleOp().Set((2, 3, 4))
    before = world(cube.GetPrim())
    scale, rotation, order, translation = usd.get_local_transform_SRT(cube.GetPrim())
    assert Gf.IsClose(scale, (2, 3, 4), 1e-9)
    assert translation == Gf.Vec3d(1, 2, 3)
    copy = UsdGeom.Cube.Define(stage, "/World/copy").GetPrim()
    execute(
        "TransformPrimSRT", path="/World/copy", new_translation=translation, new_rotation_euler=rotation,
        new_rotation_order=order, new_scale=scale,
    )  # fmt: skip
    assert Gf.IsClose(world(copy), before, 1e-6)


@pytest.mark.parametrize("op", ["AddRotateXYZOp", "AddOrientOp"])
def test_rotations_may_be_vectors_of_usd_whatever_op_the_prim_has(stage, op):
    cube = UsdGeom.Cube.Define(stage, "/World/cube")
    getattr(cube, op)()
    execute("TransformPrimSRT", path="/World/cube", new_rotation_euler=Gf.Vec3d(0, 0, 30))
    assert Gf.IsClose(world(cube.GetPrim()), Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(0, 0, 1), 30)), 1e-6)


def test_what_is_selected_stays_so_when_it_moves(stage):
    stage.DefinePrim("/World/a/inner")
    current().selection.set_selected_prim_paths(["/World/a", "/World/a/inner"])
    execute("MovePrim", path_from="/World/a", path_to="/World/b")
    assert current().selection.get_selected_prim_paths() == ["/World/b", "/World/b/inner"]


def test_commands_may_be_grouped_and_are_not_undone(stage):
    with undo.group(), undo.disabled():
        execute("CreatePrim", prim_type="Cube", prim_path="/World/c")
    assert stage.GetPrimAtPath("/World/c")
    assert not undo.can_undo()
    with pytest.raises(Unsupported, match="keep the value"):
        undo.undo()


def test_properties_are_set_and_created(stage):
    UsdGeom.Cube.Define(stage, "/World/cube")
    execute("ChangeProperty", prop_path=Sdf.Path("/World/cube.size"), value=4.0, prev=None)
    assert stage.GetPrimAtPath("/World/cube").GetAttribute("size").Get() == 4.0
    with pytest.raises(BadPrim, match="no attribute 'mood'"):
        execute("ChangeProperty", prop_path="/World/cube.mood", value=1.0, prev=0.0)
    execute(
        "ChangeProperty", prop_path="/World/cube.mood", value=1.0, prev=0.0,
        type_to_create_if_not_exist=Sdf.ValueTypeNames.Float,
    )  # fmt: skip
    assert stage.GetPrimAtPath("/World/cube").GetAttribute("mood").Get() == 1.0


def test_materials_are_created_and_bound(stage):
    UsdGeom.Cube.Define(stage, "/World/cube")
    created = []
    get_context().get_selection().set_selected_prim_paths(["/World/cube"])
    execute("CreateAndBindMdlMaterialFromLibrary", mdl_name="OmniPBR.mdl", mtl_name="OmniPBR", mtl_created_list=created)
    assert created == ["/World/Looks/OmniPBR"]
    binding = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath("/World/cube"))
    assert binding.ComputeBoundMaterial()[0].GetPath() == "/World/Looks/OmniPBR"
    execute("CreatePreviewSurfaceMaterialPrim", mtl_path="/World/Looks/plain")
    execute(
        "BindMaterial",
        prim_path=["/World/cube"],
        material_path="/World/Looks/plain",
        strength="strongerThanDescendants",
    )
    assert binding.ComputeBoundMaterial()[0].GetPath() == "/World/Looks/plain"


@pytest.mark.parametrize("strength", [["strongerThanDescendants"], ["strongerThanDescendants"] * 2])
def test_materials_are_bound_with_strengths_in_a_list_as_in_kits_command_log(stage, strength):
    paths = [str(UsdGeom.Cube.Define(stage, f"/World/{name}").GetPath()) for name in ("a", "b")]
    execute("CreatePreviewSurfaceMaterialPrim", mtl_path="/World/Looks/plain")
    execute("BindMaterial", material_path="/World/Looks/plain", prim_path=paths, strength=strength)
    for path in paths:
        binding = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(path)).GetDirectBindingRel()
        assert UsdShade.MaterialBindingAPI.GetMaterialBindingStrength(binding) == "strongerThanDescendants"
    with pytest.raises(ArgumentError, match="3 entries for 2 prims"):
        execute(
            "BindMaterial", material_path="/World/Looks/plain", prim_path=paths, strength=["weakerThanDescendants"] * 3
        )


@pytest.mark.filterwarnings("error")
def test_the_only_context_may_be_named(stage, tmp_path):
    part = Usd.Stage.CreateNew(str(tmp_path / "part.usda"))
    part.SetDefaultPrim(UsdGeom.Cube.Define(part, "/part").GetPrim())
    part.Save()
    for command in ("CreateReference", "CreatePayload"):
        path = f"/World/{command}"
        execute(command, usd_context=get_context(), path_to=path, asset_path=str(tmp_path / "part.usda"))
        assert stage.GetPrimAtPath(path)


def test_inputs_of_materials_are_set_as_omni_usd_sets_them(stage, tmp_path):
    texture = tmp_path / "spots.png"
    Image.new("RGB", (2, 2)).save(texture)
    path = execute("CreateMdlMaterialPrim", mtl_url="OmniPBR.mdl", mtl_name="OmniPBR", mtl_path="/World/Looks/a")[1]
    material = stage.GetPrimAtPath(path)
    usd.create_material_input(material, "metallic_constant", 0.25, Sdf.ValueTypeNames.Float)
    usd.create_material_input(material, "diffuse_texture", str(texture), Sdf.ValueTypeNames.Asset, color_space="sRGB")
    shader = usd.get_shader_from_material(material)
    assert usd.get_shader_from_material(material, get_prim=True) == shader.GetPrim() == material.GetChild("Shader")
    assert shader.GetInput("metallic_constant").Get() == 0.25
    assert shader.GetInput("diffuse_texture").Get().path == str(texture)
    assert shader.GetInput("diffuse_texture").GetAttr().GetColorSpace() == "sRGB"
    assert material.GetChild("PreviewSurface").GetAttribute("inputs:metallic").Get() == 0.25
    with pytest.raises(BadPrim, match="OmniPBR has no input 'metallic_konstant'"):
        usd.create_material_input(material, "metallic_konstant", 0.5, Sdf.ValueTypeNames.Float)

    execute("CreatePreviewSurfaceMaterialPrim", mtl_path="/World/Looks/plain")
    plain = stage.GetPrimAtPath("/World/Looks/plain")
    usd.create_material_input(plain, "roughness", 0.75, Sdf.ValueTypeNames.Float)
    assert UsdShade.Material(plain).ComputeSurfaceSource()[0].GetInput("roughness").Get() == 0.75
    cube = UsdGeom.Cube.Define(stage, "/World/cube").GetPrim()
    assert usd.get_shader_from_material(cube) is None
    with pytest.raises(BadPrim, match="/World/cube is no material"):
        usd.create_material_input(cube, "roughness", 0.75, Sdf.ValueTypeNames.Float)


def test_local_transforms_leave_the_parents_out(stage):
    UsdGeom.Xform.Define(stage, "/World/a").AddTranslateOp().Set((5, 0, 0))
    UsdGeom.Cube.Define(stage, "/World/a/b").AddTranslateOp().Set((0, 2, 0))
    matrix = usd.get_local_transform_matrix(stage.GetPrimAtPath("/World/a/b"))
    assert matrix.Transform(Gf.Vec3d(0)) == Gf.Vec3d(0, 2, 0)
    scope = UsdGeom.Scope.Define(stage, "/World/scope").GetPrim()
    assert usd.get_local_transform_matrix(scope) == Gf.Matrix4d(1)


def test_physics_is_added(stage):
    UsdGeom.Cube.Define(stage, "/World/cube")
    execute("SetRigidBody", path="/World/cube", approximationShape="convexHull", kinematic=True)
    prim = stage.GetPrimAtPath("/World/cube")
    assert prim.HasAPI(UsdPhysics.RigidBodyAPI)
    assert prim.HasAPI(UsdPhysics.CollisionAPI)
    path = execute(
        "AddGroundPlaneCommand",
        planePath="/GroundPlane",
        axis="Z",
        size=10.0,
        position=Gf.Vec3f(0),
        color=Gf.Vec3f(0.5),
    )[1]
    assert path == "/World/GroundPlane"
    execute("AddPhysicsScene", stage=stage, path="/World/PhysicsScene")
    assert stage.GetPrimAtPath("/World/PhysicsScene").IsA(UsdPhysics.Scene)


def test_a_script_registers_its_own_commands(stage):
    class Twice(commands.Command):
        def __init__(self, value):
            self._value = value

        def do(self):
            return 2 * self._value

    commands.register(Twice)
    assert execute("Twice", value=4) == (True, 8)
    commands.unregister(Twice)
    with pytest.raises(Unsupported, match="no command 'Twice'"):
        execute("Twice", value=4)


def test_commands_are_made_first_and_executed_later(stage):
    # As omni.replicator.core's own test moves a prim: omni.kit.commands.create("MovePrim", ...).do().
    UsdGeom.Xform.Define(stage, "/World/a")
    move = commands.create("MovePrimCommand", path_from="/World/a", path_to="/World/b")
    assert isinstance(move, commands.Command)
    assert stage.GetPrimAtPath("/World/a")
    move.do()
    assert not stage.GetPrimAtPath("/World/a")
    assert stage.GetPrimAtPath("/World/b")
    with pytest.raises(Unsupported, match=r"no command 'MovePrimm'; did you mean .*MovePrim"):
        commands.create("MovePrimm", path_from="/World/b", path_to="/World/c")


def test_an_unknown_command_is_named_with_those_that_are_like_it(stage):
    with pytest.raises(Unsupported, match=r"no command 'CreatePrimm'; did you mean .*CreatePrim"):
        execute("CreatePrimm", prim_type="Cube")


def test_prims_without_a_pose_of_their_own_stay_where_their_file_has_them(stage, tmp_path):
    """Isaac Sim takes None for the position and the rotation."""
    source = Usd.Stage.CreateNew(str(tmp_path / "a.usda"))
    source.SetDefaultPrim(UsdGeom.Xform.Define(source, "/a").GetPrim())
    UsdGeom.XformCommonAPI(source.GetDefaultPrim()).SetTranslate((1, 2, 3))
    source.Save()
    execute(
        "IsaacSimSpawnPrim", usd_path=str(tmp_path / "a.usda"), prim_path="/World/b", translation=None, rotation=None
    )
    prim = stage.GetPrimAtPath("/World/b")
    assert world(prim).ExtractTranslation() == Gf.Vec3d(1, 2, 3)
    execute("IsaacSimTeleportPrim", prim_path="/World/b", translation=None)
    execute("IsaacSimScalePrim", prim_path="/World/b", scale=None)
    assert world(prim) == Gf.Matrix4d().SetTranslate(Gf.Vec3d(1, 2, 3))
    execute("IsaacSimTeleportPrim", prim_path="/World/b", translation=(4, 5, 6))
    execute("IsaacSimScalePrim", prim_path="/World/b", scale=(2, 2, 2))
    assert Gf.IsClose(world(prim), Gf.Matrix4d().SetScale(2.0).SetTranslateOnly(Gf.Vec3d(4, 5, 6)), 1e-9)
