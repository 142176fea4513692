import time
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf

from tests.annotators.ray_caster import CAMERA, add_cube, make_frame, new_stage
from tests.annotators.scenes import street
from usdsdg import annotators
from usdsdg.errors import AnnotatorError, BadPrim
from usdsdg.session.stage_context import set_stage


@pytest.fixture
def stage():
    return set_stage(street())


def data_of(frame, name) -> Any:
    return annotators.get(name).compute(frame).data


def attribute(frame, prims, name):
    return annotators.get("Attribute", init_params={"prims": prims, "attribute": name}).compute(frame).data


def test_attributes_of_several_prims_in_one_flat_array(stage):
    frame = make_frame(stage, (8, 6))
    np.testing.assert_array_equal(attribute(frame, ["/World/Apple1", "/World/Apple2"], "radius"), [0.5, 0.5])
    moved = attribute(frame, stage.GetPrimAtPath("/World/Apple1"), "xformOp:translate")
    np.testing.assert_array_equal(moved, [-1.5, 0, 0])
    assert moved.dtype == np.float64
    assert attribute(frame, CAMERA, "projection").tolist() == ["perspective"]
    assert attribute(frame, CAMERA, "focalLength").dtype == np.float32
    assert attribute(frame, CAMERA, "clippingRange").dtype == np.float32


def test_time_samples_are_read_at_the_time_of_the_frame(stage):
    stage.SetTimeCodesPerSecond(24)
    prim = stage.GetPrimAtPath("/World/Pear")
    prim.CreateAttribute("heat", Sdf.ValueTypeNames.Float3).Set(Gf.Vec3f(0, 0, 0), 0)
    prim.GetAttribute("heat").Set(Gf.Vec3f(24, 48, 72), 24)
    frame = make_frame(stage, (8, 6), index=30)  # half a second
    np.testing.assert_allclose(attribute(frame, [prim], "heat"), [12, 24, 36])


@pytest.mark.parametrize(
    ("prims", "name", "error", "message"),
    [
        ([], "radius", AnnotatorError, "needs prims and an attribute"),
        (["/World/Apple1"], "", AnnotatorError, "needs prims and an attribute"),
        (
            ["/World/Apple1"],
            "radious",
            AnnotatorError,
            "/World/Apple1 has no attribute 'radious'. Did you mean 'radius'",
        ),
        (["/World/Aple1"], "radius", BadPrim, "/World/Aple1"),
        ([CAMERA], "crossCameraReferenceName", AnnotatorError, "has no attribute"),
        ([CAMERA], "empty", AnnotatorError, "has no value"),
    ],
)
def test_what_cannot_be_read_is_told(stage, prims, name, error, message):
    stage.GetPrimAtPath(CAMERA).CreateAttribute("empty", Sdf.ValueTypeNames.Float)
    with pytest.raises(error, match=message):
        attribute(make_frame(stage, (8, 6)), prims, name)


def test_prim_paths_are_those_of_labeled_prims_in_the_order_of_ids():
    stage = new_stage()
    add_cube(stage, "/World/B", "pear")
    add_cube(stage, "/World/Bare")
    add_cube(stage, "/World/A", "apple", translate=(3, 0, 0))
    frame = make_frame(stage, (64, 48))
    paths = annotators.get("primPaths").compute(frame).info["primPaths"]
    assert paths == ["/World/B", "/World/A"]
    ids = annotators.get("instance_segmentation_fast").compute(frame).info["idToLabels"]
    assert [ids[2], ids[3]] == paths


def test_times(stage):
    frame = make_frame(stage, (8, 6), index=90)
    for name in ("fabricTime", "rpFabricTime"):
        told = annotators.get(name).compute(frame).info
        assert told == {"fabricFrameTimeNumerator": 90, "fabricFrameTimeDenominator": 60}
    simulated = annotators.get("IsaacReadSimulationTime", init_params={"resetOnStop": True}).compute(frame)
    assert simulated.legacy() == {"simulationTime": 1.5}
    before = time.time()
    told = annotators.get("IsaacReadSystemTime").compute(frame).legacy()["systemTime"]
    assert before <= told <= time.time()
    assert annotators.get("IsaacReadSystemTime").compute(frame).legacy()["systemTime"] == told, "one time per frame"
    assert annotators.get("IsaacNoop").compute(frame).legacy() == {}


def test_isaac_pictures(stage):
    frame = make_frame(stage, (32, 24))
    rgb = data_of(frame, "LdrColorIsaacConvertRGBAToRGB")
    np.testing.assert_array_equal(rgb, frame.aovs["LdrColor"][..., :3])
    points = data_of(frame, "DistanceToImagePlaneSDIsaacConvertDepthToPointCloud")
    assert points.shape == (32 * 24, 3)
    assert points.dtype == np.float32
    seen = (frame.aovs["instance"] >= 0).ravel()
    assert np.isinf(points[~seen]).all()
    # The optical frame is the camera's with y and z turned over.
    world = points[seen] * (1, -1, -1) @ frame.camera.local_to_world[:3, :3] + frame.camera.local_to_world[3, :3]
    np.testing.assert_allclose(world, frame.aovs["position"].reshape(-1, 3)[seen], atol=1e-5)


def test_points_of_an_orthographic_camera(stage):
    camera = stage.GetPrimAtPath(CAMERA)
    camera.GetAttribute("projection").Set("orthographic")
    frame = make_frame(stage, (8, 6))
    depth = np.full((6, 8), 4.0, np.float32)
    frame.aovs["distance_to_image_plane"] = depth
    points = data_of(frame, "DistanceToImagePlaneSDIsaacConvertDepthToPointCloud")
    world = points * (1, -1, -1) @ frame.camera.local_to_world[:3, :3] + frame.camera.local_to_world[3, :3]
    pixels, depths = frame.camera.project(world)
    rows, columns = np.mgrid[:6, :8] + 0.5
    np.testing.assert_allclose(pixels, np.stack([columns, rows], -1).reshape(-1, 2), atol=1e-5)
    np.testing.assert_allclose(depths, 4.0)
