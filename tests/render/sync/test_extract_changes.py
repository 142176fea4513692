"""Updates: the right tables and no others are touched, and the scene is what a fresh extraction gives."""

import gc

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdPhysics, UsdShade

from usdsdg_render.sync.extract import SceneExtractor

TABLES = ("prototypes", "instances", "transforms", "materials", "textures", "lights", "dome")


@pytest.fixture
def stage(tmp_path):
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.Xform.Define(stage, "/World").AddTranslateOp()
    for k in range(3):
        ball = UsdGeom.Sphere.Define(stage, f"/World/b{k}")
        ball.AddTranslateOp().Set(Gf.Vec3d(k, 0, 0))
        ball.CreateDisplayColorAttr([Gf.Vec3f(1, 0, 0)])
        ball.CreateVisibilityAttr()
        ball.CreatePurposeAttr()
    for name, value in (("a", 50), ("b", 200)):
        Image.fromarray(np.full((4, 4, 3), value, np.uint8)).save(tmp_path / f"{name}.png")
    for name in "mn":
        material = UsdShade.Material.Define(stage, f"/Looks/{name}")
        surface = UsdShade.Shader.Define(stage, f"/Looks/{name}/Surface")
        surface.CreateIdAttr("UsdPreviewSurface")
        surface.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(0.25)
        texture = UsdShade.Shader.Define(stage, f"/Looks/{name}/Tex")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(str(tmp_path / "a.png"))
        diffuse = surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
        diffuse.ConnectToSource(texture.ConnectableAPI(), "rgb")
        material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    mesh = UsdGeom.Mesh.Define(stage, "/World/mesh")
    mesh.CreatePointsAttr([Gf.Vec3f(0), Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(UsdShade.Material.Get(stage, "/Looks/m"))
    lamp = UsdLux.SphereLight.Define(stage, "/World/lamp")
    lamp.CreateIntensityAttr(5)
    lamp.AddTranslateOp()
    sky = UsdLux.DomeLight.Define(stage, "/sky")
    sky.CreateIntensityAttr(2)
    sky.AddRotateZOp()
    return stage


def touched(extractor):
    before = dict(extractor.scene.versions)
    extractor.update()
    return {table for table in TABLES if extractor.scene.versions[table] != before[table]}


def assert_fresh(extractor, stage):
    """An updated scene draws what one read from nothing draws; only the order of shared rows may differ."""
    anew = SceneExtractor(stage)
    anew.update()
    a, b = extractor.scene, anew.scene
    assert a.instances.paths == b.instances.paths
    np.testing.assert_array_equal(a.instances.local_to_world, b.instances.local_to_world)
    np.testing.assert_array_equal(a.instances.casts_shadow, b.instances.casts_shadow)
    np.testing.assert_array_equal(a.lights, b.lights)
    assert (a.dome is None) == (b.dome is None)
    if a.dome is not None and b.dome is not None:
        np.testing.assert_array_equal(a.dome.radiance, b.dome.radiance)
        np.testing.assert_array_equal(a.dome.dome_from_world, b.dome.dome_from_world)
    for k in range(len(a.instances)):
        ours, theirs = (scene.prototypes[scene.instances.prototype[k]] for scene in (a, b))
        for name in ("points", "triangles", "normals", "uvs", "triangle_slots", "triangle_faces"):
            np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name))
        for slot in np.unique(ours.triangle_slots):
            assert looks(a, k, slot) == looks(b, k, slot)


def looks(scene, instance, slot):
    """A material row with textures instead of their numbers."""
    row = scene.materials[scene.material_slots[scene.instances.slot_offset[instance] + slot]]
    values = []
    for name in row.dtype.names:
        value = row[name].tolist()
        if name.endswith("_texture") and value >= 0:
            texture = scene.textures[value]
            value = (texture.path, texture.texels.tobytes(), texture.srgb)
        values.append(value)
    return values


def attribute(stage, path):
    return stage.GetAttributeAtPath(path)


def surface_input(stage, name, value):
    attribute(stage, f"/Looks/m/Surface.inputs:{name}").Set(value)


EDITS = {
    "move a gprim": (lambda s: attribute(s, "/World/b1.xformOp:translate").Set(Gf.Vec3d(9)), {"transforms"}),
    "move what is above all": (
        lambda s: attribute(s, "/World.xformOp:translate").Set(Gf.Vec3d(9)),
        {"transforms", "lights"},
    ),
    "move a light": (lambda s: attribute(s, "/World/lamp.xformOp:translate").Set(Gf.Vec3d(9)), {"lights"}),
    "turn the sky": (lambda s: attribute(s, "/sky.xformOp:rotateZ").Set(45.0), {"dome"}),
    "add an xform op": (
        lambda s: UsdGeom.Xformable(s.GetPrimAtPath("/World/b1")).AddScaleOp().Set(Gf.Vec3f(2)),
        {"transforms"},
    ),
    "light intensity": (lambda s: attribute(s, "/World/lamp.inputs:intensity").Set(7.0), {"lights"}),
    "light color, not authored before": (
        lambda s: attribute(s, "/World/lamp.inputs:color").Set(Gf.Vec3f(1, 0, 0)),
        {"lights"},
    ),
    "sky intensity": (lambda s: attribute(s, "/sky.inputs:intensity").Set(3.0), {"dome"}),
    "a constant of a material": (lambda s: surface_input(s, "roughness", 0.75), {"materials"}),
    "a new input of a material": (
        lambda s: (
            UsdShade.Shader(s.GetPrimAtPath("/Looks/m/Surface"))
            .CreateInput("metallic", Sdf.ValueTypeNames.Float)
            .Set(1.0)
        ),
        {"materials"},
    ),
    "display color": (
        lambda s: attribute(s, "/World/b1.primvars:displayColor").Set([Gf.Vec3f(0, 1, 0)]),
        {"materials"},
    ),
    "hide": (lambda s: UsdGeom.Imageable(s.GetPrimAtPath("/World/b1")).MakeInvisible(), {"instances", "transforms"}),
    "purpose": (lambda s: attribute(s, "/World/b1.purpose").Set("guide"), {"instances", "transforms"}),
    "hide a light": (lambda s: UsdGeom.Imageable(s.GetPrimAtPath("/World/lamp")).MakeInvisible(), {"lights"}),
    "hide the sky": (lambda s: UsdGeom.Imageable(s.GetPrimAtPath("/sky")).MakeInvisible(), {"dome"}),
    "radius": (lambda s: attribute(s, "/World/b1.radius").Set(2.0), {"prototypes", "instances"}),
    "points": (
        lambda s: attribute(s, "/World/mesh.points").Set([Gf.Vec3f(0), Gf.Vec3f(3, 0, 0), Gf.Vec3f(0, 1, 0)]),
        {"prototypes", "instances"},
    ),
    "a new gprim of a known shape": (
        lambda s: s.DefinePrim("/World/b3", "Sphere"),
        {"instances", "transforms", "materials"},
    ),
    "a removed gprim": (lambda s: s.RemovePrim("/World/b1"), {"instances", "transforms"}),
    "a new light": (lambda s: s.DefinePrim("/lamp2", "RectLight"), {"lights"}),
    "another material with the same look": (
        lambda s: UsdShade.MaterialBindingAPI(s.GetPrimAtPath("/World/mesh")).Bind(
            UsdShade.Material.Get(s, "/Looks/n")
        ),
        set(),
    ),
    "a gprim becomes a light": (
        lambda s: UsdLux.MeshLightAPI.Apply(s.GetPrimAtPath("/World/mesh")),
        {"materials"},
    ),
    "up axis": (lambda s: UsdGeom.SetStageUpAxis(s, "Y"), {"dome"}),
    # What other engines and scripts write every frame, or once, and nobody sees.
    "a camera": (lambda s: s.DefinePrim("/cam", "Camera"), set()),
    "a physics property": (
        lambda s: UsdPhysics.RigidBodyAPI(s.GetPrimAtPath("/World/b1")).CreateVelocityAttr(Gf.Vec3f(1)),
        set(),
    ),
    "a physics schema": (lambda s: UsdPhysics.CollisionAPI.Apply(s.GetPrimAtPath("/World/b1")), set()),
    "a material nobody uses": (
        lambda s: UsdShade.Shader(s.GetPrimAtPath("/Looks/n/Surface")).GetInput("roughness").Set(0.9),
        set(),
    ),
    "the same value": (lambda s: surface_input(s, "roughness", 0.25), set()),
    "nothing": (lambda s: None, set()),
}


@pytest.mark.parametrize("name", EDITS)
def test_an_edit_touches_its_tables_and_no_others(name, stage, extractor):
    edit, tables = EDITS[name]
    edit(stage)
    assert touched(extractor) == tables
    assert_fresh(extractor, stage)
    assert touched(extractor) == set()


def test_another_texture_file_touches_textures(stage, extractor, tmp_path):
    attribute(stage, "/Looks/m/Tex.inputs:file").Set(str(tmp_path / "b.png"))
    assert touched(extractor) == {"materials", "textures"}
    assert_fresh(extractor, stage)
    attribute(stage, "/Looks/m/Tex.inputs:file").Set(str(tmp_path / "a.png"))
    assert touched(extractor) == {"materials"}, "the first texture is still there"
    assert_fresh(extractor, stage)


def test_another_sky_touches_the_dome(stage, extractor, tmp_path):
    UsdLux.DomeLight(stage.GetPrimAtPath("/sky")).CreateTextureFileAttr(str(tmp_path / "a.png"))
    assert touched(extractor) == {"dome"}
    assert extractor.scene.dome.radiance.shape == (4, 4, 3)
    assert_fresh(extractor, stage)


def test_hiding_and_showing_again_gives_the_same_scene(stage, extractor):
    before = extractor.scene.instances
    for visibility in ("invisible", "inherited"):
        attribute(stage, "/World/b1.visibility").Set(visibility)
        assert touched(extractor) == {"instances", "transforms"}
        assert_fresh(extractor, stage)
    np.testing.assert_array_equal(extractor.scene.instances.prototype, before.prototype)
    np.testing.assert_array_equal(extractor.scene.instances.slot_offset, before.slot_offset)


def test_a_prim_that_moves_while_another_appears_is_where_it_moved_to(stage, extractor):
    for place, visibility in enumerate(("invisible", "invisible", "invisible", "inherited", "inherited"), 1):
        attribute(stage, "/World/b0.visibility").Set(visibility)
        for k in range(3):
            attribute(stage, f"/World/b{k}.xformOp:translate").Set(Gf.Vec3d(k, place, 0))
        extractor.update()
        assert_fresh(extractor, stage)


def test_a_transform_that_breaks_and_heals(stage, extractor):
    op = attribute(stage, "/World/b1.xformOp:translate")
    op.Set(Gf.Vec3d(float("nan"), 0, 0))
    with pytest.warns(UserWarning, match="/World/b1"):
        assert touched(extractor) == {"instances", "transforms"}
    assert extractor.scene.instances.paths == ("/World/b0", "/World/b2", "/World/mesh")
    op.Set(Gf.Vec3d(4, 0, 0))
    assert touched(extractor) == {"instances", "transforms"}
    assert_fresh(extractor, stage)


def test_a_material_changed_while_nobody_used_it(stage, extractor):
    api = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath("/World/mesh"))
    api.UnbindAllBindings()
    extractor.update()
    surface_input(stage, "roughness", 0.125)
    extractor.update()
    api.Bind(UsdShade.Material.Get(stage, "/Looks/m"))
    extractor.update()
    assert_fresh(extractor, stage)


def test_a_shader_in_a_graph_outside_the_material(stage, extractor):
    graph = UsdShade.NodeGraph.Define(stage, "/Looks/graph")
    value = graph.CreateInput("rough", Sdf.ValueTypeNames.Float)
    value.Set(0.5)
    output = graph.CreateOutput("rough", Sdf.ValueTypeNames.Float)
    output.ConnectToSource(value)
    surface = UsdShade.Shader(stage.GetPrimAtPath("/Looks/m/Surface"))
    surface.GetInput("roughness").ConnectToSource(output)
    extractor.update()
    assert_fresh(extractor, stage)
    value.Set(0.875)
    assert touched(extractor) == {"materials"}
    assert 0.875 in extractor.scene.materials["roughness"]
    assert_fresh(extractor, stage)


@pytest.mark.parametrize("instanceable", [False, True])
def test_edits_of_a_referenced_layer_reach_all_who_use_it(instanceable, tmp_path):
    asset = Usd.Stage.CreateNew(str(tmp_path / "asset.usda"))
    root = UsdGeom.Xform.Define(asset, "/Asset")
    asset.SetDefaultPrim(root.GetPrim())
    ball = UsdGeom.Sphere.Define(asset, "/Asset/Ball")
    ball.AddTranslateOp().Set(Gf.Vec3d(1, 0, 0))
    stage = Usd.Stage.CreateInMemory()
    for k in range(3):
        prim = stage.DefinePrim(f"/o{k}", "Xform")
        prim.GetReferences().AddReference(asset.GetRootLayer().identifier)
        prim.SetInstanceable(instanceable)
    extractor = SceneExtractor(stage)
    extractor.update()
    for edit in (
        lambda: ball.GetRadiusAttr().Set(3.0),
        lambda: ball.GetPrim().GetAttribute("xformOp:translate").Set(Gf.Vec3d(5, 0, 0)),
        lambda: ball.CreateDisplayColorAttr([Gf.Vec3f(0, 0, 1)]),
        lambda: ball.MakeInvisible(),
        lambda: UsdGeom.Cube.Define(asset, "/Asset/Box"),
    ):
        edit()
        extractor.update()
        assert_fresh(extractor, stage)


def test_point_instancers_follow_their_points_and_prototypes():
    stage = Usd.Stage.CreateInMemory()
    instancer = UsdGeom.PointInstancer.Define(stage, "/Points")
    ball = UsdGeom.Sphere.Define(stage, "/Points/Ball")
    ball.AddTranslateOp().Set(Gf.Vec3d(0))
    instancer.CreatePrototypesRel().SetTargets(["/Points/Ball"])
    positions = instancer.CreatePositionsAttr([Gf.Vec3f(k, 0, 0) for k in range(3)])
    instancer.CreateProtoIndicesAttr([0, 0, 0])
    move = UsdGeom.Xformable(instancer).AddTranslateOp()
    move.Set(Gf.Vec3d(0))
    extractor = SceneExtractor(stage)
    extractor.update()
    positions.Set([Gf.Vec3f(k, 5, 0) for k in range(3)])
    assert touched(extractor) == {"transforms"}
    assert_fresh(extractor, stage)
    move.Set(Gf.Vec3d(0, 0, 3))
    assert touched(extractor) == {"transforms"}
    assert_fresh(extractor, stage)
    ball.GetRadiusAttr().Set(4.0)
    assert touched(extractor) == {"prototypes", "instances"}
    assert_fresh(extractor, stage)
    ball.GetPrim().GetAttribute("xformOp:translate").Set(Gf.Vec3d(1))
    assert touched(extractor) == {"transforms"}
    assert_fresh(extractor, stage)
    instancer.DeactivateId(1)  # metadata
    assert touched(extractor)
    assert_fresh(extractor, stage)
    instancer.DeactivateId(2)  # beside a property
    move.Set(Gf.Vec3d(0, 0, 5))
    assert "instances" in touched(extractor)
    assert_fresh(extractor, stage)


def test_random_edits_end_where_a_fresh_reading_does(stage, extractor, tmp_path):
    """Many edits in any order, several an update, as a randomizing script makes them."""
    rng = np.random.default_rng(7)
    made = 0
    for _ in range(60):
        for _ in range(rng.integers(1, 4)):
            names = [str(p.GetPath()) for p in stage.GetPrimAtPath("/World").GetChildren() if p.IsA(UsdGeom.Sphere)]
            path = names[rng.integers(len(names))]
            prim = stage.GetPrimAtPath(path)
            match rng.integers(10):
                case 0 | 1:
                    UsdGeom.XformCommonAPI(prim).SetTranslate(Gf.Vec3d(*rng.normal(size=3)))
                case 2:
                    visible = rng.random() < 0.7
                    UsdGeom.Imageable(prim).CreateVisibilityAttr("inherited" if visible else "invisible")
                case 3:
                    UsdGeom.Gprim(prim).CreateDisplayColorAttr([Gf.Vec3f(*rng.integers(0, 3, 3).tolist())])
                case 4:
                    UsdGeom.Sphere(prim).GetRadiusAttr().Set(float(rng.integers(1, 4)))
                case 5:
                    made += 1
                    UsdGeom.Sphere.Define(stage, f"/World/new{made}")
                case 6 if len(names) > 2:
                    stage.RemovePrim(path)
                case 7:
                    material = UsdShade.Material.Get(stage, f"/Looks/{rng.choice(['m', 'n'])}")
                    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)
                case 8:
                    surface_input(stage, "roughness", float(rng.integers(0, 4)) / 4)
                case 9:
                    attribute(stage, "/Looks/n/Tex.inputs:file").Set(str(tmp_path / f"{rng.choice(['a', 'b'])}.png"))
        extractor.update()
        assert_fresh(extractor, stage)


def _becomes_a_prototype(stage):
    points = UsdGeom.PointInstancer.Define(stage, "/Points")
    points.CreatePrototypesRel().SetTargets(["/World/b0"])
    points.CreateProtoIndicesAttr([0, 0])
    points.CreatePositionsAttr([Gf.Vec3f(0, 0, 3), Gf.Vec3f(0, 0, 5)])


def _leaves_and_comes_back(stage):
    stage.RemovePrim("/World/b0")
    ball = UsdGeom.Sphere.Define(stage, "/World/b0")
    ball.AddTranslateOp().Set(Gf.Vec3d(0, 9, 0))


def _moves_over_to_another_order(stage):
    ball = UsdGeom.Xformable(stage.GetPrimAtPath("/World/b0"))
    ball.AddScaleOp().Set(Gf.Vec3f(2))
    ball.SetXformOpOrder(list(reversed(ball.GetOrderedXformOps())))


def _gets_time_samples(stage):
    stage.GetAttributeAtPath("/World/b0.xformOp:translate").Set(Gf.Vec3d(0, 4, 0), 3.0)


def _another_comes_before_it(stage):
    UsdGeom.Cube.Define(stage, "/World/a_first")
    UsdGeom.SetStageUpAxis(stage, "Y")
    stage.GetPrimAtPath("/World").SetMetadata("primOrder", ["b1", "a_first", "b0"])


def _is_hidden(stage):
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/b0")).MakeInvisible()


def _gets_a_stronger_opinion(stage):
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        stage.GetAttributeAtPath("/World/b0.xformOp:translate").Set(Gf.Vec3d(0, 0, 8))


@pytest.mark.parametrize(
    "happens",
    [
        _becomes_a_prototype,
        _leaves_and_comes_back,
        _moves_over_to_another_order,
        _gets_time_samples,
        _another_comes_before_it,
        _is_hidden,
        _gets_a_stronger_opinion,
    ],
)
def test_what_moves_again_and_again_is_followed_through_other_changes(happens, stage, extractor):
    def move(x):
        stage.GetAttributeAtPath("/World/b0.xformOp:translate").Set(Gf.Vec3d(x, 1, 0))
        extractor.update()
        assert_fresh(extractor, stage)

    move(1)
    move(2)
    happens(stage)
    extractor.update()
    assert_fresh(extractor, stage)
    move(3)
    move(4)
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/b0")).MakeVisible()
    move(5)


def test_hiding_and_showing_again_traverses_nothing(stage, extractor, monkeypatch):
    def traverse(tree, roots):
        raise AssertionError(f"{roots} are traversed again")

    extractor.update()
    ball, world = (UsdGeom.Imageable(stage.GetPrimAtPath(path)) for path in ("/World/b0", "/World"))
    with monkeypatch.context() as patched:
        patched.setattr("usdsdg_render.usd.stage_tree.StageTree.resync", traverse)
        for change in (ball.MakeInvisible, world.MakeInvisible, ball.MakeVisible, world.MakeVisible):
            change()
            extractor.update()
    assert_fresh(extractor, stage)


def test_attributes_of_a_script_are_no_reason_to_read_a_gprim_again(stage, extractor, monkeypatch):
    def read(gprims, *, everything):
        raise AssertionError("gprims are read again")

    ball = stage.GetPrimAtPath("/World/b0")
    assert ball.IsA(UsdGeom.Gprim)
    values = [ball.CreateAttribute(name, Sdf.ValueTypeNames.Float) for name in ("mine:weight", "omni:isaac:score")]
    extractor.update()
    with monkeypatch.context() as patched:
        patched.setattr(extractor, "_read_gprims", read)
        for value in (1.0, 2.0):
            for attribute in values:
                attribute.Set(value)
            extractor.update()
    assert_fresh(extractor, stage)


def test_a_layer_that_moves_prims_before_their_siblings(stage, extractor):
    """USD tells of the new prims alone, and orders their ancestors anew."""
    UsdGeom.Cube.Define(stage, "/World/last/box")
    extractor.update()
    layer = Sdf.Layer.CreateAnonymous()
    for path in ("/World/new", "/World/last/more"):
        added = Sdf.CreatePrimInLayer(layer, path)
        added.specifier, added.typeName = Sdf.SpecifierDef, "Cube"
    stage.GetRootLayer().subLayerPaths.append(layer.identifier)
    extractor.update()
    assert [path.split("/")[2] for path in extractor.scene.instances.paths][:3] == ["new", "last", "last"]
    assert_fresh(extractor, stage)


def test_an_opinion_in_a_weaker_layer_moves_prims_once_a_sibling_is_composed_again(stage, extractor):
    """USD orders children by the weakest layer first, and does so only when it composes one of them."""
    layer = Sdf.Layer.CreateAnonymous()
    stage.GetRootLayer().subLayerPaths.append(layer.identifier)
    with Usd.EditContext(stage, layer):
        attribute(stage, "/World/b2.radius").Set(0.25)
    extractor.update()
    stage.RemovePrim("/World/b0")
    extractor.update()
    assert [path.split("/")[2] for path in extractor.scene.instances.paths] == ["b2", "b1", "mesh"]
    assert_fresh(extractor, stage)


def test_closing_stops_listening(stage, extractor):
    extractor.close()
    attribute(stage, "/World/b1.radius").Set(5.0)
    assert touched(extractor) == set()
    gc.collect()
