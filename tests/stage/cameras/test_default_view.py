"""Default cameras and lights: everything is in the image, and the stage's own layers stay unchanged."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux

from tests.stage.geometry.characters import LENGTH, add_character
from usdsdg.errors import StageError
from usdsdg.stage.cameras import default_view
from usdsdg.stage.cameras.camera_view import read_camera


def stage_of(size=1.0, at=(0, 0, 0), up="Z"):
    """Two cubes of edge `size`, one half a size above the other."""
    stage = Usd.Stage.CreateInMemory()
    stage.SetMetadata("upAxis", up)
    for name, shift in (("Low", (0, 0, 0)), ("High", (1.5, 0, 1.5))):
        cube = UsdGeom.Cube.Define(stage, f"/World/{name}")
        cube.CreateSizeAttr(size)
        cube.AddTranslateOp().Set(Gf.Vec3d(*(a + size * s for a, s in zip(at, shift))))
    return stage


def corners(low, high):
    return np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * (high - low) + low


@settings(deadline=None, max_examples=40)
@given(
    exponent=st.floats(-6, 6),
    at=st.tuples(*[st.floats(-3, 3)] * 3),
    up=st.sampled_from(["Y", "Z", "X"]),
    aspect=st.sampled_from([(64, 48), (10, 200), (300, 20)]),
)
def test_everything_is_in_the_image_and_fills_it(exponent, at, up, aspect):
    size = 10.0**exponent
    stage = stage_of(size, tuple(size * part for part in at), up)
    low, high = default_view.world_bounds(stage)
    np.testing.assert_allclose(high - low, np.array([2.5, 1, 2.5]) * size, rtol=1e-5)
    width, height = aspect
    view = read_camera(stage, default_view.add_camera(stage, width / height), aspect)
    pixels, depth = view.project(corners(low, high))
    fraction = np.abs(pixels / (width, height) - 0.5) * 2
    assert fraction.max() == pytest.approx(default_view._FILL, rel=1e-3)
    near, far = view.clipping_range
    assert (near < depth).all()
    assert (depth < far).all()


@pytest.mark.parametrize("instanced", [False, True])
def test_extents_that_do_not_fit_are_not_believed(instanced):
    stage = Usd.Stage.CreateInMemory()
    cube = UsdGeom.Cube.Define(stage, "/Part/Cube")
    cube.CreateSizeAttr(2)
    mesh = UsdGeom.Mesh.Define(stage, "/Part/Mesh")
    mesh.CreatePointsAttr([(0, 0, 0), (3, 0, 0), (0, 0, 2)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    for gprim, extent in ((cube, [(-100,) * 3, (100,) * 3]), (mesh, [(0,) * 3, (0.1,) * 3])):
        gprim.CreateExtentAttr([Gf.Vec3f(*corner) for corner in extent])
    if instanced:
        stage.GetPrimAtPath("/Part").SetSpecifier(Sdf.SpecifierClass)
        for x in (0, 10):
            prim = UsdGeom.Xform.Define(stage, f"/At{x}")
            prim.GetPrim().GetReferences().AddInternalReference("/Part")
            prim.GetPrim().SetInstanceable(True)
            prim.AddTranslateOp().Set(Gf.Vec3d(x, 0, 0))
    low, high = default_view.world_bounds(stage)
    np.testing.assert_allclose([low, high], [(-1, -1, -1), (13 if instanced else 3, 1, 2)])


@pytest.mark.parametrize(("up", "axis"), [("Y", 1), ("Z", 2)])
def test_it_looks_down_from_the_front_with_the_up_axis_upwards_in_the_image(up, axis):
    stage = stage_of(up=up)
    view = read_camera(stage, default_view.add_camera(stage, 4 / 3), (64, 48))
    eye, center = view.local_to_world[3, :3], np.mean(default_view.world_bounds(stage), axis=0)
    assert eye[axis] > center[axis]
    assert eye[2] > center[2] if up == "Y" else eye[1] < center[1]
    ends = np.array([center, center + np.eye(3)[axis]])
    (below, above), _ = view.project(ends)
    assert above[1] < below[1]
    assert above[0] == pytest.approx(below[0])


def test_nothing_is_written_to_the_stages_own_layers():
    stage = stage_of()
    before = stage.GetRootLayer().ExportToString()
    default_view.add_camera(stage, 1.0)
    default_view.add_sky(stage)
    assert stage.GetRootLayer().ExportToString() == before
    assert default_view.cameras(stage) == [default_view.CAMERA]
    assert default_view.has_light(stage)


def test_lights_and_cameras_are_found_wherever_they_are():
    stage = stage_of()
    assert default_view.cameras(stage) == []
    assert not default_view.has_light(stage)
    UsdGeom.Camera.Define(stage, "/World/Rig/Camera")
    assert default_view.cameras(stage) == ["/World/Rig/Camera"]
    UsdLux.LightAPI.Apply(stage.GetPrimAtPath("/World/Low"))
    assert default_view.has_light(stage)


def test_hidden_and_not_finite_geometry_is_not_framed():
    stage = stage_of()
    low, high = default_view.world_bounds(stage)
    far = UsdGeom.Sphere.Define(stage, "/World/Hidden")
    far.AddTranslateOp().Set(Gf.Vec3d(100, 0, 0))
    far.MakeInvisible()
    UsdGeom.Sphere.Define(stage, "/World/Lost").AddTranslateOp().Set(Gf.Vec3d(float("nan"), 0, 0))
    guide = UsdGeom.Sphere.Define(stage, "/World/Guide")
    guide.AddTranslateOp().Set(Gf.Vec3d(0, 100, 0))
    guide.CreatePurposeAttr("guide")
    np.testing.assert_array_equal(default_view.world_bounds(stage), (low, high))


def test_geometry_that_has_time_samples_only_is_framed_at_the_first():
    stage = Usd.Stage.CreateInMemory()
    mesh = UsdGeom.Mesh.Define(stage, "/Mesh")
    mesh.CreatePointsAttr().Set([(0, 0, 0), (2, 0, 0), (0, 3, 0)], 5.0)
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    np.testing.assert_array_equal(default_view.world_bounds(stage), [(0, 0, 0), (2, 3, 0)])


def test_an_animated_stage_is_framed_where_it_begins():
    stage = stage_of()
    stage.SetStartTimeCode(10)
    stage.SetEndTimeCode(20)
    xform = UsdGeom.Xform.Define(stage, "/World").AddTranslateOp()
    xform.Set(Gf.Vec3d(50, 0, 0), 10)
    xform.Set(Gf.Vec3d(90, 0, 0), 20)
    np.testing.assert_allclose(default_view.world_bounds(stage), [(49.5, -0.5, -0.5), (52, 0.5, 2)])


def test_a_stage_without_geometry_says_so():
    with pytest.raises(StageError, match="no visible geometry"):
        default_view.add_camera(Usd.Stage.CreateInMemory(), 1.0)


def test_a_stage_whose_geometry_is_in_one_point_says_so():
    stage = stage_of()
    UsdGeom.Xform.Define(stage, "/World").AddScaleOp().Set(Gf.Vec3d(0, 0, 0))
    with pytest.raises(StageError, match="all visible geometry of the stage is in one point"):
        default_view.add_camera(stage, 1.0)


@pytest.mark.filterwarnings("error")
def test_a_mesh_with_an_infinite_point_is_left_out():
    stage = stage_of()
    mesh = UsdGeom.Mesh.Define(stage, "/World/Broken")
    mesh.CreatePointsAttr([(0, 0, 0), (math.inf, 0, 0), (0, 3, 0)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    np.testing.assert_array_equal(default_view.world_bounds(stage), default_view.world_bounds(stage_of()))


def test_a_point_instancer_without_one_of_its_prototypes_is_left_out():
    stage = stage_of()
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Broken")
    instancer.CreatePrototypesRel().SetTargets([UsdGeom.Cube.Define(stage, "/World/Broken/Cube").GetPath(), "/Nowhere"])
    instancer.CreateProtoIndicesAttr([0, 1])
    instancer.CreatePositionsAttr([(90, 0, 0), (0, 0, 0)])
    np.testing.assert_array_equal(default_view.world_bounds(stage), default_view.world_bounds(stage_of()))


def test_a_skinned_character_is_framed_as_deformed_at_the_time():
    stage = Usd.Stage.CreateInMemory()
    add_character(stage)
    UsdGeom.Xformable(stage.GetPrimAtPath("/Character")).AddTranslateOp().Set(Gf.Vec3d(0, 0, 10))
    upright, bent = (default_view.world_bounds(stage, Usd.TimeCode(code)) for code in (0, 24))
    np.testing.assert_allclose(upright, [[-0.3, -0.3, 10], [0.3, 0.3, 10 + LENGTH]], atol=1e-5)
    np.testing.assert_allclose([bent[0][1], bent[0][2]], [-LENGTH / 2, 9.5], atol=1e-5)
