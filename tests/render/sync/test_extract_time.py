"""Scenes at a time: everything that has samples is read there, and a new time reads no more than what varies."""

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, UsdSkel

from tests.render.sync.test_extract_scene import TRIANGLE, add_material, add_mesh, base_colors, bind, make_stage
from tests.stage.geometry.characters import LENGTH, SIDES, add_character
from usdsdg.stage.poses.transforms import local_to_world
from usdsdg_render.sync.extract import SceneExtractor


def at(extractor, code):
    before = dict(extractor.scene.versions)
    extractor.update(Usd.TimeCode(code))
    scene = extractor.scene
    return scene, {table for table, version in scene.versions.items() if version != before[table]}


def moving_box(stage, path="/Mover/Box"):
    mover = UsdGeom.Xform.Define(stage, Usd.Stage.GetPseudoRoot(stage).GetPath().AppendPath(path[1:]).GetParentPath())
    op = mover.AddTranslateOp()
    op.Set(Gf.Vec3d(0, 0, 0), 0)
    op.Set(Gf.Vec3d(10, 0, 0), 10)
    return stage.DefinePrim(path, "Cube")


def test_transforms_follow_the_time_and_nothing_else_is_touched():
    stage = make_stage()
    box = moving_box(stage)
    stage.DefinePrim("/Still", "Sphere")
    extractor = SceneExtractor(stage)
    scene, _ = at(extractor, 0)
    for code in (2.5, 10.0, 4.0, 99.0):
        scene, touched = at(extractor, code)
        np.testing.assert_allclose(scene.instances.local_to_world[0], np.array(local_to_world(box, Usd.TimeCode(code))))
        assert touched == {"transforms"}
    assert at(extractor, 99.0)[1] == set()


def test_a_stage_without_samples_has_one_time():
    stage = make_stage()
    stage.DefinePrim("/Box", "Cube")
    extractor = SceneExtractor(stage)
    at(extractor, 0)
    assert at(extractor, 7)[1] == set()


def test_scripts_may_author_the_first_samples():
    stage = make_stage()
    box = UsdGeom.Cube.Define(stage, "/Box")
    op = box.AddTranslateOp()
    op.Set(Gf.Vec3d(1, 0, 0))
    extractor = SceneExtractor(stage)
    at(extractor, 0)
    op.Set(Gf.Vec3d(0, 0, 0), 0)
    op.Set(Gf.Vec3d(8, 0, 0), 8)
    assert at(extractor, 4)[0].instances.local_to_world[0, 3, 0] == 4
    op.Set(Gf.Vec3d(16, 0, 0), 8)
    assert at(extractor, 4)[0].instances.local_to_world[0, 3, 0] == 8


def test_defaults_written_between_stay_where_there_are_no_samples():
    stage = make_stage()
    moving_box(stage)
    free = UsdGeom.Cube.Define(stage, "/Free")
    op = free.AddTranslateOp()
    op.Set(Gf.Vec3d(1, 2, 3))
    extractor = SceneExtractor(stage)
    at(extractor, 1)
    op.Set(Gf.Vec3d(4, 5, 6))
    scene, _ = at(extractor, 2)
    assert scene.instances.local_to_world[:, 3, 0].tolist() == [2, 4]


def test_visibility_comes_and_goes():
    stage = make_stage()
    group = UsdGeom.Xform.Define(stage, "/Group")
    stage.DefinePrim("/Group/Box", "Cube")
    stage.DefinePrim("/Still", "Cube")
    group.CreateVisibilityAttr().Set("invisible", 0)
    group.GetVisibilityAttr().Set("inherited", 5)
    extractor = SceneExtractor(stage)
    assert [len(at(extractor, code)[0].instances) for code in (0, 4, 5, 9, 1)] == [1, 1, 2, 2, 1]
    assert at(extractor, 2)[1] == set()


@pytest.mark.parametrize("how", ["remove", "deactivate", "mute", "retime", "instance"])
def test_what_comes_and_goes_may_be_gone_or_made_anew_at_the_next_time(how, tmp_path):
    part = Usd.Stage.CreateNew(str(tmp_path / "part.usda"))
    part.SetDefaultPrim(part.DefinePrim("/Part", "Xform"))
    box = UsdGeom.Cube.Define(part, "/Part/Box")
    for code, shown in ((0, "inherited"), (5, "invisible")):
        box.CreateVisibilityAttr().Set(shown, code)
    part.Save()
    stage = make_stage()
    blinking = stage.DefinePrim("/Blinking", "Xform")
    blinking.GetReferences().AddReference(part.GetRootLayer().identifier)
    stage.DefinePrim("/Still", "Cube")
    extractor = SceneExtractor(stage)
    assert at(extractor, 0)[0].instances.paths == ("/Blinking/Box", "/Still")
    edits = {
        "remove": lambda: stage.RemovePrim("/Blinking"),
        "deactivate": lambda: blinking.SetActive(False),
        "mute": lambda: stage.MuteLayer(part.GetRootLayer().identifier),
        "retime": lambda: stage.SetTimeCodesPerSecond(48),  # the samples of the part are at 0 and 10 then
        "instance": lambda: blinking.SetInstanceable(True),
    }
    edits[how]()
    for code in (6, 0, 12):
        scene, _ = at(extractor, code)
        box = stage.GetPrimAtPath("/Blinking/Box")
        is_shown = bool(box) and UsdGeom.Imageable(box).ComputeVisibility(code) == "inherited"
        assert scene.instances.paths == (("/Blinking/Box",) if is_shown else ()) + ("/Still",)


def test_points_sizes_and_topology_follow_the_time():
    stage = make_stage()
    mesh = add_mesh(stage, "/Mesh")
    still = add_mesh(stage, "/Still")
    mesh.GetPointsAttr().Set(TRIANGLE, 0)
    mesh.GetPointsAttr().Set([p * 3 for p in TRIANGLE], 10)
    ball = UsdGeom.Sphere.Define(stage, "/Ball")
    ball.CreateRadiusAttr().Set(1.0, 0)
    ball.GetRadiusAttr().Set(2.0, 10)
    extractor = SceneExtractor(stage)
    at(extractor, 0)
    scene, touched = at(extractor, 5)
    sizes = [scene.prototypes[k].points.max() for k in scene.instances.prototype]
    np.testing.assert_allclose(sizes, [2.0, 1.0, 1.5])
    assert touched == {"prototypes", "instances"}
    assert still


def test_layer_offsets_give_each_reference_its_own_time(tmp_path):
    asset = Usd.Stage.CreateNew(str(tmp_path / "moving.usda"))
    asset.SetDefaultPrim(UsdGeom.Xform.Define(asset, "/Asset").GetPrim())
    mesh = add_mesh(asset, "/Asset/Mesh")
    mesh.GetPointsAttr().Set(TRIANGLE, 0)
    mesh.GetPointsAttr().Set([p * 3 for p in TRIANGLE], 10)
    asset.Save()
    stage = make_stage()
    for k in range(3):
        prim = stage.DefinePrim(f"/o{k}", "Xform")
        prim.GetReferences().AddReference(asset.GetRootLayer().identifier, Sdf.LayerOffset(offset=5.0 * (k == 1)))
    scene, _ = at(SceneExtractor(stage), 5)
    sizes = [scene.prototypes[k].points.max() for k in scene.instances.prototype]
    np.testing.assert_allclose(sizes, [2.0, 1.0, 2.0])
    assert len(scene.prototypes) == 2, "equal shapes meet through their content"


def test_display_colors_follow_the_time():
    stage = make_stage()
    ball = UsdGeom.Sphere.Define(stage, "/Ball")
    color = ball.CreateDisplayColorAttr()
    color.Set([Gf.Vec3f(1, 0, 0)], 0)
    color.Set([Gf.Vec3f(0, 1, 0)], 10)
    extractor = SceneExtractor(stage)
    assert base_colors(at(extractor, 0)[0], 0)[0] == [1, 0, 0]
    np.testing.assert_allclose(base_colors(at(extractor, 5)[0], 0)[0], [0.5, 0.5, 0])


def test_point_instancers_follow_positions_and_velocities():
    stage = make_stage()
    instancer = UsdGeom.PointInstancer.Define(stage, "/Points")
    stage.DefinePrim("/Points/Box", "Cube")
    instancer.CreatePrototypesRel().SetTargets(["/Points/Box"])
    instancer.CreateProtoIndicesAttr([0, 0])
    stage.SetTimeCodesPerSecond(10)
    positions, velocities = instancer.CreatePositionsAttr(), instancer.CreateVelocitiesAttr()
    positions.Set([Gf.Vec3f(0), Gf.Vec3f(0, 5, 0)], 0)
    velocities.Set([Gf.Vec3f(20, 0, 0), Gf.Vec3f(0)], 0)
    extractor = SceneExtractor(stage)
    for code in (0, 3):
        scene, _ = at(extractor, code)
        # 20 units a second at 10 codes a second
        np.testing.assert_allclose(scene.instances.local_to_world[:, 3, :2], [[2.0 * code, 0], [0, 5]])
    velocities.Set([Gf.Vec3f(40, 0, 0), Gf.Vec3f(0)], 0)
    assert at(extractor, 3)[0].instances.local_to_world[0, 3, 0] == pytest.approx(12.0)


def moving_points(stage, kind):
    """Three points (0 to 2 along x) with a sample at time code 0 and at 10: 24 units a second, twice that a second."""
    prim = add_mesh(stage, "/Moving").GetPrim() if kind == "Mesh" else stage.DefinePrim("/Moving", kind)
    stage.SetTimeCodesPerSecond(24)
    rest = [Gf.Vec3f(0, 0, 0), Gf.Vec3f(1, 1, 0), Gf.Vec3f(2, 0, 0)]
    prim.GetAttribute("points").Clear()
    for time, shift in ((0, 0), (10, 100)):
        prim.GetAttribute("points").Set([p + Gf.Vec3f(shift, 0, 0) for p in rest], time)
        prim.GetAttribute("velocities").Set([Gf.Vec3f(24, 0, 0)] * 3, time)
        prim.GetAttribute("accelerations").Set([Gf.Vec3f(0, 0, 2 * 24 * 24)] * 3, time)
    if kind != "Mesh":
        prim.GetAttribute("widths").Set([0.5] * 3)
    if kind == "BasisCurves":
        prim.GetAttribute("type").Set("linear")
        prim.GetAttribute("curveVertexCounts").Set([3])
    return prim


@pytest.mark.parametrize("kind", ["Mesh", "Points", "BasisCurves"])
def test_velocities_and_accelerations_move_points_from_the_last_sample_on(kind):
    stage = make_stage()
    prim = moving_points(stage, kind)
    extractor = SceneExtractor(stage)
    resting = at(extractor, 0)[0].prototypes[0].points.astype(float)
    for code in (1, 2.5, 10, 12, 0, -1):
        scene, _ = at(extractor, code)
        since = code if code < 10 else code - 10
        shift = (since + (0 if code < 10 else 100), 0, since**2)  # v t + a t2 / 2, in time codes
        drawn = scene.prototypes[scene.instances.prototype[0]].points
        np.testing.assert_allclose(drawn, resting + shift, atol=1e-4)
        usds = np.array(UsdGeom.PointBased(prim).ComputePointsAtTime(code, code))
        np.testing.assert_allclose(usds[0], shift, atol=1e-4)


def test_one_sample_of_points_and_velocities_moves_them():
    stage = make_stage()
    prim = moving_points(stage, "Mesh")
    for name in ("points", "velocities", "accelerations"):
        prim.GetAttribute(name).ClearAtTime(10)
    extractor = SceneExtractor(stage)
    for code in (0, 3):
        assert at(extractor, code)[0].prototypes[-1].points[0].tolist() == [code, 0, code**2]
    prim.GetAttribute("velocities").Set([Gf.Vec3f(48, 0, 0)] * 3, 0)
    assert at(extractor, 3)[0].prototypes[-1].points[0].tolist() == [6, 0, 9]


@pytest.mark.parametrize(
    ("velocities", "time", "said"),
    [
        (2, 0, "at time code 0 there are 3 points and 2 velocities"),
        (3, 4, "its velocities have no sample at time code 0, at which its points have one"),
    ],
)
def test_velocities_that_do_not_fit_are_named_and_move_nothing(velocities, time, said):
    stage = make_stage()
    prim = moving_points(stage, "Mesh")
    prim.GetAttribute("velocities").Clear()
    prim.GetAttribute("velocities").Set([Gf.Vec3f(24, 0, 0)] * velocities, time)
    extractor = SceneExtractor(stage)
    with pytest.warns(UserWarning, match=f"/Moving: {said}"):
        scene, _ = at(extractor, 5)
    assert scene.prototypes[0].points[0].tolist() == [50, 0, 0]  # between 0 and 100


def test_skinned_meshes_bend_and_the_rest_stays():
    stage = make_stage()
    mesh = add_character(stage)
    stage.DefinePrim("/Still", "Cube")
    extractor = SceneExtractor(stage)
    scene, _ = at(extractor, 0)
    before = scene.prototypes[scene.instances.prototype[1]]
    for code in (0, 12, 24):
        scene, touched = at(extractor, code)
        body = scene.prototypes[scene.instances.prototype[0]]
        bend = np.radians(90 * code / 24)
        end = body.points[-SIDES:].mean(axis=0)
        expected = [0, -np.sin(bend), LENGTH / 2 - 0.5 * code / 24 + np.cos(bend)]
        np.testing.assert_allclose(end, expected, atol=1e-6)
        assert touched <= {"prototypes", "instances"}
    assert scene.prototypes[scene.instances.prototype[1]] is before
    assert mesh


@pytest.mark.parametrize("edit", ["animation", "binding", "skeleton", "mesh"])
def test_edits_of_a_skeleton_move_what_it_shapes(edit):
    stage = make_stage()
    mesh = add_character(stage)
    skeleton = stage.GetPrimAtPath("/Character/Skeleton")
    op = UsdGeom.Xformable(skeleton).AddTranslateOp()
    own = mesh.AddTranslateOp()
    op.Set(Gf.Vec3d(0))
    own.Set(Gf.Vec3d(0))
    extractor = SceneExtractor(stage)
    at(extractor, 24)

    def end():
        scene, _ = at(extractor, 24)
        points = scene.prototypes[scene.instances.prototype[0]].points[-SIDES:].mean(axis=0)
        return points @ scene.instances.local_to_world[0, :3, :3] + scene.instances.local_to_world[0, 3, :3]

    bent = np.array([0, -LENGTH / 2, LENGTH / 2 - 0.5])
    np.testing.assert_allclose(end(), bent, atol=1e-6)
    if edit == "animation":
        animation = UsdSkel.Animation(stage.GetPrimAtPath("/Character/Bend"))
        animation.GetTranslationsAttr().Set([Gf.Vec3f(3, 0, -0.5), Gf.Vec3f(0, 0, 1)], 24)
        expected = bent + np.array([3, 0, 0])
    elif edit == "binding":
        UsdSkel.BindingAPI(skeleton).GetAnimationSourceRel().ClearTargets(True)
        expected = [0, 0, LENGTH]
    elif edit == "skeleton":
        op.Set(Gf.Vec3d(0, 0, 7))
        expected = bent + np.array([0, 0, 7])
    else:  # a mesh's own transform does not count: its skeleton says where it is
        own.Set(Gf.Vec3d(9, 9, 9))
        expected = bent
    np.testing.assert_allclose(end(), expected, atol=1e-5)


def test_instanced_characters_are_skinned(tmp_path):
    asset = Usd.Stage.CreateNew(str(tmp_path / "character.usda"))
    add_character(asset, "/Character")
    asset.SetDefaultPrim(asset.GetPrimAtPath("/Character"))
    asset.Save()
    stage = make_stage()
    for k in range(2):
        prim = stage.DefinePrim(f"/c{k}")
        prim.GetReferences().AddReference(asset.GetRootLayer().identifier)
        prim.SetInstanceable(True)
        UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(5 * k, 0, 0))
    scene, _ = at(SceneExtractor(stage), 24)
    assert len(scene.prototypes) == 1
    body = scene.prototypes[0].points[-SIDES:].mean(axis=0)
    np.testing.assert_allclose(body, [0, -LENGTH / 2, LENGTH / 2 - 0.5], atol=1e-6)
    assert scene.instances.local_to_world[:, 3, 0].tolist() == [0, 5]


@pytest.mark.parametrize("instanced", [False, True])
def test_characters_of_a_point_instancer_are_skinned_at_each_time(instanced):
    stage = make_stage()
    crowd = UsdGeom.PointInstancer.Define(stage, "/Crowd")
    add_character(stage, "/_class_Walker" if instanced else "/Crowd/Walker")
    if instanced:
        walker = stage.DefinePrim("/Crowd/Walker")
        walker.GetReferences().AddInternalReference("/_class_Walker")
        walker.SetInstanceable(True)
        stage.GetPrimAtPath("/_class_Walker").SetSpecifier(Sdf.SpecifierClass)
    crowd.CreatePrototypesRel().SetTargets([Sdf.Path("/Crowd/Walker")])
    crowd.CreateProtoIndicesAttr([0, 0])
    crowd.CreatePositionsAttr([Gf.Vec3f(0), Gf.Vec3f(5, 0, 0)])
    extractor = SceneExtractor(stage)

    def end():
        (prototype,) = set(extractor.scene.instances.prototype.tolist())
        return extractor.scene.prototypes[prototype].points[-SIDES:].mean(axis=0)

    for code in (0, 12, 24):
        at(extractor, code)
        bend = np.radians(90 * code / 24)
        np.testing.assert_allclose(end(), [0, -np.sin(bend), LENGTH / 2 - 0.5 * code / 24 + np.cos(bend)], atol=1e-6)
    animation = stage.GetPrimAtPath("/_class_Walker/Bend" if instanced else "/Crowd/Walker/Bend")
    UsdSkel.Animation(animation).GetTranslationsAttr().Set([Gf.Vec3f(3, 0, -0.5), Gf.Vec3f(0, 0, 1)], 24)
    at(extractor, 24)
    np.testing.assert_allclose(end(), [3, -LENGTH / 2, LENGTH / 2 - 0.5], atol=1e-5)


def test_lights_follow_the_time():
    stage = make_stage()
    lamp = UsdLux.SphereLight.Define(stage, "/Lamp")
    lamp.CreateIntensityAttr().Set(0.0, 0)
    lamp.GetIntensityAttr().Set(100.0, 10)
    extractor = SceneExtractor(stage)
    at(extractor, 0)
    scene, touched = at(extractor, 5)
    np.testing.assert_allclose(scene.lights[0]["radiance"], 50.0)
    assert touched == {"lights"}


def test_domes_follow_the_time():
    stage = make_stage()
    sky = UsdLux.DomeLight.Define(stage, "/Sky")
    sky.CreateIntensityAttr().Set(300.0, 0)
    sky.GetIntensityAttr().Set(100.0, 10)
    extractor = SceneExtractor(stage)
    np.testing.assert_allclose(at(extractor, 0)[0].dome.radiance, 300.0)
    assert at(extractor, 5)[0].dome.radiance.max() == pytest.approx(200.0)


def test_materials_follow_the_time():
    stage = make_stage()
    material, still = add_material(stage, "/Looks/M"), add_material(stage, "/Looks/Still", (0, 0, 1))
    color = UsdShade.Shader(stage.GetPrimAtPath("/Looks/M/Surface")).GetInput("diffuseColor")
    color.Set(Gf.Vec3f(0, 0, 0), 0)
    color.Set(Gf.Vec3f(1, 1, 0), 10)
    for path, bound in (("/A", material), ("/B", still)):
        bind(stage.DefinePrim(path, "Cube"), bound)
    extractor = SceneExtractor(stage)
    at(extractor, 0)
    scene, touched = at(extractor, 5)
    assert [base_colors(scene, k)[0] for k in range(2)] == [[0.5, 0.5, 0], [0, 0, 1]]
    assert touched == {"materials"}


@pytest.mark.parametrize("instanceable", [False, True])
def test_layer_offsets_give_each_reference_its_own_time_of_materials(instanceable, tmp_path):
    asset = Usd.Stage.CreateNew(str(tmp_path / "glowing.usda"))
    asset.SetDefaultPrim(UsdGeom.Xform.Define(asset, "/Asset").GetPrim())
    bind(asset.DefinePrim("/Asset/Box", "Cube"), add_material(asset, "/Asset/Looks/M"))
    color = UsdShade.Shader(asset.GetPrimAtPath("/Asset/Looks/M/Surface")).GetInput("diffuseColor")
    for code, red in ((0, 0.0), (8, 1.0)):
        color.Set(Gf.Vec3f(red, 0, 0), code)
    asset.Save()
    stage = make_stage()
    offsets = [Sdf.LayerOffset(), Sdf.LayerOffset(4.0), Sdf.LayerOffset(0.0, 2.0), Sdf.LayerOffset()]
    for k, offset in enumerate(offsets):
        prim = stage.DefinePrim(f"/o{k}", "Xform")
        prim.GetReferences().AddReference(asset.GetRootLayer().identifier, offset)
        prim.SetInstanceable(instanceable)
    extractor = SceneExtractor(stage)
    for code in (4, 6):
        scene, _ = at(extractor, code)
        told = [
            list(stage.GetAttributeAtPath(f"/o{k}/Looks/M/Surface.inputs:diffuseColor").Get(code)) for k in range(4)
        ]
        assert [base_colors(scene, k)[0] for k in range(4)] == told
        assert len({tuple(each) for each in told}) == 3


def test_texture_files_follow_the_time(tmp_path):
    stage = make_stage()
    texture = UsdShade.Shader.Define(stage, "/Looks/M/Tex")
    bind(stage.DefinePrim("/A", "Cube"), add_material(stage, "/Looks/M"))
    texture.CreateIdAttr("UsdUVTexture")
    file = texture.CreateInput("file", Sdf.ValueTypeNames.Asset)
    for code in (0, 10):
        Image.new("RGB", (2, 2), (code, 0, 0)).save(tmp_path / f"{code}.png")
        file.Set(Sdf.AssetPath(str(tmp_path / f"{code}.png")), code)
    surface = UsdShade.Shader(stage.GetPrimAtPath("/Looks/M/Surface"))
    surface.GetInput("diffuseColor").ConnectToSource(texture.ConnectableAPI(), "rgb")
    extractor = SceneExtractor(stage)
    for code in (0, 10, 3):
        scene, _ = at(extractor, code)
        shown = scene.textures[scene.materials[scene.material_slots[0]]["base_color_texture"]]
        assert shown.texels[0, 0, 0] == (10 if code == 10 else 0)
