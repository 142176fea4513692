import ast
import json
from dataclasses import replace

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdSkel

from tests.annotators.ray_caster import add_cube, make_frame, new_stage, place
from usdsdg import annotators
from usdsdg.annotators.labeled_prims import LabeledPrimReader
from usdsdg.errors import UsdsdgWarning, forget_warnings
from usdsdg.session.stage_context import set_stage

JOINTS = ["Hip", "Hip/Knee", "Hip/Knee/Foot"]


def add_character(stage, path="/World/Man", *, label="person"):
    """Hip, knee and foot along +X, each 1 apart; at second 1 the knee is turned by 90 degrees about Z."""
    root = UsdSkel.Root.Define(stage, path)
    skeleton = UsdSkel.Skeleton.Define(stage, f"{path}/Skeleton")
    rest = [Gf.Matrix4d().SetTranslate(Gf.Vec3d(*t)) for t in ((0, 0, 0), (1, 0, 0), (1, 0, 0))]
    skeleton.CreateJointsAttr(JOINTS)
    skeleton.CreateRestTransformsAttr(rest)
    skeleton.CreateBindTransformsAttr(rest)
    animation = UsdSkel.Animation.Define(stage, f"{path}/Walk")
    animation.CreateJointsAttr(["Hip/Knee", "Hip"])  # in another order, without the foot
    animation.CreateTranslationsAttr([Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 0, 0)])
    animation.CreateScalesAttr([Gf.Vec3h(1, 1, 1)] * 2)
    turned = Gf.Quatf(Gf.Rotation(Gf.Vec3d(0, 0, 1), 90).GetQuat())
    animation.CreateRotationsAttr().Set([Gf.Quatf(1, 0, 0, 0)] * 2, 0)
    animation.GetRotationsAttr().Set([turned, Gf.Quatf(1, 0, 0, 0)], stage.GetTimeCodesPerSecond())
    UsdSkel.BindingAPI.Apply(root.GetPrim()).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    add_cube(stage, f"{path}/Body", label, scale=(0.6, 0.6, 0.1))
    return root.GetPrim()


@pytest.fixture
def stage():
    stage = set_stage(new_stage())
    place(add_character(stage), translate=(-1, 0.5, 0))
    return stage


def compute(stage, index=0, **params):
    return annotators.get("skeleton_data", init_params=params).compute(make_frame(stage, (80, 60), index=index)).info


def test_joints_at_rest_in_the_world_and_in_the_picture(stage):
    data = compute(stage)
    assert data["numSkeletons"] == 1
    assert data["skelName"] == ["Skeleton"]
    assert data["skelPath"] == ["/World/Man/Skeleton"]
    np.testing.assert_array_equal(data["skeletonParents"], [-1, 0, 1])
    np.testing.assert_array_equal(data["skeletonParentsSizes"], [3])
    assert ast.literal_eval(data["skeletonJoints"][0]) == JOINTS
    world = [[-1, 0.5, 0], [0, 0.5, 0], [1, 0.5, 0]]
    np.testing.assert_allclose(data["restGlobalTranslations"], world, atol=1e-6)
    np.testing.assert_allclose(data["globalTranslations"], world, atol=1e-6)
    np.testing.assert_allclose(data["restLocalTranslations"], [[0, 0, 0], [1, 0, 0], [1, 0, 0]], atol=1e-6)
    np.testing.assert_allclose(data["localRotations"], [[1, 0, 0, 0]] * 3, atol=1e-6)
    camera = make_frame(stage, (80, 60)).camera
    np.testing.assert_allclose(data["translations2d"], camera.project(np.array(world))[0], atol=1e-4)
    assert data["inView"].tolist() == [True]
    for name, shape in (("globalTranslations", (3, 3)), ("localRotations", (3, 4)), ("translations2d", (3, 2))):
        assert (data[name].shape, data[name].dtype) == (shape, np.float32)


def test_joints_move_with_the_animation_at_the_time_of_the_frame(stage):
    data = compute(stage, index=60)  # one second
    np.testing.assert_allclose(data["globalTranslations"], [[-1, 0.5, 0], [0, 0.5, 0], [0, 1.5, 0]], atol=1e-6)
    half = np.sqrt(0.5)
    np.testing.assert_allclose(data["localRotations"], [[1, 0, 0, 0], [half, 0, 0, half], [1, 0, 0, 0]], atol=1e-6)
    np.testing.assert_allclose(data["restGlobalTranslations"][2], [1, 0.5, 0], atol=1e-6)
    np.testing.assert_allclose(
        compute(stage, index=30)["localRotations"][1], [np.cos(np.pi / 8), 0, 0, np.sin(np.pi / 8)]
    )


def test_what_hides_a_joint_is_told_by_its_label(stage):
    add_cube(stage, "/World/Box", "crate", translate=(0, 0.5, 2), scale=(0.3, 0.3, 0.3))
    data = compute(stage)
    # The body covers the hip, the box the knee, nothing the foot.
    assert ast.literal_eval(data["occlusionTypes"][0]) == ["None", "crate", "BACKGROUND"]
    assert data["jointOcclusions"].tolist() == [False, True, True]
    stage.GetPrimAtPath("/World/Box").RemoveProperty("semantics:labels:class")
    add_cube(stage, "/World/Bare", translate=(1, 0.5, 0), scale=(0.3, 0.3, 0.3))
    assert ast.literal_eval(compute(stage)["occlusionTypes"][0])[2] == "UNLABELLED"


def test_joints_outside_the_picture_and_behind_the_camera(stage):
    place(stage.GetPrimAtPath("/World/Man"), translate=(3.5, 0, 0))
    data = compute(stage)
    assert data["inView"].tolist() == [False]
    assert ast.literal_eval(data["occlusionTypes"][0])[1:] == ["OUT_OF_VIEW"] * 2
    place(stage.GetPrimAtPath("/World/Man"), translate=(0, 0, 20))
    data = compute(stage)
    assert np.isnan(data["translations2d"]).all()
    assert json.loads(data["skeletonData"])[0]["translations_2d"] == [[None, None]] * 3
    assert not data["inView"].any()


def test_several_skeletons_in_stage_order_without_hidden_ones(stage):
    place(add_character(stage, "/World/Ann"), translate=(0, -1, 0))
    hidden = add_character(stage, "/World/Zoe")
    UsdGeom.Imageable(hidden).MakeInvisible()
    data = compute(stage)
    assert data["skelPath"] == ["/World/Man/Skeleton", "/World/Ann/Skeleton"]
    np.testing.assert_array_equal(data["globalTranslationsSizes"], [3, 3])
    np.testing.assert_allclose(data["globalTranslations"][3], [0, -1, 0], atol=1e-6)
    told = json.loads(data["skeletonData"])
    assert [each["skel_name"] for each in told] == ["Skeleton", "Skeleton"]
    np.testing.assert_allclose(told[1]["global_translations"], data["globalTranslations"][3:], atol=1e-6)


def test_asset_and_animation_variant_are_found(tmp_path, stage):
    asset = Usd.Stage.CreateNew(str(tmp_path / "man.usda"))
    asset.SetDefaultPrim(add_character(asset, "/Man"))
    variants = asset.GetDefaultPrim().GetVariantSets().AddVariantSet("animationVariant")
    variants.AddVariant("walk")
    variants.SetVariantSelection("walk")
    asset.Save()
    prim = stage.DefinePrim("/World/Ref")
    prim.GetReferences().AddReference(str(tmp_path / "man.usda"))
    data = compute(stage)
    assert data["assetPath"] == ["None", str(tmp_path / "man.usda")]
    assert data["animationVariant"] == ["None", "walk"]


def test_a_stage_without_skeletons_gives_empty_arrays():
    data = compute(set_stage(new_stage()))
    assert data["numSkeletons"] == 0
    assert data["globalTranslations"].shape == (0, 3)
    assert data["skelName"] == []


def test_an_option_without_meaning_is_told(stage):
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match="useSkelJoints is ignored"):
        compute(stage, useSkelJoints=True)


def test_skeletons_that_come_and_go_between_frames(stage):
    reader = LabeledPrimReader(stage)

    def names() -> list[str]:
        frame = make_frame(stage, (80, 60))
        frame = replace(frame, labeled_prims=reader.read(frame.gprims))
        return annotators.get("skeleton_data").compute(frame).info["skelPath"]

    assert names() == ["/World/Man/Skeleton"]
    place(add_character(stage, "/World/Woman"), translate=(1, 0.5, 0))
    assert names() == ["/World/Man/Skeleton", "/World/Woman/Skeleton"]
    stage.GetPrimAtPath("/World/Man").SetActive(False)
    assert names() == ["/World/Woman/Skeleton"]
    stage.GetPrimAtPath("/World/Man").SetActive(True)
    stage.RemovePrim("/World/Woman")
    assert names() == ["/World/Man/Skeleton"]
