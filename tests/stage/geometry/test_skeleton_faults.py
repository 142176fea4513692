"""Skeletons, animations and blend shapes that UsdSkel leaves out are named; the mesh is drawn as UsdSkel has it."""

import warnings

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdSkel

from tests.stage.geometry.characters import RINGS, SIDES, add_blend_shape, add_character
from usdsdg.stage.geometry.skinning import Skinning


def character(*, shapes=False):
    stage = Usd.Stage.CreateInMemory()
    mesh = add_character(stage)
    if shapes:
        add_blend_shape(stage, mesh)
    return stage, mesh


def skinned_at_end(mesh):
    """Points at code 24, and what was said."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        skinning = Skinning()
        found = skinning.skin(mesh.GetPrim(), Usd.TimeCode(24))
        skinning.skin(mesh.GetPrim(), Usd.TimeCode(23))
    points = np.array(mesh.GetPointsAttr().Get()) if found is None else found.points
    return points, [str(each.message) for each in caught]


def other_joints(stage):
    UsdSkel.Animation(stage.GetPrimAtPath("/Character/Bend")).GetJointsAttr().Set(["mixamorig:Hips", "mixamorig:Knee"])


def no_scales(stage):
    stage.GetPrimAtPath("/Character/Bend").RemoveProperty("scales")


def few_rotations(stage):
    UsdSkel.Animation(stage.GetPrimAtPath("/Character/Bend")).GetRotationsAttr().Set([Gf.Quatf(1)], 24)


def lost_animation(stage):
    skeleton = stage.GetPrimAtPath("/Character/Skeleton")
    UsdSkel.BindingAPI(skeleton).GetAnimationSourceRel().SetTargets(["/Gone"])


def animation_without_schema(stage):
    stage.GetPrimAtPath("/Character/Skeleton").RemoveAPI(UsdSkel.BindingAPI)


def no_bind_pose(stage):
    stage.GetPrimAtPath("/Character/Skeleton").RemoveProperty("bindTransforms")


def lost_skeleton(stage):
    UsdSkel.BindingAPI(stage.GetPrimAtPath("/Character/Body")).GetSkeletonRel().SetTargets(["/Gone"])


def no_schema(stage):
    stage.GetPrimAtPath("/Character/Body").RemoveAPI(UsdSkel.BindingAPI)


@pytest.mark.parametrize(
    ("harm", "said"),
    [
        (other_joints, "/Character/Bend: none of its joints, such as 'mixamorig:Hips', is one of /Character/Skeleton"),
        (no_scales, "/Character/Bend: it has 2 joints, but 2 translations, 2 rotations, 0 scales"),
        (few_rotations, "/Character/Bend: it has 2 joints, but 2 translations, 1 rotations, 2 scales"),
        (lost_animation, "/Character/Skeleton: its skel:animationSource /Gone is no active SkelAnimation"),
        (animation_without_schema, "Apply SkelBindingAPI to /Character/Skeleton"),
        (no_bind_pose, "/Character/Skeleton: it has 2 joints and 0 bindTransforms"),
        (lost_skeleton, "/Character/Body: it has joints and no skeleton"),
        (no_schema, "Apply SkelBindingAPI to /Character/Body"),
    ],
    ids=lambda each: each.__name__ if callable(each) else "",
)
def test_what_deforms_nothing_is_named_once(harm, said):
    stage, mesh = character()
    harm(stage)
    points, told = skinned_at_end(mesh)
    np.testing.assert_allclose(points, mesh.GetPointsAttr().Get(), atol=1e-6)
    assert len(told) == 1
    assert said in told[0]


def test_a_joint_that_a_mesh_lists_and_the_skeleton_lacks_is_named():
    stage, mesh = character()
    UsdSkel.BindingAPI(mesh).CreateJointsAttr(["hip", "hip/shin"])
    _, told = skinned_at_end(mesh)
    assert len(told) == 1
    assert told[0].startswith("/Character/Body: 'hip/shin' of its skel:joints is no joint of /Character/Skeleton")
    assert stage


def test_weights_that_do_not_sum_to_one_are_named():
    stage, mesh = character()
    weights = UsdSkel.BindingAPI(mesh).GetJointWeightsPrimvar()
    weights.Set((np.array(weights.Get()) * np.float32(1.01)).tolist())  # as of half floats
    assert skinned_at_end(mesh)[1] == []
    weights.Set((np.array(weights.Get()) * np.float32(0.5)).tolist())
    points, told = skinned_at_end(mesh)
    assert len(told) == 1
    count = RINGS * SIDES
    assert f"jointWeights of {count} of {count} points do not sum to 1, those of point 0 to 0.505" in told[0]
    assert np.abs(points).max() < 0.6 * np.abs(np.array(mesh.GetPointsAttr().Get())).max()
    assert stage


def other_names(mesh):
    animation = mesh.GetPrim().GetStage().GetPrimAtPath("/Character/Bend")
    UsdSkel.Animation(animation).GetBlendShapesAttr().Set(["a", "b"])


def lost_target(mesh):
    UsdSkel.BindingAPI(mesh).GetBlendShapeTargetsRel().SetTargets(["/Gone"])


def more_names(mesh):
    UsdSkel.BindingAPI(mesh).GetBlendShapesAttr().Set(["longer", "wider"])


def few_weights(mesh):
    animation = mesh.GetPrim().GetStage().GetPrimAtPath("/Character/Bend")
    UsdSkel.Animation(animation).GetBlendShapeWeightsAttr().Set([0.7], 24)


@pytest.mark.parametrize(
    ("harm", "said"),
    [
        (other_names, "/Character/Bend: none of its blendShapes, such as 'a', is one of what is bound"),
        (lost_target, "/Character/Body: its skel:blendShapeTargets /Gone is no BlendShape"),
        (more_names, "/Character/Body: it has 2 names in skel:blendShapes and 1 target in skel:blendShapeTargets"),
        (few_weights, "/Character/Bend: it has 2 names in blendShapes and 1 blendShapeWeights"),
    ],
)
def test_blend_shapes_that_do_not_count_are_named_once(harm, said):
    (stage, plain), (shaped, mesh) = character(), character(shapes=True)
    harm(mesh)
    points, told = skinned_at_end(mesh)
    np.testing.assert_allclose(points, skinned_at_end(plain)[0], atol=1e-6)
    assert len(told) == 1
    assert said in told[0]
    assert stage
    assert shaped


def test_animations_with_samples_alone_are_not_named_at_the_default_time():
    stage, mesh = character(shapes=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Skinning().skin(mesh.GetPrim(), Usd.TimeCode.Default())
    assert stage


@pytest.mark.parametrize("path", ["Skeleton.bindTransforms", "Bend.rotations", "Bend.blendShapeWeights"])
def test_numbers_in_place_of_arrays_are_named(path):
    stage, mesh = character(shapes=True)
    name, _, attribute = path.partition(".")
    prim = stage.GetPrimAtPath(f"/Character/{name}")
    prim.RemoveProperty(attribute)
    spec = Sdf.AttributeSpec(stage.GetRootLayer().GetPrimAtPath(prim.GetPath()), attribute, Sdf.ValueTypeNames.Float)
    spec.default = 1.0
    _, told = skinned_at_end(mesh)
    assert any(each.startswith(f"/Character/{name}: it has 2 ") for each in told)
