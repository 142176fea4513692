"""Skinned meshes after edits that move them and their skeleton apart, or that take the skeleton away for a while."""

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel

from tests.render.sync.test_extract_changes import assert_fresh
from tests.stage.geometry.characters import add_character
from usdsdg_render.sync.extract import SceneExtractor


@pytest.fixture
def stage():
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Xform.Define(stage, "/Group").AddTranslateOp()
    add_character(stage, "/Group/Man")
    UsdGeom.Xformable(stage.GetPrimAtPath("/Group/Man")).AddTranslateOp()
    return stage


def move(stage, path):
    stage.GetAttributeAtPath(f"{path}.xformOp:translate").Set(Gf.Vec3d(0, 0, 1))


def bind(stage, *skeletons):
    UsdSkel.BindingAPI(stage.GetPrimAtPath("/Group/Man/Body")).GetSkeletonRel().SetTargets(skeletons)


@pytest.mark.parametrize("path", ["/Group", "/Group/Man"])
@pytest.mark.parametrize("of", ["Body", "Skeleton"])
def test_a_character_moves_away_from_what_resets_its_transforms(stage, path, of):
    UsdGeom.Xformable(stage.GetPrimAtPath(f"/Group/Man/{of}")).SetResetXformStack(True)
    extractor = SceneExtractor(stage)
    extractor.update()
    move(stage, path)
    extractor.update()
    assert_fresh(extractor, stage)


@pytest.mark.parametrize("path", ["/Group/Man", "/Elsewhere"])
def test_a_skeleton_outside_of_its_character(stage, path):
    UsdGeom.Xform.Define(stage, "/Elsewhere").AddTranslateOp()
    layer = stage.GetRootLayer()
    Sdf.CopySpec(layer, "/Group/Man/Skeleton", layer, "/Elsewhere/Skeleton")
    bind(stage, "/Elsewhere/Skeleton")
    extractor = SceneExtractor(stage)
    extractor.update()
    move(stage, path)
    extractor.update()
    assert_fresh(extractor, stage)


def test_the_only_skinned_mesh_loses_its_skeleton_and_gets_it_back(stage):
    animation = UsdSkel.Animation(stage.GetPrimAtPath("/Group/Man/Bend"))
    animation.GetTranslationsAttr().Set([Gf.Vec3f(1), Gf.Vec3f(2)])
    animation.GetRotationsAttr().Set([Gf.Quatf(1)] * 2)
    extractor = SceneExtractor(stage)
    extractor.update()
    for skeletons in ([], ["/Group/Man/Skeleton"]):
        bind(stage, *skeletons)
        extractor.update()
        assert_fresh(extractor, stage)


def test_a_character_that_moves_as_a_whole_is_not_skinned_again(stage, monkeypatch):
    extractor = SceneExtractor(stage)
    extractor.update()
    monkeypatch.setattr(UsdSkel.SkinningQuery, "ComputeSkinnedPoints", lambda *_: pytest.fail("skinned again"))
    move(stage, "/Group/Man")
    extractor.update()
    move(stage, "/Group")
    extractor.update()
