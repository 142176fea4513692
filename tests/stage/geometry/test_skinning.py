"""Skinned meshes against UsdSkel's own baking."""

import warnings

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel

from tests.stage.geometry.characters import LENGTH, RINGS, SIDES, add_blend_shape, add_character
from usdsdg.errors import UsdsdgWarning, forget_warnings
from usdsdg.stage.geometry.skinning import Skinning

CODES = (0.0, 6.0, 12.0, 19.5, 24.0)


def world_points(prim, points, time):
    to_world = np.array(UsdGeom.XformCache(time).GetLocalToWorldTransform(prim))
    return np.asarray(points, float) @ to_world[:3, :3] + to_world[3, :3]


def baked_world(stage, path, time):
    """Return the points in the world after UsdSkel.BakeSkinning of a copy of the stage."""
    copy = Usd.Stage.CreateInMemory()
    copy.GetRootLayer().TransferContent(stage.Flatten())
    assert UsdSkel.BakeSkinning(copy.Traverse(), Gf.Interval(0, 24))
    prim = copy.GetPrimAtPath(path)
    return world_points(prim, UsdGeom.Mesh(prim).GetPointsAttr().Get(time), time)


def assert_as_baked(stage, mesh, codes=CODES):
    skinning = Skinning()
    for code in codes:
        time = Usd.TimeCode(code)
        found = skinning.skin(mesh.GetPrim(), time)
        expected = baked_world(stage, mesh.GetPath(), time)
        np.testing.assert_allclose(world_points(mesh.GetPrim(), found.points, time), expected, atol=2e-5)


@pytest.mark.parametrize("method", ["classicLinear", "dualQuaternion"])
def test_points_are_those_of_bake_skinning(method):
    stage = Usd.Stage.CreateInMemory()
    mesh = add_character(stage, method=method)
    assert_as_baked(stage, mesh, (0.0, 12.0, 24.0))  # baking samples where the animation has samples


def test_the_methods_differ_where_a_joint_bends():
    shapes = []
    for method in ("classicLinear", "dualQuaternion"):
        stage = Usd.Stage.CreateInMemory()
        mesh = add_character(stage, method=method)
        shapes.append(Skinning().skin(mesh.GetPrim(), Usd.TimeCode(24)).points)
    assert np.abs(shapes[0] - shapes[1]).max() > 0.01


def test_the_end_of_a_bent_tube_is_where_trigonometry_says():
    stage = Usd.Stage.CreateInMemory()
    mesh = add_character(stage)
    end = Skinning().skin(mesh.GetPrim(), Usd.TimeCode(24)).points[-SIDES:].mean(axis=0)
    # Half of the tube is upright, half is along -y after a quarter turn around x; the hip has moved down by 0.5.
    np.testing.assert_allclose(end, [0, -LENGTH / 2, LENGTH / 2 - 0.5], atol=1e-6)


def test_transforms_of_mesh_skeleton_and_root_and_the_bind_pose_are_applied():
    stage = Usd.Stage.CreateInMemory()
    mesh = add_character(stage)
    UsdGeom.Xformable(stage.GetPrimAtPath("/Character")).AddTranslateOp().Set(Gf.Vec3d(5, 0, 1))
    skeleton = UsdGeom.Xformable(stage.GetPrimAtPath("/Character/Skeleton"))
    skeleton.AddRotateXYZOp().Set(Gf.Vec3f(20, 30, 40))
    mesh.AddTranslateOp().Set(Gf.Vec3d(0, 3, 0))
    mesh.AddScaleOp().Set(Gf.Vec3f(2, 1, 0.5))
    UsdSkel.BindingAPI(mesh.GetPrim()).GetGeomBindTransformAttr().Set(
        Gf.Matrix4d(1).SetTranslate(Gf.Vec3d(0.1, 0.2, 0))
    )
    assert_as_baked(stage, mesh, (0.0, 12.0, 24.0))


def test_a_mesh_may_order_the_joints_its_own_way():
    stage = Usd.Stage.CreateInMemory()
    plain = add_character(stage, "/Plain")
    reordered = add_character(stage, "/Turned", joints=("hip/knee", "hip"))
    skinning = Skinning()
    a, b = (skinning.skin(mesh.GetPrim(), Usd.TimeCode(20)).points for mesh in (plain, reordered))
    np.testing.assert_allclose(a, b, atol=1e-6)


def test_one_influence_for_the_whole_mesh_moves_it_rigidly():
    stage = Usd.Stage.CreateInMemory()
    mesh = add_character(stage)
    binding = UsdSkel.BindingAPI(mesh.GetPrim())
    binding.CreateJointIndicesPrimvar(True, 1).Set([1])
    binding.CreateJointWeightsPrimvar(True, 1).Set([1.0])
    found = Skinning().skin(mesh.GetPrim(), Usd.TimeCode(24)).points
    rest = np.asarray(mesh.GetPointsAttr().Get())
    np.testing.assert_allclose(
        np.linalg.norm(found[1:] - found[:-1], axis=1), np.linalg.norm(rest[1:] - rest[:-1], axis=1), atol=1e-5
    )
    assert_as_baked(stage, mesh, (0.0, 24.0))


@pytest.mark.parametrize("between", [False, True])
def test_blend_shapes_are_applied_before_the_joints(between):
    stage = Usd.Stage.CreateInMemory()
    mesh = add_character(stage)
    add_blend_shape(stage, mesh, between=between)
    assert_as_baked(stage, mesh, (0.0, 12.0, 24.0))
    end = Skinning().skin(mesh.GetPrim(), Usd.TimeCode(12)).points[-SIDES:].mean(axis=0)
    # At 45 degrees, longer by 0.2 with the in-between and by 0.5 without.
    length = LENGTH / 2 + (0.2 if between else 0.5)
    np.testing.assert_allclose(end, [0, -length * np.sqrt(0.5), LENGTH / 2 - 0.25 + length * np.sqrt(0.5)], atol=1e-6)


def test_blend_shapes_without_names_are_left_out_as_by_usdskel():
    stage = Usd.Stage.CreateInMemory()
    mesh = add_character(stage)
    add_blend_shape(stage, mesh, between=False)
    UsdSkel.BindingAPI(mesh.GetPrim()).GetBlendShapesAttr().Set([])
    with pytest.warns(UserWarning, match="/Character/Body: its skel:blendShapes is empty"):
        found = Skinning().skin(mesh.GetPrim(), Usd.TimeCode(4))
    UsdSkel.BakeSkinning(UsdSkel.Root(stage.GetPrimAtPath("/Character")))
    assert np.allclose(found.points, mesh.GetPointsAttr().Get(4), atol=1e-5)


def test_invalid_blend_shapes_are_left_out_completely():
    stage = Usd.Stage.CreateInMemory()
    mesh = add_character(stage)
    time = Usd.TimeCode(12)
    without = Skinning().skin(mesh.GetPrim(), time).points
    add_blend_shape(stage, mesh, between=False)
    shape = UsdSkel.BlendShape(stage.GetPrimAtPath(mesh.GetPath().AppendChild("Longer")))
    shape.GetPointIndicesAttr().Set([*shape.GetPointIndicesAttr().Get()[:-1], 9999])
    with pytest.warns(UserWarning, match="/Character/Body: its blend shapes do not fit its points and are left out"):
        np.testing.assert_array_equal(Skinning().skin(mesh.GetPrim(), time).points, without)


@pytest.mark.parametrize("interpolation", ["vertex", "faceVarying"])
@pytest.mark.parametrize("method", ["classicLinear", "dualQuaternion"])
def test_normals_are_skinned_with_the_surface(interpolation, method):
    stage = Usd.Stage.CreateInMemory()
    mesh = add_character(stage, method=method)
    mesh.AddScaleOp().Set(Gf.Vec3f(1, 2, 1))
    rest = np.asarray(mesh.GetPointsAttr().Get())
    outward = rest * [1, 1, 0] / 0.3
    vertices = np.arange(len(rest))
    if interpolation == "faceVarying":
        vertices = np.asarray(mesh.GetFaceVertexIndicesAttr().Get())
    time = Usd.TimeCode(24)
    found = Skinning().skin(mesh.GetPrim(), time, normals=outward[vertices], vertices=vertices)
    normals = found.normals / np.linalg.norm(found.normals, axis=1, keepdims=True)
    # The last two rings belong to the knee alone, so that the end is a cylinder along -y; the mesh's frame is half as
    # long along y as the world, where the skeleton stands.
    last = vertices >= (RINGS - 2) * SIDES
    local = (found.points[vertices] * [1, 2, 1] - [0, 0, LENGTH / 2 - 0.5]) * [1, 0, 1] / 0.3
    expected = local * [1, 2, 1]
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(normals[last], expected[last], atol=1e-4)


def test_meshes_outside_or_unbound_are_not_skinned():
    stage = Usd.Stage.CreateInMemory()
    add_character(stage)
    skinning = Skinning()
    for path in ("/Character/Free", "/Outside"):
        mesh = UsdGeom.Mesh.Define(stage, path)
        mesh.CreatePointsAttr([Gf.Vec3f(0)] * 3)
        assert not skinning.is_skinned(mesh.GetPrim())
        assert skinning.skin(mesh.GetPrim(), Usd.TimeCode(0)) is None


def test_new_bindings_are_read_after_invalidation():
    stage = Usd.Stage.CreateInMemory()
    mesh = add_character(stage)
    skinning = Skinning()
    bent = skinning.skin(mesh.GetPrim(), Usd.TimeCode(24)).points
    UsdSkel.BindingAPI(stage.GetPrimAtPath("/Character/Skeleton")).GetAnimationSourceRel().ClearTargets(True)
    skinning.invalidate()
    rest = skinning.skin(mesh.GetPrim(), Usd.TimeCode(24)).points
    np.testing.assert_allclose(rest, np.asarray(mesh.GetPointsAttr().Get()), atol=1e-6)
    assert np.abs(bent - rest).max() > 0.5


def test_invalid_influences_are_named():
    stage = Usd.Stage.CreateInMemory()
    mesh = add_character(stage)
    UsdSkel.BindingAPI(mesh.GetPrim()).CreateJointWeightsPrimvar(False, 2).Set([1.0, 0.0])
    with pytest.warns(UserWarning, match="/Character/Body.*joints cannot be read"):
        assert Skinning().skin(mesh.GetPrim(), Usd.TimeCode(0)) is None


@pytest.mark.parametrize(
    ("indices", "weights", "said"),
    [
        ((0, 7), (0.5, 0.5), "jointIndices has 7, and there are 2 joints"),
        ((-1, 1), (0.5, 0.5), "jointIndices has -1"),
        ((0, 1), (-2.0, 3.0), "jointWeights has -2"),
        ((0, 1), (float("nan"), 1.0), "jointWeights has nan"),
        ((0, 1), (0.0, 0.0), "only 0 for 1 of 72 points, the first of them point 3"),
    ],
)
def test_influences_that_no_point_can_have_are_named_once(indices, weights, said):
    """Of a mesh that orders the joints its own way, and of one that does not."""
    for joints in (None, ("hip/knee", "hip")):
        stage = Usd.Stage.CreateInMemory()
        mesh = add_character(stage, joints=joints)
        binding = UsdSkel.BindingAPI(mesh.GetPrim())
        for primvar, values in (
            (binding.GetJointIndicesPrimvar(), indices),
            (binding.GetJointWeightsPrimvar(), weights),
        ):
            found = list(primvar.Get())
            found[6:8] = values
            primvar.Set(found)
        forget_warnings()
        skinning = Skinning()
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            for code in (0, 12):
                skinning.skin(mesh.GetPrim(), Usd.TimeCode(code))
        told = [str(each.message) for each in caught if "joint" in str(each.message)]
        assert len([each for each in told if said in each and each.startswith("/Character/Body: ")]) == 1, told


def test_influences_as_they_should_be_are_not_warned_of(recwarn):
    stage = Usd.Stage.CreateInMemory()
    mesh = add_character(stage, joints=("hip/knee", "hip"))
    Skinning().skin(mesh.GetPrim(), Usd.TimeCode(12))
    assert not [each for each in recwarn if "joint" in str(each.message)]


def test_a_missing_skel_root_is_named():
    stage = Usd.Stage.CreateInMemory()
    mesh = add_character(stage)
    stage.GetPrimAtPath("/Character").SetTypeName("Xform")
    with pytest.warns(UserWarning, match="/Character/Body.*SkelRoot"):
        assert Skinning().skin(mesh.GetPrim(), Usd.TimeCode(0)) is None


def test_shapes_with_joints_are_named():
    stage = Usd.Stage.CreateInMemory()
    mesh = add_character(stage)
    shape = UsdGeom.Cube.Define(stage, f"{UsdSkel.Root.Find(mesh.GetPrim()).GetPath()}/Hat").GetPrim()
    api = UsdSkel.BindingAPI.Apply(shape)
    api.CreateJointIndicesPrimvar(True, 1).Set([0])
    api.CreateJointWeightsPrimvar(True, 1).Set([1.0])
    api.CreateSkeletonRel().SetTargets(UsdSkel.BindingAPI(mesh).GetSkeletonRel().GetTargets())
    with pytest.warns(UsdsdgWarning, match=f"{shape.GetPath()}: joints of .* do not move a Cube"):
        assert not Skinning().is_skinned(shape)


def test_ops_that_usd_rejects_above_a_character_are_named():
    stage = Usd.Stage.CreateInMemory()
    mesh = add_character(stage).GetPrim()
    root = UsdSkel.Root.Find(mesh).GetPrim()
    root.CreateAttribute("xformOpOrder", Sdf.ValueTypeNames.TokenArray, False).Set(["constant"])
    with pytest.warns(UsdsdgWarning, match=f"{mesh.GetPath()}: its place in .* cannot be read: Invalid xform op"):
        assert Skinning().skin(mesh, Usd.TimeCode(0.0)) is not None
