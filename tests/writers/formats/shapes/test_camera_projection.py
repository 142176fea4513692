import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from pxr import Sdf, UsdGeom

from tests.annotators.ray_caster import CAMERA, new_stage
from tests.annotators.scenes import add_camera
from tests.stage.cameras.lens_cases import LENSES
from usdsdg.annotators.kinds.camera import read_params
from usdsdg.stage.cameras.camera_view import CameraView, read_camera
from usdsdg.writers.formats.shapes.camera_projection import clip_to_front, project

coordinates = st.floats(-5, 5)


def camera(**attributes):
    """A view and its parameters; attributes are authored as floats."""
    stage = new_stage()
    add_camera(stage, "/World/C", (3, -4, 5), (0, 0, 1), near=0.5)
    prim = stage.GetPrimAtPath("/World/C")
    for name, value in attributes.items():
        if isinstance(value, str):
            prim.CreateAttribute(name, Sdf.ValueTypeNames.Token).Set(value)
        else:
            prim.CreateAttribute(name, Sdf.ValueTypeNames.Float).Set(value)
    view = read_camera(stage, "/World/C", (64, 48))
    return view, read_params(view)


@given(x=coordinates, y=coordinates, depth=st.floats(0.01, 50))  # the near plane is at 0.5
def test_pinhole_equals_similar_triangles(x, y, depth):
    _, params = camera()
    focal = 64 * 24.0 / 20.955
    expected = [[32 + focal * x / depth, 24 - focal * y / depth]]
    np.testing.assert_allclose(project(np.array([[x, y, -depth]]), params), expected, rtol=1e-5, atol=1e-3)


@given(x=coordinates, y=coordinates, z=coordinates)
def test_a_shifted_aperture_moves_the_picture_as_the_camera_says(x, y, z):
    view, params = camera(horizontalApertureOffset=2.0, verticalApertureOffset=-1.0)
    point = np.array([[x, y, z]])
    pixels, depth = view.project(point)
    assume(depth[0] > 1)
    in_camera = point @ view.world_to_camera[:3, :3] + view.world_to_camera[3, :3]
    np.testing.assert_allclose(project(in_camera, params), pixels, rtol=1e-5, atol=1e-3)


def test_an_orthographic_camera_does_not_shrink_with_depth():
    view, params = camera(projection="orthographic")
    points = np.array([[0.1, 0.05, -1.0], [0.1, 0.05, -30.0], [0.1, 0.05, 3.0]])
    pixels = project(points, params)
    world = points @ view.local_to_world[:3, :3] + view.local_to_world[3, :3]
    np.testing.assert_allclose(pixels, view.project(world)[0], atol=1e-6)
    np.testing.assert_allclose(pixels[0], pixels[1])


@given(x=coordinates, y=coordinates, z=st.floats(-0.5, 10))
def test_a_point_behind_keeps_its_side_of_the_picture(x, y, z):
    _, params = camera()
    ((u, v),) = project(np.array([[x, y, z]]), params)
    assert (u - 32) * x >= 0
    assert (24 - v) * y >= 0


@given(ends=st.lists(coordinates, min_size=6, max_size=6))
def test_clipped_segments_lie_in_front_and_on_the_line(ends):
    _, params = camera()
    segment = np.array(ends).reshape(1, 2, 3)
    clipped = clip_to_front(segment, params)
    beyond = -segment[0, :, 2] > 0.5
    assert len(clipped) == bool(beyond.any())
    for part in clipped:
        assert (-part[:, 2] >= 0.5 - 1e-9).all()
        along = segment[0, 1] - segment[0, 0]
        for point in part:
            np.testing.assert_allclose(np.cross(point - segment[0, 0], along), 0, atol=1e-8)
    if beyond.all():
        np.testing.assert_array_equal(clipped, segment)


@given(theta=st.floats(0.01, 1.5), turn=st.floats(0, 6.2))
def test_the_fisheye_inverts_its_polynomial(theta, turn):
    _, params = camera(
        cameraProjectionType="fisheyePolynomial",
        fthetaWidth=640.0,
        fthetaHeight=480.0,
        fthetaCx=300.0,
        fthetaCy=250.0,
        fthetaPolyB=0.0024,
        fthetaPolyD=1e-9,
    )
    point = np.array([[np.sin(theta) * np.cos(turn), np.sin(theta) * np.sin(turn), -np.cos(theta)]]) * 7
    ((u, v),) = project(point, params)
    # The picture is a tenth of the nominal size.
    x, y = u * 10 - 300, 250 - v * 10
    radius = np.hypot(x, y)
    assert 0.0024 * radius + 1e-9 * radius**3 == pytest.approx(theta, abs=1e-5)
    assert np.cos(np.arctan2(y, x) - turn) == pytest.approx(1, abs=1e-9)


def test_the_fisheye_sees_behind_itself():
    _, params = camera(cameraProjectionType="fisheyePolynomial", fthetaPolyB=0.00245, fthetaPolyC=0.0)
    pixels = project(np.array([[1.0, 0.0, 1.0], [1.0, 0.0, -1.0]]), params)
    center = project(np.array([[0.0, 0.0, -1.0]]), params)
    assert pixels[0, 0] > pixels[1, 0] > center[0, 0]


def test_the_opencv_pinhole_has_its_own_focal_length():
    _, params = camera(
        cameraProjectionType="pinholeOpenCV",
        fthetaWidth=64.0,
        fthetaHeight=48.0,
        fthetaCx=30.0,
        fthetaCy=25.0,
        openCVFx=50.0,
        openCVFy=40.0,
        **{f"fthetaPoly{letter}": 0.0 for letter in "AB"},
        **{name: 0.0 for name in ("p0", "p1", "s0", "s1", "s2", "s3")},
    )
    np.testing.assert_allclose(project(np.array([[0.2, 0.1, -2.0]]), params), [[30 + 5, 25 - 2]])


def test_the_camera_of_the_ray_caster_is_the_one_projected_with():
    """The oracle of the other tests: a ray through a pixel's center projects to that center."""
    from tests.annotators.ray_caster import rays

    stage = new_stage()
    UsdGeom.Camera(stage.GetPrimAtPath(CAMERA)).GetFocalLengthAttr().Set(31.0)
    view = read_camera(stage, CAMERA, (16, 12))
    origins, directions = rays(view)
    points = (origins + 3 * directions) @ view.world_to_camera[:3, :3] + view.world_to_camera[3, :3]
    v, u = np.mgrid[0:12, 0:16]
    np.testing.assert_allclose(project(points, read_params(view)), np.stack([u + 0.5, v + 0.5], -1).reshape(-1, 2))


@pytest.mark.parametrize("case", LENSES.values(), ids=LENSES)
def test_every_lens_projects_as_the_camera_itself(case):
    view = CameraView("/C", 640, 400, np.eye(4), clipping_range=(0.1, 100.0), **case)
    points = np.random.default_rng(3).normal(size=(500, 3)) * (1, 1, 2)
    expected = view.project(points)[0]
    if case["projection_type"] == "pinholeOpenCV":
        expected[-points[:, 2] < 0.1] = np.nan
    seen = np.isfinite(expected).all(axis=1)
    pixels = project(points, read_params(view))
    # The payload is float32.
    np.testing.assert_allclose(pixels[seen], expected[seen], atol=0.02)
    assert np.isfinite(pixels).all()


def test_a_generalized_projection_without_a_texture_is_a_pinhole_as_in_replicator():
    _, plain = camera()
    _, params = camera(cameraProjectionType="generalizedProjection")
    points = np.random.default_rng(3).normal(size=(50, 3))
    np.testing.assert_array_equal(project(points, params), project(points, plain))
