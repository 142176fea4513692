"""Characters that point instancers draw: a skeleton for each instance, at its place, and skinned as any other."""

import ast

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom

import usdsdg as rep
from tests.stage.geometry.characters import LENGTH, add_character
from usdsdg.session.timeline import get_timeline

RATE = 24
SPECIFIERS = {"a prim": Sdf.SpecifierDef, "a class": Sdf.SpecifierClass, "an over": Sdf.SpecifierOver}


def crowd(stage, prototype, positions):
    """A point instancer of a character, which stands on the axis x and is seen along y."""
    UsdGeom.SetStageUpAxis(stage, "Z")
    stage.SetTimeCodesPerSecond(RATE)
    add_character(stage, prototype)
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Crowd")
    instancer.CreatePrototypesRel().SetTargets([prototype])
    instancer.CreateProtoIndicesAttr([0] * len(positions))
    instancer.CreatePositionsAttr([Gf.Vec3f(*position) for position in positions])
    camera = UsdGeom.Camera.Define(stage, "/Camera")
    camera.AddTranslateOp().Set(Gf.Vec3d(0, -12, 1))
    camera.AddRotateXYZOp().Set(Gf.Vec3f(90, 0, 0))
    camera.CreateFocalLengthAttr(20.0)
    product = rep.create.render_product("/Camera", (80, 60))
    names = ["skeleton_data", "pointcloud", "instance_id_segmentation_fast"]
    options = {"pointcloud": {"includeUnlabelled": True}}
    return instancer, [rep.annotators.get(name, init_params=options.get(name)).attach(product) for name in names]


def captured(annotators, code):
    get_timeline().set_current_time(code / RATE)
    rep.orchestrator.step(delta_time=0.0)
    return [annotator.get_data() for annotator in annotators]


def joints_at(code, *places):
    """Hip and knee of each character, after `add_character`."""
    sunk = 0.5 * code / RATE
    return [np.add(place, (0, 0, z - sunk)) for place in places for z in (0, LENGTH / 2)]


@pytest.mark.parametrize("kind", SPECIFIERS)
def test_each_instance_has_a_skeleton_where_it_is_drawn(kind, stage):
    places = [(-3, 0, 0), (0, 0, 0.5), (3, 0, 0)]
    instancer, annotators = crowd(stage, "/World/Crowd/Man" if kind == "a prim" else "/Library/Man", places)
    stage.GetPrimAtPath("/World/Crowd" if kind == "a prim" else "/Library").SetSpecifier(SPECIFIERS[kind])
    instancer.CreateInvisibleIdsAttr([1])
    path = f"{instancer.GetPrototypesRel().GetTargets()[0]}/Skeleton"
    for code in (0, 12):
        skeletons, cloud, _ = captured(annotators, code)
        assert skeletons["skelPath"] == [f"{path}[0]", f"{path}[2]"]
        expected = joints_at(code, places[0], places[2])
        np.testing.assert_allclose(skeletons["globalTranslations"], expected, atol=1e-5)
        assert skeletons["inView"].all()
        assert not skeletons["jointOcclusions"].any(), "what is drawn there is the character itself"
        # The end of the tube is at its knee's angle: its rim of radius 0.3 is the highest that is drawn.
        bend = np.radians(90 * code / 24)
        highest = LENGTH / 2 * (1 + np.cos(bend)) + 0.3 * np.sin(bend) - 0.5 * code / RATE
        assert highest - 0.25 < cloud["data"][:, 2].max() <= highest + 1e-4
        assert cloud["data"][:, 1].min() >= -LENGTH / 2 * np.sin(bend) - 0.3 * np.cos(bend) - 1e-4


def test_a_prototype_that_stands_in_the_scene_has_a_skeleton_of_its_own_which_hides_others(stage):
    _, annotators = crowd(stage, "/World/Man", [(0, 3, 0)])
    skeletons, _, masks = captured(annotators, 0)
    assert skeletons["skelPath"] == ["/World/Man/Skeleton", "/World/Man/Skeleton[0]"]
    np.testing.assert_allclose(skeletons["globalTranslations"], joints_at(0, (0, 0, 0), (0, 3, 0)), atol=1e-5)
    assert "/World/Man/Body" in masks["info"]["idToLabels"].values()
    assert skeletons["jointOcclusions"].tolist() == [False, False, True, True]
    assert ast.literal_eval(skeletons["occlusionTypes"][1]) == ["UNLABELLED"] * 2


def test_hidden_instancers_have_no_skeletons(stage):
    instancer, annotators = crowd(stage, "/World/Crowd/Man", [(0, 0, 0)])
    assert captured(annotators, 0)[0]["numSkeletons"] == 1
    instancer.MakeInvisible()
    assert captured(annotators, 0)[0]["numSkeletons"] == 0
