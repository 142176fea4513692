"""The box of a prim along its own axes: of what is drawn, whatever extents say."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

from tests.stage.geometry.characters import add_character
from usdsdg.scenarios.object_based.objects import _name_odd_size
from usdsdg.scenarios.shared.mesh_folder import read_assets
from usdsdg.stage.geometry.own_box import own_box
from usdsdg.stage.geometry.skinning import Skinning
from usdsdg.stage.poses import pivots

PURPOSES = ["default", "render"]


def mesh(stage, path, extent):
    """A triangle of 0.1 by 0.2 units with another extent."""
    made = UsdGeom.Mesh.Define(stage, path)
    made.CreatePointsAttr([(0, 0, 0), (0.1, 0, 0), (0, 0.2, 0)])
    made.CreateFaceVertexCountsAttr([3])
    made.CreateFaceVertexIndicesAttr([0, 1, 2])
    if extent is not None:
        made.CreateExtentAttr([Gf.Vec3f(extent[0]), Gf.Vec3f(extent[1])])
    return made


@pytest.fixture
def stage():
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    return stage


@pytest.mark.parametrize("extent", [None, (-100, 100), (5, 5), (1, -1)])
@pytest.mark.parametrize("path", ["/World", "/World/mesh"])
def test_extents_that_do_not_fit_do_not_count(stage, path, extent):
    UsdGeom.Xform.Define(stage, "/World")
    mesh(stage, "/World/mesh", extent)
    box = own_box(stage.GetPrimAtPath(path), PURPOSES)
    assert np.array([box.GetMin(), box.GetMax()]) == pytest.approx(np.array([[0, 0, 0], [0.1, 0.2, 0]]))


def test_pivots_lie_on_what_is_drawn(stage):
    prim = mesh(stage, "/mesh", (-100, 100)).GetPrim()
    pivots.set_pivot(prim, (1, 1, 0))
    assert prim.GetAttribute(pivots.PIVOT).Get() == pytest.approx((0.1, 0.2, 0.0))
    moved = pivots.translations_about_pivots([prim], [(1, 1, 0)], np.zeros((1, 3)), None, None)
    assert moved[0] == pytest.approx((-0.1, -0.2, 0.0))


@pytest.mark.parametrize("path", ["/World", "/World/mesh"])
def test_hidden_prims_have_a_box_and_what_is_hidden_in_them_is_not_in_it(stage, path):
    UsdGeom.Xform.Define(stage, "/World")
    mesh(stage, "/World/mesh", None)
    UsdGeom.Cube.Define(stage, "/World/hidden").MakeInvisible()
    UsdGeom.Imageable(stage.GetPrimAtPath(path)).GetVisibilityAttr().Set("invisible")
    box = own_box(stage.GetPrimAtPath(path), PURPOSES)
    assert tuple(box.GetMax()) == pytest.approx((0.1, 0.2, 0.0))


def test_what_is_hidden_at_the_time_is_not_in_the_box(stage):
    UsdGeom.Xform.Define(stage, "/World")
    mesh(stage, "/World/mesh", None)
    visibility = UsdGeom.Cube.Define(stage, "/World/blinking").CreateVisibilityAttr()
    visibility.Set("inherited", 0)
    visibility.Set("invisible", 10)
    for code, highest in ((0, 1.0), (10, 0.2)):
        box = own_box(stage.GetPrimAtPath("/World"), PURPOSES, Usd.TimeCode(code))
        assert box.GetMax()[1] == pytest.approx(highest)


def test_prims_without_geometry_have_an_empty_box(stage):
    UsdGeom.Xform.Define(stage, "/World/empty")
    assert own_box(stage.GetPrimAtPath("/World"), PURPOSES).IsEmpty()


def test_objects_are_not_called_odd_for_their_extents(stage, recwarn):
    _name_odd_size(mesh(stage, "/mesh", (-100, 100)).GetPrim(), "mug.usd")
    assert not recwarn.list
    large = mesh(stage, "/large", (0, 0.1))
    large.AddScaleOp().Set(Gf.Vec3f(1000))
    with pytest.warns(UserWarning, match=r"mug.usd is 200 m large on the stage"):
        _name_odd_size(large.GetPrim(), "mug.usd")


def test_meshes_of_a_folder_have_the_size_that_is_drawn(tmp_path):
    stage = Usd.Stage.CreateNew(str(tmp_path / "mug.usda"))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, "/Mug")
    root.AddTranslateOp().Set(Gf.Vec3d(1, 0, 0))
    stage.SetDefaultPrim(root.GetPrim())
    mesh(stage, "/Mug/mesh", (-100, 100))
    stage.Save()
    [found] = read_assets({"mug": [str(tmp_path / "mug.usda")]}, "m")
    assert (found.low, found.high) == (pytest.approx((1.0, 0.0, 0.0)), pytest.approx((1.1, 0.2, 0.0)))


def instancer(stage, *, extent=None, resets=False):
    """Two cubes of 1 unit, 4 units apart and turned by 45 degrees about z, below the prototype `/Two/Parent`."""
    made = UsdGeom.PointInstancer.Define(stage, "/Two")
    made.CreateProtoIndicesAttr([0, 0])
    made.CreatePositionsAttr([Gf.Vec3f(0), Gf.Vec3f(4, 0, 0)])
    made.CreateOrientationsAttr([Gf.Quath(0.92388, 0, 0, 0.382683)] * 2)
    made.CreatePrototypesRel().SetTargets([UsdGeom.Xform.Define(stage, "/Two/Parent").GetPath()])
    UsdGeom.Xform(stage.GetPrimAtPath("/Two/Parent")).AddTranslateOp().Set(Gf.Vec3d(0, 0, 7))
    cube = UsdGeom.Cube.Define(stage, "/Two/Parent/cube")
    cube.CreateSizeAttr(1.0)
    if resets:
        UsdGeom.Xformable(cube).SetResetXformStack(True)
    if extent is not None:
        for boundable in (made, cube):
            boundable.CreateExtentAttr([Gf.Vec3f(extent[0]), Gf.Vec3f(extent[1])])
    return made.GetPrim()


@pytest.mark.parametrize("extent", [None, (-100, 100), (5, 5)])
def test_extents_of_point_instancers_and_their_prototypes_do_not_count(stage, extent):
    box = own_box(instancer(stage, extent=extent), PURPOSES)
    half = np.sqrt(0.5)
    expected = np.array([[-half, -half, 6.5], [4 + half, half, 7.5]])
    assert np.array([box.GetMin(), box.GetMax()]) == pytest.approx(expected, abs=1e-3)


def test_prototypes_that_reset_the_transform_stack_are_where_they_are_drawn(stage):
    box = own_box(instancer(stage, resets=True), PURPOSES)
    assert (box.GetMin()[2], box.GetMax()[2]) == (-0.5, 0.5)


def test_what_prototypes_hide_and_masked_points_are_in_no_box(stage):
    prim = instancer(stage)
    UsdGeom.PointInstancer(prim).CreateInvisibleIdsAttr([0])
    assert own_box(prim, PURPOSES).GetMin()[0] > 3.0
    ball = UsdGeom.Sphere.Define(stage, "/Two/Parent/guide")
    ball.CreateRadiusAttr(50.0)
    ball.CreatePurposeAttr("guide")
    UsdGeom.Sphere.Define(stage, "/Two/Parent/hidden").MakeInvisible()
    assert own_box(prim, PURPOSES).GetMax()[0] < 5.0
    UsdGeom.Imageable(stage.GetPrimAtPath("/Two/Parent")).MakeInvisible()
    assert own_box(prim, PURPOSES).IsEmpty()


def test_points_that_are_not_finite_are_in_no_box(stage):
    prim = instancer(stage)
    expected = own_box(prim, PURPOSES)
    made = UsdGeom.PointInstancer(prim)
    made.GetProtoIndicesAttr().Set([0, 0, 0])
    made.GetPositionsAttr().Set([*made.GetPositionsAttr().Get(), Gf.Vec3f(np.nan)])
    made.GetOrientationsAttr().Set([*made.GetOrientationsAttr().Get(), Gf.Quath(1)])
    with np.errstate(all="raise"):
        assert own_box(prim, PURPOSES) == expected


def test_instancers_among_prototypes_have_their_boxes(stage):
    inner = instancer(stage)
    outer = UsdGeom.PointInstancer.Define(stage, "/Four")
    outer.CreateProtoIndicesAttr([0, 0])
    outer.CreatePositionsAttr([Gf.Vec3f(0), Gf.Vec3f(0, 10, 0)])
    outer.CreatePrototypesRel().SetTargets([inner.GetPath()])
    low, high = own_box(inner, PURPOSES).GetMin(), own_box(inner, PURPOSES).GetMax()
    box = own_box(outer.GetPrim(), PURPOSES)
    assert tuple(box.GetMin()) == pytest.approx(tuple(low))
    assert tuple(box.GetMax()) == pytest.approx((high[0], high[1] + 10, high[2]))


def test_characters_have_the_box_of_their_pose(stage):
    body = add_character(stage)
    root = stage.GetPrimAtPath("/Character")
    UsdGeom.Boundable(root).CreateExtentAttr([Gf.Vec3f(-100), Gf.Vec3f(100)])
    for code in (0, 24):
        points = Skinning().skin(body.GetPrim(), Usd.TimeCode(code)).points
        box = own_box(root, PURPOSES, Usd.TimeCode(code))
        expected = np.array([points.min(axis=0), points.max(axis=0)])
        assert np.array([box.GetMin(), box.GetMax()]) == pytest.approx(expected)
