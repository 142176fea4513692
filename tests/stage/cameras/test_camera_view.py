"""Camera records against Gf.Camera and Gf.Frustum."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import Gf, Sdf, Usd, UsdGeom

from tests.stage.poses.euler import compose_euler
from usdsdg import errors
from usdsdg.errors import BadPrim, RenderError, Unsupported, UsdsdgWarning
from usdsdg.stage.cameras import camera_view
from usdsdg.stage.poses.xform_ops import author_pose

RESOLUTION = (640, 360)


@pytest.fixture
def stage():
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    return stage


def make(stage, *, path="/World/cam", **attributes):
    camera = UsdGeom.Camera.Define(stage, path)
    author_pose(camera.GetPrim(), translate=(3, -4, 5), rotate_xyz=(60, 5, 30))
    for name, value in {"clippingRange": Gf.Vec2f(0.1, 100), **attributes}.items():
        camera.GetPrim().GetAttribute(name).Set(value)
    return camera


def frustum_of(camera, resolution=RESOLUTION):
    """Return USD's frustum, with the window cropped to the image's aspect ratio as in Replicator: the width fits."""
    gf_camera = camera.GetCamera(Usd.TimeCode.Default())
    gf_camera.verticalAperture = gf_camera.horizontalAperture * resolution[1] / resolution[0]
    return gf_camera.frustum


def points_before(view, count=64):
    """Return random points of the world before the camera."""
    generator = np.random.default_rng(3)
    in_camera = generator.uniform(-3, 3, (count, 3))
    in_camera[:, 2] = -generator.uniform(0.2, 50, count)
    return in_camera @ view.local_to_world[:3, :3] + view.local_to_world[3, :3]


def project_with_gf(frustum, point):
    """Project one point by Gf's matrices to (column, row); clip space is -1 to 1 with y up."""
    clip = (frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix()).Transform(Gf.Vec3d(*point))
    width, height = RESOLUTION
    return (clip[0] + 1) / 2 * width, (1 - clip[1]) / 2 * height


CASES = {
    "plain": {},
    "long": {"focalLength": 85.0, "horizontalAperture": 36.0},
    "shifted": {"horizontalApertureOffset": 2.5, "verticalApertureOffset": -1.5},
    "orthographic": {"projection": "orthographic", "horizontalAperture": 60.0},
    "orthographic shifted": {
        "projection": "orthographic",
        "horizontalApertureOffset": 3.0,
        "verticalApertureOffset": 1.0,
    },
}


@pytest.mark.parametrize("attributes", CASES.values(), ids=CASES)
def test_points_are_projected_as_by_gf(stage, attributes):
    camera = make(stage, **attributes)
    view = camera_view.read_camera(stage, "/World/cam", RESOLUTION)
    points = points_before(view)
    pixels, depth = view.project(points)
    expected = np.array([project_with_gf(frustum_of(camera), point) for point in points])
    np.testing.assert_allclose(pixels, expected, rtol=1e-6, atol=1e-4)
    in_camera = points @ view.world_to_camera[:3, :3] + view.world_to_camera[3, :3]
    np.testing.assert_allclose(depth, -in_camera[:, 2])


@pytest.mark.parametrize("attributes", CASES.values(), ids=CASES)
def test_the_projection_matrix_agrees_with_project_and_is_reversed_in_depth(stage, attributes):
    make(stage, **attributes)
    view = camera_view.read_camera(stage, "/World/cam", RESOLUTION)
    points = points_before(view)
    homogeneous = np.concatenate([points, np.ones((len(points), 1))], 1)
    clip = homogeneous @ view.world_to_camera @ view.projection_matrix
    ndc = clip[:, :3] / clip[:, 3:]
    pixels, depth = view.project(points)
    np.testing.assert_allclose((ndc[:, 0] + 1) / 2 * view.width, pixels[:, 0])
    np.testing.assert_allclose((1 - ndc[:, 1]) / 2 * view.height, pixels[:, 1])
    near, far = view.clipping_range
    axis = np.array([[0, 0, -near, 1], [0, 0, -far, 1]]) @ view.projection_matrix
    np.testing.assert_allclose(axis[:, 2] / axis[:, 3], [1, 0], atol=1e-7)
    assert np.all(np.diff(ndc[np.argsort(depth), 2]) <= 0)


def test_the_projection_matrix_is_replicators(stage):
    make(stage, clippingRange=Gf.Vec2f(0.1, 100), focalLength=24.0)
    m = camera_view.read_camera(stage, "/World/cam", (1280, 720)).projection_matrix
    expected = np.zeros((4, 4))
    expected[0, 0] = 2 * 24 / 20.955
    expected[1, 1] = expected[0, 0] * 1280 / 720
    expected[2, 2], expected[3, 2], expected[2, 3] = 0.001001, 0.1001, -1
    np.testing.assert_allclose(m, expected, atol=1e-6)


def test_pixels_are_square_and_the_vertical_aperture_is_ignored(stage):
    make(stage, verticalAperture=99.0)
    view = camera_view.read_camera(stage, "/World/cam", (100, 400))
    assert view.fx == view.fy == pytest.approx(100 * 50 / 20.955)
    assert (view.cx, view.cy) == (50, 200)
    assert view.vertical_aperture == 99.0


@given(
    pixel=st.tuples(st.floats(0, 640), st.floats(0, 360)),
    depth=st.floats(0.1, 1000),
    offset=st.tuples(st.floats(-5, 5), st.floats(-5, 5)),
    degrees=st.tuples(*[st.floats(-180, 180)] * 3),
)
@settings(max_examples=50)
def test_projection_is_undone_by_unprojection(pixel, depth, offset, degrees):
    view = camera_view.CameraView(
        "/cam",
        640,
        360,
        compose_euler((1, 2, 3), degrees),
        horizontal_aperture_offset=offset[0],
        vertical_aperture_offset=offset[1],
    )
    in_camera = [(pixel[0] - view.cx) / view.fx * depth, -(pixel[1] - view.cy) / view.fy * depth, -depth, 1]
    pixels, depths = view.project(np.array(in_camera) @ view.local_to_world @ np.eye(4)[:, :3])
    np.testing.assert_allclose(pixels[0], pixel, atol=1e-6)
    np.testing.assert_allclose(depths, depth, rtol=1e-9)


def test_points_behind_have_no_pixel(stage):
    make(stage)
    view = camera_view.read_camera(stage, "/World/cam", RESOLUTION)
    behind = np.array([0, 0, 2, 1]) @ view.local_to_world
    pixels, depth = view.project(behind[:3])
    assert np.isnan(pixels).all()
    assert depth[0] == pytest.approx(-2)
    assert view.project(np.zeros((0, 3)))[0].shape == (0, 2)


def test_all_attributes_are_read(stage):
    camera = make(stage, fStop=2.8, focusDistance=400.0, clippingRange=Gf.Vec2f(0.5, 2000))
    prim = camera.GetPrim()
    prim.CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token).Set("fisheyePolynomial")
    prim.CreateAttribute("fthetaMaxFov", Sdf.ValueTypeNames.Float).Set(200.0)
    view = camera_view.read_camera(stage, "/World/cam", RESOLUTION)
    assert view.prim_path == "/World/cam"
    assert (view.width, view.height) == RESOLUTION
    assert view.f_stop == pytest.approx(2.8)
    assert view.focus_distance == 400.0
    assert view.clipping_range == (0.5, 2000.0)
    assert view.meters_per_unit == 0.01
    assert view.projection_type == "fisheyePolynomial"
    assert view.attributes["fthetaMaxFov"] == 200.0
    assert not {"focalLength", "clippingRange", "xformOp:translate"} & set(view.attributes)
    assert view.lens is not None
    assert view.lens.model == "fisheyePolynomial"
    with pytest.raises(Unsupported, match=r"/World/cam.*fisheyePolynomial"):
        _ = view.projection_matrix


def test_unknown_projections_are_refused(stage):
    prim = make(stage).GetPrim()
    prim.CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token).Set("wide")
    view = camera_view.read_camera(stage, "/World/cam", RESOLUTION)
    for use in (lambda: view.lens, lambda: view.project(np.zeros((1, 3))), lambda: view.rays(np.zeros((1, 2)))):
        with pytest.raises(Unsupported, match=r"/World/cam.*wide.*there are pinhole"):
            use()


def test_scale_above_a_camera_does_not_scale_depths(stage):
    make(stage, path="/World/rig/cam")
    rig = UsdGeom.Xform.Define(stage, "/World/rig")
    author_pose(rig.GetPrim(), scale=(10, 10, 10))
    view = camera_view.read_camera(stage, "/World/rig/cam", RESOLUTION)
    np.testing.assert_allclose(view.local_to_world[3, :3], (30, -40, 50), atol=1e-5)
    np.testing.assert_allclose(view.local_to_world[:3, :3] @ view.local_to_world[:3, :3].T, np.eye(3), atol=1e-6)
    target = view.local_to_world[3, :3] - 7 * view.local_to_world[2, :3]
    assert view.project(target)[1][0] == pytest.approx(7)


def test_a_mirrored_camera_is_told(stage, recwarn):
    make(stage, path="/World/rig/cam")
    rig = UsdGeom.Xform.Define(stage, "/World/rig").GetPrim()
    for scale, told in (((-2, -2, 2), False), ((-2, 2, 2), True)):
        author_pose(rig, scale=scale)
        errors.forget_warnings()
        recwarn.clear()
        camera_view.read_camera(stage, "/World/rig/cam", RESOLUTION)
        named = "/World/rig/cam: the camera is mirrored by a negative scale"
        assert any(str(each.message).startswith(named) for each in recwarn) == told


@pytest.mark.parametrize("scale", [(1, 3, 1), (1, 1.05, 1), (2, -1, 0.5), (1, 200, 1)])
def test_a_sheared_camera_looks_as_gf_has_it(stage, scale):
    camera = make(stage, path="/World/rig/cam")
    author_pose(UsdGeom.Xform.Define(stage, "/World/rig").GetPrim(), scale=scale)
    errors.forget_warnings()
    with pytest.warns(UsdsdgWarning, match="/World/rig/cam: the camera is sheared by a scale above it"):
        view = camera_view.read_camera(stage, "/World/rig/cam", RESOLUTION)
    axes = view.local_to_world[:3, :3]
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    frustum = Gf.Frustum()
    frustum.SetPositionAndRotationFromMatrix(camera.ComputeLocalToWorldTransform(0))
    expected = np.array(Gf.Matrix3d(frustum.rotation))
    expected[0] *= np.sign(np.prod(scale))  # Gf unmirrors the camera; here its picture shows the stage as it is
    np.testing.assert_allclose(axes, expected, atol=2e-6)
    target = view.local_to_world[3, :3] - 7 * axes[2]
    assert view.project(target)[1][0] == pytest.approx(7)


def test_the_only_camera_below_a_prim_is_found(stage):
    make(stage, path="/Replicator/Camera_Xform/Camera")
    view = camera_view.read_camera(stage, "/Replicator/Camera_Xform", RESOLUTION)
    assert view.prim_path == "/Replicator/Camera_Xform/Camera"


def test_other_prims_are_refused_with_a_list_of_cameras(stage):
    make(stage)
    UsdGeom.Cube.Define(stage, "/World/cube")
    with pytest.raises(BadPrim, match=r"/World/cube is a Cube, not a camera; cameras on the stage: /World/cam"):
        camera_view.read_camera(stage, "/World/cube", RESOLUTION)
    make(stage, path="/World/cam_01")
    with pytest.raises(BadPrim, match="cameras below it: /World/cam, /World/cam_01"):
        camera_view.read_camera(stage, "/World", RESOLUTION)
    with pytest.raises(BadPrim, match="no prim /World/gone"):
        camera_view.read_camera(stage, "/World/gone", RESOLUTION)


@pytest.mark.parametrize(
    ("attributes", "resolution", "what"),
    [
        ({"horizontalAperture": 0.0}, RESOLUTION, "horizontalAperture"),
        ({"focalLength": 0.0}, RESOLUTION, "focalLength"),
        ({"clippingRange": Gf.Vec2f(1, 1)}, RESOLUTION, "clippingRange"),
        ({"clippingRange": Gf.Vec2f(0, 1)}, RESOLUTION, "clippingRange"),
        ({"clippingRange": Gf.Vec2f(2, 1), "projection": "orthographic"}, RESOLUTION, "clippingRange"),
        ({"clippingRange": Gf.Vec2f(-math.inf, 1), "projection": "orthographic"}, RESOLUTION, "clippingRange"),
        ({"focalLength": math.inf}, RESOLUTION, "focalLength inf"),
        ({"horizontalAperture": math.inf}, RESOLUTION, "horizontalAperture inf"),
        ({"horizontalApertureOffset": math.nan}, RESOLUTION, "horizontalApertureOffset nan"),
        ({"fStop": math.nan}, RESOLUTION, "fStop nan"),
        ({"fStop": 2.0, "focusDistance": math.inf}, RESOLUTION, "focusDistance inf"),
        ({}, (0, 10), "resolution"),
    ],
)
def test_cameras_that_give_no_image_are_refused(stage, attributes, resolution, what):
    make(stage, **attributes)
    with pytest.raises(RenderError, match=f"/World/cam gives no image.*{what}"):
        camera_view.read_camera(stage, "/World/cam", resolution)


@pytest.mark.parametrize("attributes", [{"focusDistance": math.inf}, {"clippingRange": Gf.Vec2f(1, math.inf)}])
def test_infinite_values_that_are_not_used_are_accepted(stage, attributes):
    make(stage, **attributes)
    assert camera_view.read_camera(stage, "/World/cam", RESOLUTION).fx > 0


@pytest.mark.parametrize("projection", ["perspective", "orthographic"])
def test_the_projection_matrix_of_an_infinite_far_plane_is_the_limit_of_farther_ones(stage, projection):
    make(stage, projection=projection, clippingRange=Gf.Vec2f(0.5, 1e12))
    far = camera_view.read_camera(stage, "/World/cam", RESOLUTION).projection_matrix
    stage.GetPrimAtPath("/World/cam").GetAttribute("clippingRange").Set(Gf.Vec2f(0.5, math.inf))
    endless = camera_view.read_camera(stage, "/World/cam", RESOLUTION).projection_matrix
    np.testing.assert_allclose(endless, far, atol=1e-9)


@pytest.mark.parametrize("name", ["focalLength", "clippingRange"])
def test_a_camera_with_strings_for_numbers_is_refused(stage, name):
    make(stage)
    over = Sdf.CreatePrimInLayer(stage.GetSessionLayer(), "/World/cam")
    Sdf.AttributeSpec(over, name, Sdf.ValueTypeNames.String).default = "long"
    with pytest.raises(RenderError, match=f"/World/cam gives no image: {name} 'long' is not"):
        camera_view.read_camera(stage, "/World/cam", RESOLUTION)


@pytest.mark.parametrize("wrong", [math.nan, math.inf])
def test_a_camera_with_an_invalid_transform_is_refused(stage, wrong):
    make(stage).AddTranslateOp(opSuffix="away").Set(Gf.Vec3d(0, wrong, 0))
    with pytest.raises(RenderError, match="/World/cam gives no image: a transform that is NaN or infinite"):
        camera_view.read_camera(stage, "/World/cam", RESOLUTION)


def test_a_camera_that_32_bit_numbers_do_not_reach_is_refused(stage):
    make(stage).AddTranslateOp(opSuffix="away").Set(Gf.Vec3d(0, 1e39, 0))
    with pytest.raises(RenderError, match="/World/cam gives no image: its place is farther from the origin"):
        camera_view.read_camera(stage, "/World/cam", RESOLUTION)


@pytest.mark.parametrize("unit", [0.0, -1.0, math.nan])
def test_an_invalid_length_unit_is_named_and_read_as_meters(stage, unit):
    errors.forget_warnings()
    make(stage)
    stage.SetMetadata("metersPerUnit", unit)
    with pytest.warns(UsdsdgWarning, match="metersPerUnit .* is not a length; 1 is used"):
        assert camera_view.read_camera(stage, "/World/cam", RESOLUTION).meters_per_unit == 1.0


def test_a_camera_scaled_to_zero(stage):
    camera = make(stage)
    author_pose(camera.GetPrim(), scale=(0, 1, 1))
    with pytest.raises(RenderError, match="scale of zero"):
        camera_view.read_camera(stage, "/World/cam", RESOLUTION)


@pytest.mark.parametrize("path", ["/World", "/World/cam"])
def test_a_camera_whose_xform_ops_usd_rejects_is_refused(stage, path):
    UsdGeom.Xform.Define(stage, "/World")
    make(stage)
    stage.GetPrimAtPath(path).CreateAttribute("xformOpOrder", Sdf.ValueTypeNames.TokenArray, False).Set(["translate"])
    with pytest.raises(RenderError, match="/World/cam gives no image: its xformOps, or those above it, cannot be read"):
        camera_view.read_camera(stage, "/World/cam", RESOLUTION)
