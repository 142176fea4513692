import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom

from tests.annotators.ray_caster import make_frame, new_stage
from tests.annotators.scenes import add_camera
from usdsdg import annotators
from usdsdg.annotators.kinds.camera import read_params


def params_of(stage, camera, resolution=(64, 48)):
    return annotators.get("camera_params").compute(make_frame(stage, resolution, camera=camera)).info


@pytest.fixture
def stage():
    return new_stage()


def test_view_and_projection_take_points_to_clip_space_with_reversed_depth(stage):
    add_camera(stage, "/World/C", (3, -4, 5), (0, 0, 1), near=0.5)
    params = params_of(stage, "/World/C")
    view, projection = params["cameraViewTransform"].reshape(4, 4), params["cameraProjection"].reshape(4, 4)
    np.testing.assert_allclose([3, -4, 5, 1] @ view, [0, 0, 0, 1], atol=1e-12)
    for distance, depth in ((0.5, 1.0), (1000.0, 0.0)):
        clip = np.array([0, 0, -distance, 1]) @ projection
        np.testing.assert_allclose(clip / clip[3], [0, 0, depth, 1], atol=1e-9)
    # 2 f / aperture
    assert projection[0, 0] == pytest.approx(2 * 24.0 / 20.955)
    assert projection[1, 1] == pytest.approx(2 * 24.0 / 20.955 * 64 / 48)


def test_types_and_shapes(stage):
    params = params_of(stage, "/World/Camera")
    for key, dtype, size in [
        ("cameraAperture", np.float32, 2),
        ("cameraApertureOffset", np.float32, 2),
        ("cameraNearFar", np.float32, 2),
        ("cameraFisheyeOpticalCentre", np.float32, 2),
        ("cameraFisheyePolynomial", np.float32, 6),
        ("cameraProjection", np.float64, 16),
        ("cameraViewTransform", np.float64, 16),
        ("renderProductResolution", np.int32, 2),
    ]:
        assert (params[key].dtype, params[key].shape) == (dtype, (size,)), key
    assert params["renderProductResolution"].tolist() == [64, 48]
    assert params["cameraModel"] == "pinhole"
    assert params["metersPerSceneUnit"] == 1.0
    assert params["cameraFocalLength"] == 24.0


def test_a_pinhole_reports_no_lens(stage):
    params = params_of(stage, "/World/Camera")
    for key in ("MaxFOV", "NominalHeight", "NominalWidth"):
        assert params[f"cameraFisheye{key}"] == 0, key
    assert isinstance(params["cameraFisheyeNominalWidth"], int)
    assert params["cameraFisheyeOpticalCentre"].tolist() == [0, 0]
    assert params["cameraFisheyePolynomial"].tolist() == [0] * 6
    assert params["cameraFisheyeLensP"].size == params["cameraFisheyeLensS"].size == 0


def test_lens_attributes_are_read_from_the_prim(stage):
    prim = stage.GetPrimAtPath("/World/Camera")
    prim.CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token).Set("fisheyePolynomial")
    prim.CreateAttribute("fthetaPolyB", Sdf.ValueTypeNames.Float).Set(0.005)
    prim.CreateAttribute("fthetaCx", Sdf.ValueTypeNames.Float).Set(12.0)
    UsdGeom.Camera(prim).GetClippingRangeAttr().Set(Gf.Vec2f(1, 50))
    from tests.annotators.ray_caster import read_camera

    params = read_params(read_camera(stage, "/World/Camera", (32, 32)))
    assert params["cameraModel"] == "fisheyePolynomial"
    assert params["cameraFisheyePolynomial"][1] == pytest.approx(0.005)
    assert params["cameraFisheyeOpticalCentre"][0] == 12.0
    # The matrix is that of a pinhole, as in Replicator.
    assert params["cameraProjection"].reshape(4, 4)[0, 0] == pytest.approx(2 * 24.0 / 20.955)


def test_both_names_tell_the_same(stage):
    one, other = (annotators.get(n).compute(make_frame(stage, (8, 6))).info for n in ("camera_params", "CameraParams"))
    assert one.keys() == other.keys()
    for key in one:
        np.testing.assert_array_equal(one[key], other[key])


def test_reference_time(stage):
    assert annotators.get("ReferenceTime").compute(make_frame(stage, (4, 4), index=7)).info == {
        "referenceTimeNumerator": 7,
        "referenceTimeDenominator": 60,
    }
