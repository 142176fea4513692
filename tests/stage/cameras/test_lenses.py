"""Lens models against OpenCV's documented formulas and textbooks, and their inverses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import Gf, Sdf, Usd, UsdGeom

import usdsdg.session.stage_context  # noqa: F401  registers the schemas
from tests.stage.cameras.lens_cases import CASES, F_THETA, LENSES
from usdsdg.errors import RenderError, Unsupported
from usdsdg.stage.cameras.camera_view import CameraView, read_camera
from usdsdg.stage.cameras.lens_attributes import LensParameters
from usdsdg.stage.cameras.lens_curves import HALF_SINE, ODD, POWER, RATIONAL, SINE, monotonic_curve

SIZE = (960, 600)


def view(size=SIZE, **values) -> CameraView:
    return CameraView("/cam", *size, np.eye(4), **{"focal_length": 24.0, **values})


def random_pixels(size=SIZE, count=2000) -> np.ndarray:
    return np.random.default_rng(1).uniform((0, 0), size, (count, 2))


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_a_ray_through_a_pixel_projects_to_that_pixel(case):
    camera, pixels = view(**case), random_pixels()
    origins, directions = camera.rays(pixels)
    seen = np.isfinite(directions).all(axis=1)
    assert seen.mean() > 0.4
    np.testing.assert_allclose(np.linalg.norm(directions[seen], axis=1), 1.0, atol=1e-12)
    back, depth = camera.project((origins + 3.0 * directions)[seen])
    np.testing.assert_allclose(back, pixels[seen], atol=1e-6)
    np.testing.assert_allclose(depth, -(origins + 3.0 * directions)[seen, 2], atol=1e-12)


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_a_visible_point_is_on_the_ray_of_its_pixel(case):
    camera = view(**case)
    points = np.random.default_rng(2).normal(size=(4000, 3)) * (2.0, 2.0, 3.0)
    pixels, _ = camera.project(points)
    inside = (np.isfinite(pixels) & (pixels > 0) & (pixels < SIZE)).all(axis=1)
    if case.get("projection_type") == "orthographic":
        inside &= points[:, 2] < 0
    assert inside.sum() > 50
    origins, directions = camera.rays(pixels[inside])
    toward = points[inside] - origins
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    np.testing.assert_allclose(directions, toward, atol=1e-9)


def opencv_pinhole(points, focal, center, k, p, s):
    """cv::projectPoints, from OpenCV's documentation: x right, y down, z ahead."""
    x, y = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
    r2 = x**2 + y**2
    radial = (1 + k[0] * r2 + k[1] * r2**2 + k[2] * r2**3) / (1 + k[3] * r2 + k[4] * r2**2 + k[5] * r2**3)
    u = x * radial + 2 * p[0] * x * y + p[1] * (r2 + 2 * x**2) + s[0] * r2 + s[1] * r2**2
    v = y * radial + p[0] * (r2 + 2 * y**2) + 2 * p[1] * x * y + s[2] * r2 + s[3] * r2**2
    return np.stack([focal[0] * u + center[0], focal[1] * v + center[1]], axis=1)


def opencv_fisheye(points, focal, center, k):
    """cv::fisheye::projectPoints, from OpenCV's documentation."""
    a, b = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
    r = np.hypot(a, b)
    theta = np.arctan(r)
    distorted = theta * (1 + k[0] * theta**2 + k[1] * theta**4 + k[2] * theta**6 + k[3] * theta**8)
    return np.stack([focal[0] * distorted / r * a + center[0], focal[1] * distorted / r * b + center[1]], axis=1)


def aria(points, focal, center, k, p, s):
    """Fisheye624 of Project Aria's documentation, which KannalaBrandtK3 is a part of."""
    a, b = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
    r = np.hypot(a, b)
    theta = np.arctan(r)
    distorted = theta + sum(each * theta ** (2 * i + 3) for i, each in enumerate(k))
    uv = np.stack([distorted / r * a, distorted / r * b], axis=1)
    squared = (uv**2).sum(axis=1, keepdims=True)
    tangential = 2 * uv * (uv @ p)[:, None] + squared * p
    prism = np.stack([s[0] * squared + s[1] * squared**2, s[2] * squared + s[3] * squared**2], axis=1)[..., 0]
    return (uv + tangential + prism) * focal + center


def before(count=500, spread=0.6) -> np.ndarray:
    """Random points before a camera that looks along +z with y down, as in computer vision."""
    generator = np.random.default_rng(4)
    points = np.concatenate([generator.uniform(-spread, spread, (count, 2)), np.ones((count, 1))], axis=1)
    return points * generator.uniform(0.5, 20.0, (count, 1))


OPENCV_TO_USD = (1.0, -1.0, -1.0)


def half_size(case):
    """Return the lens parameters of a case, with focal length and center for an image of half the nominal size."""
    values = case["lens_parameters"]
    assert values.nominal_size == (2 * SIZE[0], 2 * SIZE[1])
    return values, np.array(values.focal) / 2, np.array(values.center) / 2


def test_opencv_pinhole():
    values, focal, center = half_size(CASES["pinholeOpenCV"])
    expected = opencv_pinhole(before(), focal, center, values.polynomial, values.tangential, values.thin_prism)
    pixels, _ = view(**CASES["pinholeOpenCV"]).project(before() * OPENCV_TO_USD)
    np.testing.assert_allclose(pixels, expected, atol=1e-9)


def test_opencv_fisheye():
    values, focal, center = half_size(CASES["fisheyeOpenCV"])
    expected = opencv_fisheye(before(spread=2.0), focal, center, values.polynomial)
    pixels, _ = view(**CASES["fisheyeOpenCV"]).project(before(spread=2.0) * OPENCV_TO_USD)
    np.testing.assert_allclose(pixels, expected, atol=1e-9)


@pytest.mark.parametrize("name", ["fisheyeKannalaBrandtK3", "fisheyeRadTanThinPrism"])
def test_arias_fisheyes(name):
    values, _, center = half_size(CASES[name])
    focal = SIZE[0] * 8.0 / 20.955
    kannala = name == "fisheyeKannalaBrandtK3"
    p, s = (np.zeros(2), np.zeros(4)) if kannala else (np.array(values.tangential), values.thin_prism)
    k = values.polynomial[:4] if kannala else values.polynomial
    pixels, _ = view(**CASES[name]).project(before(spread=2.0) * OPENCV_TO_USD)
    np.testing.assert_allclose(pixels, aria(before(spread=2.0), focal, center, k, p, s), atol=1e-9)


def test_f_theta_is_the_polynomial_of_isaac_sims_writers():
    camera, radii = view(size=(1936, 1216), **CASES["fisheyePolynomial"]), np.array([0.0, 1.0, 200.0, 500.0, 700.0])
    a, b, c, d, e, f = F_THETA.polynomial
    theta = a + b * radii + c * radii**2 + d * radii**3 + e * radii**4 + f * radii**5
    points = np.stack([np.sin(theta), 0 * theta, -np.cos(theta)], axis=1) * 5
    pixels, _ = camera.project(points)
    np.testing.assert_allclose(pixels, np.stack([970.94244 + radii, np.full(5, 600.37482)], axis=1), atol=1e-6)
    # At 700 pixels the angle is almost 90 degrees.
    assert theta[-1] < np.pi / 2 < theta[-1] + 0.1


@pytest.mark.parametrize(
    ("name", "law"),
    [
        ("fisheyeEquidistant", lambda angle: angle),
        ("fisheyeEquisolid", lambda angle: 2 * np.sin(angle / 2)),
        ("fisheyeOrthographic", np.sin),
    ],
)
def test_ideal_fisheyes_see_at_the_edge_what_a_pinhole_sees(name, law):
    camera = view(projection_type=name, focal_length=6.0)
    edge = np.arctan(20.955 / 2 / 6.0)
    angles = np.array([0.0, 0.3, edge])
    pixels, _ = camera.project(np.stack([np.sin(angles), 0 * angles, -np.cos(angles)], axis=1))
    expected = 480 + 480 * law(angles) / law(edge)
    np.testing.assert_allclose(pixels, np.stack([expected, np.full(3, 300.0)], axis=1), atol=1e-9)


def test_a_panorama_shows_all_directions():
    camera = view(projection_type="fisheyeSpherical")
    points = [(0, 0, -1), (1, 0, 0), (-1, 0, 0), (1e-9, 0, 1), (0, 1, -1)]
    pixels, _ = camera.project(points)
    np.testing.assert_allclose(pixels, [(480, 300), (720, 300), (240, 300), (960, 300), (480, 150)], atol=1e-4)


def test_nothing_is_seen_beyond_the_field_of_view():
    camera = view(projection_type="fisheyeEquidistant", focal_length=3.0)
    limited = view(projection_type="fisheyePolynomial", lens_parameters=LensParameters(max_fov=90.0))
    for angle, seen in ((44.0, True), (46.0, False)):
        point = [(0, np.sin(np.radians(angle)), -np.cos(np.radians(angle)))]
        assert np.isfinite(camera.project(point)[0]).all()
        assert np.isfinite(limited.project(point)[0]).all() == seen
    radius = np.radians(45) / 0.00245 * SIZE[0] / 1936
    center = np.array([970.94244 * SIZE[0] / 1936, 600.37482 * SIZE[1] / 1216])
    _, directions = limited.rays(center + np.array([(radius * 0.999, 0), (radius * 1.001, 0)]))
    assert np.isfinite(directions).all(axis=1).tolist() == [True, False]


@pytest.mark.parametrize("case", LENSES.values(), ids=LENSES)
def test_extrapolated_pixels_are_farther_out_than_visible_ones(case):
    camera = view(**case)
    lens = camera.lens
    assert lens is not None
    if lens.curve is None:
        return
    most = np.degrees(np.arctan(lens.curve.limit)) if lens.is_flat else 180.0
    angles = np.radians(np.linspace(1.0, most - 0.01, 300))
    points = np.stack([np.sin(angles), 0 * angles, -np.cos(angles)], axis=1)
    seen, everywhere = lens.to_pixels(points), lens.to_pixels(points, extrapolate=True)
    assert np.isfinite(everywhere).all()
    known = np.isfinite(seen).all(axis=1)
    np.testing.assert_array_equal(everywhere[known], seen[known])
    assert (np.diff(everywhere[:, 0]) > 0).all()


@given(
    kind=st.sampled_from([ODD, POWER, RATIONAL]),
    k=st.lists(st.floats(-0.4, 0.4), min_size=6, max_size=6),
    fraction=st.floats(0.0, 1.0),
)
@settings(max_examples=200, deadline=None)
def test_curves_increase_up_to_their_limit_and_are_inverted(kind, k, fraction):
    if kind == POWER:
        k = [0.0, abs(k[1]) + 0.01, *k[2:]]
    curve = monotonic_curve(kind, tuple(k), max_t=3.0)
    t = np.linspace(0.0, curve.limit, 500)
    values, slopes = curve.evaluate(t)
    assert (np.diff(values) > -1e-12).all()
    step = 1e-6 * max(curve.limit, 1e-3)
    rises = (curve.evaluate(t + step)[0] - curve.evaluate(t - step)[0]) / (2 * step)
    rounding = 1e-6 * (1.0 + np.abs(values) / max(curve.limit, 1e-3))
    assert (np.abs(rises - slopes) <= 1e-4 * np.abs(slopes).max() + rounding).all()
    value = np.array([fraction * curve.limit_value])
    np.testing.assert_allclose(curve.evaluate(curve.solve(value))[0], value, atol=1e-9 * max(1.0, curve.limit_value))


@pytest.mark.parametrize(("kind", "end"), [(SINE, np.pi / 2), (HALF_SINE, np.pi)])
def test_curves_of_sines(kind, end):
    curve = monotonic_curve(kind)
    assert curve.limit == end
    np.testing.assert_allclose(curve.solve(curve.evaluate(np.array([0.0, 0.7, 1.5]))[0]), [0.0, 0.7, 1.5], atol=1e-7)


def test_calibrations_that_give_no_image_are_refused():
    for values in (dict(polynomial=(0.0,) * 6), dict(polynomial=(0.0, -1.0, 0.0, 0.0, 0.0, 0.0))):
        with pytest.raises(Unsupported, match=r"/cam: the lens fisheyePolynomial cannot be drawn.*does not increase"):
            _ = view(projection_type="fisheyePolynomial", lens_parameters=LensParameters(**values)).lens
    for values in (dict(focal=(0.0, 1.0)), dict(max_fov=0.0), dict(polynomial=(np.nan,) * 6)):
        with pytest.raises(Unsupported, match="fisheyeOpenCV cannot be drawn: its focal length or its field of view"):
            _ = view(projection_type="fisheyeOpenCV", lens_parameters=LensParameters(**values)).lens
    for name in ("fisheyeEquisolid", "fisheyeKannalaBrandtK3"):
        with pytest.raises(Unsupported, match=f"{name} cannot be drawn: its focalLength is 0"):
            _ = view(projection_type=name, focal_length=0.0).lens
    hardly = view(
        projection_type="fisheyePolynomial", lens_parameters=LensParameters(polynomial=(0.0, 1e-20, 0, 0, 0, 0))
    )
    assert np.isfinite(hardly.rays(random_pixels())[1]).all()


def test_a_fisheye_that_clips_everything():
    stage = Usd.Stage.CreateInMemory()
    camera = UsdGeom.Camera.Define(stage, "/cam")
    camera.GetPrim().CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token).Set("fisheyeSpherical")
    camera.CreateClippingRangeAttr(Gf.Vec2f(5, 5))
    with pytest.raises(RenderError, match="/cam gives no image: clippingRange"):
        read_camera(stage, "/cam", SIZE)
    camera.CreateClippingRangeAttr(Gf.Vec2f(0, 5))
    assert read_camera(stage, "/cam", SIZE).lens is not None


def schema_camera(schema: str, **values) -> CameraView:
    stage = Usd.Stage.CreateInMemory()
    prim = UsdGeom.Camera.Define(stage, "/cam").GetPrim()
    assert prim.ApplyAPI(schema)
    model = prim.GetAttribute("omni:lensdistortion:model").Get()
    for name, value in values.items():
        assert prim.GetAttribute(f"omni:lensdistortion:{model}:{name}").Set(value), name
    return read_camera(stage, "/cam", (960, 600))


def test_lens_distortion_schemas_give_the_same_lenses():
    values = CASES["pinholeOpenCV"]["lens_parameters"]
    common = dict(fx=640.0, fy=620.0, cx=943.8, cy=602.3, imageSize=Gf.Vec2i(1920, 1200))
    k = {f"k{i + 1}": each for i, each in enumerate(values.polynomial)}
    p = {f"p{i + 1}": each for i, each in enumerate(values.tangential)}
    s = {f"s{i + 1}": each for i, each in enumerate(values.thin_prism)}
    pairs = [
        (schema_camera("OmniLensDistortionOpenCvPinholeAPI", **common, **k, **p, **s), "pinholeOpenCV"),
        (schema_camera("OmniLensDistortionOpenCvFisheyeAPI", **common, **dict(list(k.items())[:4])), "fisheyeOpenCV"),
    ]
    nominal = dict(nominalWidth=1936.0, nominalHeight=1216.0, maxFov=200.0)
    polynomial = {f"k{i}": each for i, each in enumerate(F_THETA.polynomial[:5])}
    pairs.append((schema_camera("OmniLensDistortionFthetaAPI", **nominal, **polynomial), "fisheyePolynomial"))
    for camera, name in pairs:
        assert camera.projection_type == name
        points = before(spread=0.7) * OPENCV_TO_USD
        np.testing.assert_allclose(camera.project(points)[0], view(**CASES[name]).project(points)[0], atol=1e-3)


def test_schemas_have_defaults_and_take_precedence_over_the_older_attribute():
    camera = schema_camera("OmniLensDistortionRadTanThinPrismAPI", k0=0.5)
    assert camera.projection_type == "fisheyeRadTanThinPrism"
    assert camera.lens_parameters.polynomial[0] == 0.5
    assert camera.lens_parameters.thin_prism == pytest.approx((-0.00058, -0.00022, 0.00019, -0.0002))
    stage = Usd.Stage.CreateInMemory()
    prim = UsdGeom.Camera.Define(stage, "/cam").GetPrim()
    prim.CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token).Set("fisheyeSpherical")
    assert read_camera(stage, "/cam", SIZE).projection_type == "fisheyeSpherical"
    # Written without applying the schema, as older pxr versions of scripts do.
    prim.CreateAttribute("omni:lensdistortion:model", Sdf.ValueTypeNames.Token).Set("opencvFisheye")
    found = read_camera(stage, "/cam", SIZE)
    assert (found.projection_type, found.lens_parameters.focal) == ("fisheyeOpenCV", (900.0, 800.0))
    assert found.lens_parameters.nominal_size == (2048.0, 1024.0)
