"""What annotators say of pictures through a lens: an equidistant fisheye, whose formula is one line."""

from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom

from tests.annotators import ray_caster
from tests.annotators.ray_caster import CAMERA, make_frame
from tests.annotators.scenes import street
from usdsdg import annotators
from usdsdg.session import render_products
from usdsdg.session.stage_context import set_stage

SIZE = (64, 48)


def compute(frame, name) -> Any:
    return annotators.get(name).compute(frame).data


def fisheye_rays(view):
    """Rays of a fisheye of 120 degrees across the picture."""
    v, u = np.mgrid[0 : view.height, 0 : view.width] + 0.5
    x, y = (u - view.width / 2).ravel(), (view.height / 2 - v).ravel()
    radius = np.hypot(x, y)
    angle = radius / (view.width / 2) * np.radians(60)
    in_camera = np.stack([np.sin(angle) * x / radius, np.sin(angle) * y / radius, -np.cos(angle)], axis=1)
    directions = in_camera @ view.local_to_world[:3, :3]
    return np.broadcast_to(view.local_to_world[3, :3], directions.shape), directions


@pytest.fixture
def stage(monkeypatch):
    stage = set_stage(street())
    for path in (CAMERA, "/World/Right"):
        camera = UsdGeom.Camera.Define(stage, path)
        camera.CreateHorizontalApertureAttr(20.0)
        camera.CreateFocalLengthAttr(10.0 / np.tan(np.radians(60)))
        camera.CreateClippingRangeAttr(Gf.Vec2f(0.1, 100))
        camera.GetPrim().CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token).Set("fisheyeEquidistant")
    ray_caster.place(stage.GetPrimAtPath("/World/Right"), translate=(0.6, 0, 10))
    stage.GetPrimAtPath(CAMERA).CreateAttribute("crossCameraReferenceName", Sdf.ValueTypeNames.String).Set("Right")
    render_products.add(render_products.HydraTexture("/Render/Right", "/World/Right", SIZE))
    monkeypatch.setattr(ray_caster, "rays", fisheye_rays)
    yield stage
    render_products.reset()


def test_points_of_depths_are_where_the_rays_met_something(stage):
    frame = make_frame(stage, SIZE)
    points = compute(frame, "DistanceToImagePlaneSDIsaacConvertDepthToPointCloud")
    seen = (frame.aovs["instance"] >= 0).ravel()
    assert seen.sum() > 100
    assert np.isposinf(points[~seen]).all()
    world = points[seen] * (1, -1, -1) @ frame.camera.local_to_world[:3, :3] + frame.camera.local_to_world[3, :3]
    np.testing.assert_allclose(world, frame.aovs["position"].reshape(-1, 3)[seen], atol=1e-5)


def test_a_pair_of_fisheyes_finds_each_others_points(stage):
    frame = make_frame(stage, SIZE)
    out = compute(frame, "cross_correspondence")
    seen = frame.aovs["instance"] >= 0
    points = frame.aovs["position"][seen].astype(float) - (0.6, 0, 10)
    angle = np.arctan2(np.hypot(points[:, 0], points[:, 1]), -points[:, 2])
    radius = angle / np.radians(60) * SIZE[0] / 2
    side = points[:, :2] / np.hypot(points[:, 0], points[:, 1])[:, None]
    column, row = SIZE[0] / 2 + radius * side[:, 0], SIZE[1] / 2 - radius * side[:, 1]
    rows, columns = np.nonzero(seen)
    np.testing.assert_allclose(out[seen, 0] * SIZE[0], column - columns - 0.5, atol=1e-3)
    np.testing.assert_allclose(out[seen, 1] * SIZE[1], row - rows - 0.5, atol=1e-3)
    outside = (column < 0) | (column >= SIZE[0]) | (row < 0) | (row >= SIZE[1])
    np.testing.assert_array_equal(out[seen, 2], outside)


def test_lens_distortion_schemas_are_told_by_the_older_names(stage):
    prim = stage.GetPrimAtPath(CAMERA)
    prim.ApplyAPI("OmniLensDistortionOpenCvPinholeAPI")
    prefix = "omni:lensdistortion:opencvPinhole:"
    prim.GetAttribute(prefix + "imageSize").Set(Gf.Vec2i(640, 480))
    for name, value in dict(fx=500.0, fy=510.0, cx=300.0, cy=250.0, k2=0.1, p1=0.01, s4=0.02).items():
        prim.GetAttribute(prefix + name).Set(value)
    params = annotators.get("camera_params").compute(make_frame(stage, SIZE)).info
    assert params["cameraModel"] == "pinholeOpenCV"
    assert (params["cameraOpenCVFx"], params["cameraOpenCVFy"]) == (500.0, 510.0)
    assert (params["cameraFisheyeNominalWidth"], params["cameraFisheyeNominalHeight"]) == (640.0, 480.0)
    np.testing.assert_allclose(params["cameraFisheyeOpticalCentre"], (300, 250))
    np.testing.assert_allclose(params["cameraFisheyePolynomial"], (0, 0.1, 0, 0, 0, 0))
    np.testing.assert_allclose(params["cameraFisheyeLensP"], (0.01, 0))
    np.testing.assert_allclose(params["cameraFisheyeLensS"], (0, 0, 0, 0.02))
