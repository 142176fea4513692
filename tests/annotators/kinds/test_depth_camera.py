import dataclasses

import numpy as np
import pytest
from pxr import Sdf, UsdGeom, UsdRender

from tests.annotators.ray_caster import CAMERA, PRODUCT, add_cube, make_frame, new_stage
from tests.annotators.scenes import street
from usdsdg import annotators
from usdsdg.annotators.kinds.depth import stereo
from usdsdg.annotators.kinds.depth.depth_sensor import ATTRIBUTES, SETTINGS, read_depth_sensor
from usdsdg.errors import AnnotatorError, Unsupported, UsdsdgWarning, forget_warnings
from usdsdg.graph.sampling import get_global_seed, set_global_seed
from usdsdg.session import stage_context
from usdsdg.session.settings.store import DEFAULTS, get_settings
from usdsdg.warp_start import quiet_warp

quiet_warp()

SIZE = (320, 240)
BASELINE = 0.2  # meters
NAMES = [name for name in annotators.get_registered_annotators() if name.startswith("DepthSensor")]
# A sensor of the camera's own focal length that is as good as can be.
EXACT = {
    "baselineMM": BASELINE * 1000,
    "focalLengthPixel": SIZE[0] * 24 / 20.955,
    "sensorSizePixel": SIZE[0],
    "confidenceThreshold": 1,
    "noiseMean": 0,
    "outlierRemovalEnabled": False,
}


@pytest.fixture
def stage():
    forget_warnings()
    stage = stage_context.set_stage(street())
    product = UsdRender.Product.Define(stage, PRODUCT).GetPrim()
    assert product.ApplyAPI("OmniSensorDepthSensorSingleViewAPI")
    return stage


@pytest.fixture
def restore_settings():
    yield get_settings()
    for key, value in DEFAULTS.items():
        if key.startswith(SETTINGS):
            get_settings().set(key, value)


def author(stage, **values) -> None:
    for name, value in values.items():
        assert stage.GetPrimAtPath(PRODUCT).GetAttribute(ATTRIBUTES + name).Set(value)


def compute(frame, what: str = "Distance") -> np.ndarray:
    return annotators.get(f"DepthSensor{what}").compute(frame).data


# What it measures


def test_the_second_imager_sees_what_a_camera_in_its_place_sees():
    stage = stage_context.set_stage(new_stage())
    UsdRender.Product.Define(stage, PRODUCT).GetPrim().ApplyAPI("OmniSensorDepthSensorSingleViewAPI")
    add_cube(stage, "/World/Ground", scale=(20, 20, 0.001), translate=(0, 0, -3))
    for number, (x, y, z) in enumerate([(-2, 1, 2), (1, -0.5, 4), (0, 1, 6), (2.5, 0, 0)]):
        add_cube(stage, f"/World/Sheet{number}", scale=(1, 1, 0.001), translate=(x, y, z))
    author(stage, **EXACT)
    left = make_frame(stage, SIZE)
    # The camera looks straight down with +X to its right.
    UsdGeom.Xformable(stage.GetPrimAtPath(CAMERA)).GetOrderedXformOps()[0].Set((BASELINE, 0, 10))
    right = make_frame(stage, SIZE)
    distance, truth = compute(left), right.aovs["distance_to_image_plane"]
    # Of the right picture, what the left camera sees too.
    pixels, depth = left.camera.project(right.aovs["position"].reshape(-1, 3))
    columns, rows = np.floor(pixels).astype(int).T
    inside = (columns >= 0) & (columns < SIZE[0])
    seen_by_left = left.aovs["distance_to_image_plane"][rows, columns * inside]
    visible = (inside & (np.abs(seen_by_left - depth) < 0.01)).reshape(truth.shape)
    expected = np.where(visible, truth, 0)
    # Both pictures are cut into pixels, so an edge may be one off; no row has more than two sheets.
    assert (~visible).sum() > 3000
    wrong = np.abs(distance - expected) > 0.01
    assert wrong.sum(axis=1).max() <= 4
    assert wrong.sum() < 0.005 * wrong.size


def test_points_project_to_their_pixels_in_both_imagers(stage):
    author(stage, **EXACT)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    author(stage, baselineMM=BASELINE * 10, minDistance=0.001)
    frame = make_frame(stage, SIZE)
    points, distance, colors = (compute(frame, what) for what in ("PointCloudPosition", "Distance", "PointCloudColor"))
    assert (points.dtype, points.shape, colors.dtype, colors.shape) == (
        np.float32, (240, 320, 4), np.uint8, (240, 320, 4)
    )  # fmt: skip
    measured = distance > 0
    assert measured.sum() > 15_000
    assert measured.sum() < measured.size
    np.testing.assert_array_equal(points[..., 3], measured)
    assert not points[~measured].any()
    assert not colors[~measured].any()
    np.testing.assert_allclose(-points[measured, 2], distance[measured], rtol=1e-6)
    x, y, z = points[measured, :3].T.astype(np.float64)
    rows, columns = np.nonzero(measured)
    fx = frame.camera.fx
    u_left, v = frame.camera.cx + fx * x / -z, frame.camera.cy - fx * y / -z
    u_right = frame.camera.cx + fx * (x - BASELINE / 100) / -z
    np.testing.assert_allclose(v, rows + 0.5, atol=1e-3)
    np.testing.assert_allclose(u_left % 1, 0.5, atol=1e-3)
    assert (np.abs(u_right - columns - 0.5) <= 0.501).all()
    np.testing.assert_array_equal(colors[measured], frame.aovs["LdrColor"][rows, np.floor(u_left).astype(int)])


def test_noisy_points_lie_on_the_rays_of_the_camera(stage):
    author(stage, **EXACT)
    exact = compute(make_frame(stage, SIZE), "PointCloudPosition")
    author(stage, noiseMean=0.5, noiseSigma=0.5)
    frame = make_frame(stage, SIZE)
    points = compute(frame, "PointCloudPosition")
    both = (points[..., 3] > 0) & (exact[..., 3] > 0)
    scale = points[both, 2] / exact[both, 2]
    assert scale.std() > 0.01
    np.testing.assert_allclose(points[both, :3], exact[both, :3] * scale[:, None], atol=1e-4)
    np.testing.assert_allclose(-points[both, 2], compute(frame)[both], rtol=1e-5)


def test_the_imager_is_the_luminance_of_the_picture(stage):
    frame = make_frame(stage, SIZE)
    gray = compute(frame, "Imager")
    assert gray.dtype == np.float32
    np.testing.assert_array_equal(gray, stereo.luminance(frame.aovs["LdrColor"]))
    annotators.AnnotatorRegistry.register_annotator_from_aov("DepthSensorLeftImager", np.float32, name="left")
    try:
        np.testing.assert_array_equal(annotators.get("left").compute(frame).data, gray)
    finally:
        annotators.unregister_annotator("left")


def test_noise_is_a_function_of_seed_frame_and_render_product(stage):
    author(stage, confidenceThreshold=1)
    frame = make_frame(stage, (80, 60))
    seed = get_global_seed()
    first = compute(frame)
    try:
        again = compute(dataclasses.replace(frame, memo={}))
        np.testing.assert_array_equal(first, again)
        others = [dataclasses.replace(frame, index=1, memo={})]
        others.append(dataclasses.replace(frame, render_product="/Render/Other", memo={}))
        for other in others:
            assert (compute(other) != first).any()
        set_global_seed(seed + 1)
        assert (compute(dataclasses.replace(frame, memo={})) != first).any()
    finally:
        set_global_seed(seed)


def test_smooth_surfaces_are_left_out_by_default(stage):
    frame = make_frame(stage, (80, 60))
    flat = dataclasses.replace(frame, aovs={**frame.aovs, "LdrColor": np.full((60, 80, 4), 99, np.uint8)}, memo={})
    assert not compute(flat).any()
    author(stage, confidenceThreshold=1)
    assert compute(dataclasses.replace(flat, memo={})).any()


# Its parameters


def test_the_schema_has_the_defaults_of_the_settings(stage):
    product = stage.GetPrimAtPath(PRODUCT)
    schema = {name for name in product.GetPropertyNames() if name.startswith(ATTRIBUTES)}
    keys = {key.removeprefix(SETTINGS): value for key, value in DEFAULTS.items() if key.startswith(SETTINGS)}
    assert schema == {ATTRIBUTES + name for name in [*keys, "enabled"]}
    for name, value in keys.items():
        assert product.GetAttribute(ATTRIBUTES + name).Get() == pytest.approx(value)


def test_an_attribute_counts_before_a_setting_and_a_setting_before_the_default(stage, restore_settings):
    frame = make_frame(stage, (8, 6))
    assert read_depth_sensor(frame).baseline_mm == 55
    restore_settings.set(SETTINGS + "baselineMM", 70)
    restore_settings.set(SETTINGS + "noiseMean", 1)
    author(stage, baselineMM=42)
    sensor = read_depth_sensor(frame)
    assert (sensor.baseline_mm, sensor.noise_mean, sensor.outlier_removal_enabled) == (42, 1, True)
    restore_settings.destroy_item(SETTINGS + "noiseMean")
    assert read_depth_sensor(frame).noise_mean == 0.25


def test_parameters_may_be_animated(stage):
    attribute = stage.GetPrimAtPath(PRODUCT).GetAttribute(f"{ATTRIBUTES}baselineMM")
    attribute.Set(10, 0)
    attribute.Set(20, stage.GetTimeCodesPerSecond())
    frames = [make_frame(stage, (8, 6), index=index) for index in (0, 30, 60)]  # 60 are a second
    assert [read_depth_sensor(frame).baseline_mm for frame in frames] == [10, 15, 20]


def test_attributes_without_the_schema_count_too(stage):
    other = UsdRender.Product.Define(stage, "/Render/Plain").GetPrim()
    other.CreateAttribute(f"{ATTRIBUTES}noiseSigma", Sdf.ValueTypeNames.Float).Set(2.0)
    assert read_depth_sensor(make_frame(stage, (8, 6), product="/Render/Plain")).noise_sigma == 2


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("baselineMM", 0, "two imagers in one place"),
        ("focalLengthPixel", -1, "above 0"),
        ("sensorSizePixel", 0, "above 0"),
        ("noiseDownscaleFactorPixel", 0.5, "at least 1"),
        ("rgbDepthOutputMode", 8, "from 0 to 7"),
    ],
)
def test_values_that_no_sensor_has_are_refused(stage, name, value, expected):
    author(stage, **{name: value})
    with pytest.raises(AnnotatorError, match=rf"{PRODUCT}: omni:rtx:post:depthSensor:{name} is .*{expected}"):
        compute(make_frame(stage, (8, 6)))


def test_a_sensor_that_is_switched_off_measures_nothing_and_says_so(stage):
    author(stage, enabled=False, confidenceThreshold=1)
    frame = make_frame(stage, (80, 60))
    with pytest.warns(UsdsdgWarning, match=r"measures nothing.*enabled is false. Set it to true"):
        assert not compute(frame).any()
    author(stage, enabled=True)
    assert compute(make_frame(stage, (80, 60))).any()


def test_parallel_rays_have_no_disparity(stage):
    UsdGeom.Camera(stage.GetPrimAtPath(CAMERA)).CreateProjectionAttr("orthographic")
    with pytest.raises(Unsupported, match="/World/Camera is orthographic"):
        compute(make_frame(stage, (8, 6)))


# Pictures


def shown(stage, mode: int, **values) -> tuple:
    author(stage, rgbDepthOutputMode=mode, **values)
    frame = make_frame(stage, (80, 60))
    data = compute(frame, "OutputVisualization")
    assert (data.dtype, data.shape) == (np.uint8, (60, 80, 4))
    assert (data[..., 3] == 255).all()
    return frame, data[..., :3].astype(int)


@pytest.fixture
def ranged(stage):
    author(stage, **EXACT, minDistance=5, maxDistance=15)
    return stage


def gray_of(share: np.ndarray) -> np.ndarray:
    return np.floor(np.clip(share, 0, 1) * 255 + 0.5)


def test_mode_0_is_the_picture_itself(ranged):
    frame, data = shown(ranged, 0)
    np.testing.assert_array_equal(data, frame.aovs["LdrColor"][..., :3])


@pytest.mark.parametrize("mode", [1, 2, 5])
def test_gray_modes(ranged, mode):
    frame, data = shown(ranged, mode)
    distance = compute(frame)
    share = distance % 1 if mode == 1 else (distance - 5) / 10
    expected = np.where(distance > 0, gray_of(share), 0)
    np.testing.assert_allclose(data, np.repeat(expected[..., None], 3, axis=2), atol=1)
    assert len(np.unique(data)) > 5


def test_mode_5_is_before_outliers_are_removed(ranged):
    _, before = shown(ranged, 5, outlierRemovalEnabled=True, noiseMean=0.25)
    _, after = shown(ranged, 2)
    assert (after.any(axis=2) & ~before.any(axis=2)).any()


def test_mode_3_is_blue_near_and_red_far(ranged):
    frame, data = shown(ranged, 3)
    distance = compute(frame)
    near, far = data[distance == distance[distance > 0].min()][0], data[distance == distance.max()][0]
    assert near[2] > near[0]
    assert far[0] >= near[0]
    assert not data[distance == 0].any()
    author(ranged, maxDistance=float(distance.max()))
    frame, data = shown(ranged, 3)
    assert tuple(data[compute(frame) == compute(frame).max()][0]) == (255, 0, 0)


def test_mode_4_is_the_exact_depth(ranged):
    frame, data = shown(ranged, 4)
    depth = frame.aovs["distance_to_image_plane"]
    expected = np.where(np.isfinite(depth), gray_of((depth - 5) / 10), 0)
    np.testing.assert_allclose(data[..., 0], expected, atol=1)


@pytest.mark.parametrize(("mode", "channel"), [(6, 1), (7, 0)])
def test_modes_of_the_disparity(ranged, mode, channel):
    author(ranged, maxDisparityPixel=10)
    frame, data = shown(ranged, mode)
    depth = frame.aovs["distance_to_image_plane"]
    disparity = BASELINE * EXACT["focalLengthPixel"] / depth / 10
    np.testing.assert_allclose(data[..., channel], np.where(np.isfinite(depth), gray_of(disparity), 0), atol=1)


def test_mode_6_has_the_confidence_in_red(ranged):
    frame, data = shown(ranged, 6, confidenceThreshold=0.5)
    gray = stereo.luminance(frame.aovs["LdrColor"])
    np.testing.assert_allclose(data[..., 0], gray_of(stereo.texture(gray) * 0.5), atol=1)
    assert not data[..., 2].any()


def test_the_measuring_annotators_say_where_the_picture_of_a_mode_is(stage):
    author(stage, rgbDepthOutputMode=3)
    with pytest.warns(UsdsdgWarning, match=r"rgbDepthOutputMode does not change.*'DepthSensorOutputVisualization'"):
        compute(make_frame(stage, (8, 6)))


def test_the_distance_at_the_center_is_printed_once_a_frame(stage, capsys):
    author(stage, **EXACT, showDistance=True)
    frame = make_frame(stage, (80, 60))
    for what in ("Distance", "PointCloudColor", "PointCloudPosition"):
        compute(frame, what)
    assert capsys.readouterr().out == f"{PRODUCT}: {compute(frame)[30, 40]:.3f} m at the center\n"


def test_every_one_is_tried_here():
    assert {name.removeprefix("DepthSensor") for name in NAMES} == {
        "Distance", "PointCloudPosition", "PointCloudColor", "Imager", "OutputVisualization"
    }  # fmt: skip
