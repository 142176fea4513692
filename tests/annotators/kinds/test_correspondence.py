from typing import Any

import numpy as np
import pytest
from pxr import Sdf, UsdGeom

from tests.annotators.ray_caster import CAMERA, make_frame, place, rays
from tests.annotators.scenes import street
from usdsdg import annotators
from usdsdg.errors import AnnotatorError
from usdsdg.session import render_products
from usdsdg.session.stage_context import set_stage


def compute(frame, name) -> Any:
    return annotators.get(name).compute(frame).data


@pytest.fixture
def stage():
    """A second camera 0.6 m to the right of the first, with a render product of another size."""
    stage = set_stage(street())
    other = UsdGeom.Camera.Define(stage, "/World/Right")
    for name in ("focalLength", "horizontalAperture", "clippingRange"):
        other.GetPrim().GetAttribute(name).Set(stage.GetPrimAtPath(CAMERA).GetAttribute(name).Get())
    place(other.GetPrim(), translate=(0.6, 0, 10))
    render_products.add(render_products.HydraTexture("/Render/Left", CAMERA, (64, 48)))
    render_products.add(render_products.HydraTexture("/Render/Right", "/World/Right", (64, 48)))
    stage.GetPrimAtPath(CAMERA).CreateAttribute("crossCameraReferenceName", Sdf.ValueTypeNames.String).Set("Right")
    yield stage
    render_products.reset()


def test_a_sideways_pair_has_the_disparity_of_the_depth(stage):
    frame = make_frame(stage, (64, 48))
    out = compute(frame, "cross_correspondence")
    seen = frame.aovs["instance"] >= 0
    assert out.shape == (48, 64, 4)
    assert out.dtype == np.float32
    assert (out[~seen] == -1).all()
    disparity = -0.6 * frame.camera.fx / frame.aovs["distance_to_image_plane"][seen]
    np.testing.assert_allclose(out[seen, 0] * 64, disparity, atol=1e-4)
    np.testing.assert_allclose(out[seen, 1], 0, atol=1e-6)
    assert not out[seen, 3].any(), "nothing tells what is hidden there"


def test_the_shift_leads_to_the_ray_of_the_same_point(stage):
    place(stage.GetPrimAtPath("/World/Right"), translate=(1, -2, 9), rotate=(10, 5, 20))
    frame = make_frame(stage, (64, 48))
    out = compute(frame, "CrossCorrespondence")
    other = make_frame(stage, (64, 48), camera="/World/Right").camera
    origins, directions = rays(other)
    rows, columns = np.nonzero((frame.aovs["instance"] >= 0) & (out[..., 2] == 0))
    there = np.floor([rows + 0.5 + out[rows, columns, 1] * 48, columns + 0.5 + out[rows, columns, 0] * 64]).astype(int)
    assert len(rows) > 500
    ray = there[0] * 64 + there[1]
    to_point = frame.aovs["position"][rows, columns] - origins[ray]
    to_point /= np.linalg.norm(to_point, axis=1, keepdims=True)
    # Rays go through pixel centers, so the point is at most half a diagonal away.
    assert (1 - (to_point * directions[ray]).sum(axis=1)).max() < 1 - np.cos(np.hypot(0.5, 0.5) / other.fx)


def test_the_reference_camera_is_where_it_is_at_the_time_of_the_frame(stage):
    move = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Right")).GetOrderedXformOps()[0]
    for time in (0, 10):
        move.Set((0.1 * time, 0, 10), float(time))
    stage.SetTimeCodesPerSecond(20)
    frame = make_frame(stage, (64, 48), index=12)
    seen = frame.aovs["instance"] >= 0
    disparity = -0.4 * frame.camera.fx / frame.aovs["distance_to_image_plane"][seen]
    np.testing.assert_allclose(compute(frame, "cross_correspondence")[seen, 0] * 64, disparity, atol=1e-4)


def test_points_outside_the_other_picture_are_marked(stage):
    place(stage.GetPrimAtPath("/World/Right"), translate=(3, 0, 10))
    frame = make_frame(stage, (64, 48))
    out = compute(frame, "cross_correspondence")
    seen = frame.aovs["instance"] >= 0
    columns = np.nonzero(seen)[1] + 0.5 + out[seen, 0] * 64
    np.testing.assert_array_equal(out[seen, 2] == 1, (columns < 0) | (columns >= 64))
    assert 0 < out[seen, 2].mean() < 1


def test_positions_are_fractions_of_their_own_picture(stage):
    render_products.reset()
    render_products.add(render_products.HydraTexture("/Render/Right", "/World/Right", (160, 40)))
    frame = make_frame(stage, (64, 48))
    seen = frame.aovs["instance"] >= 0
    # Both cameras look straight down from 10 m; the other one is 0.6 m to the right, and both span 20.955 : 24.
    points, focal = frame.aovs["position"][seen].astype(float), 24.0 / 20.955
    across = (points[:, :2] - [[0.6, 0.0]]) / (10 - points[:, 2:]) * focal
    there = 0.5 + across * (1, -160 / 40)
    rows, columns = np.nonzero(seen)
    here = np.stack([(columns + 0.5) / 64, (rows + 0.5) / 48], axis=1)
    out = compute(frame, "cross_correspondence")[seen]
    np.testing.assert_allclose(out[:, :2], there - here, atol=1e-5)
    np.testing.assert_array_equal(out[:, 2] == 0, ((there >= 0) & (there < 1)).all(axis=1))
    assert 0 < out[:, 2].mean() < 1


def test_an_orthographic_reference_sees_what_is_behind_it(stage):
    right = UsdGeom.Camera(stage.GetPrimAtPath("/World/Right"))
    right.CreateProjectionAttr("orthographic")
    right.CreateHorizontalApertureAttr(80.0)
    right.CreateClippingRangeAttr((-20.0, 20.0))
    place(right.GetPrim(), translate=(0, 0, -10))
    out = compute(frame := make_frame(stage, (64, 48)), "cross_correspondence")
    seen = frame.aovs["instance"] >= 0
    across = 0.5 + frame.aovs["position"][seen][:, 0] / 8
    np.testing.assert_allclose(out[seen, 0], across - (np.nonzero(seen)[1] + 0.5) / 64, atol=1e-5)
    assert not out[seen, 2].any()


@pytest.mark.parametrize("order", [1, -1])
def test_the_other_camera_of_the_own_pair_is_meant(stage, order):
    """Two pairs whose cameras are called alike, as those that `create.stereo_camera` makes with count=2."""
    render_products.reset()
    for pair, shift in (("A", 0.2), ("B", 0.9))[::order]:
        for side, offset in (("L", 0.0), ("R", shift)):
            path = f"/World/{pair}/{side}_Xform/{side}"
            camera = UsdGeom.Camera.Define(stage, path)
            for name in ("focalLength", "horizontalAperture", "clippingRange"):
                camera.GetPrim().GetAttribute(name).Set(stage.GetPrimAtPath(CAMERA).GetAttribute(name).Get())
            place(camera.GetPrim(), translate=(offset, 0, 10))
            other = "R" if side == "L" else "L"
            camera.GetPrim().CreateAttribute("crossCameraReferenceName", Sdf.ValueTypeNames.String).Set(other)
            render_products.add(render_products.HydraTexture(f"/Render/{pair}{side}", path, (64, 48)))
    for pair, shift in (("A", 0.2), ("B", 0.9)):
        frame = make_frame(stage, (64, 48), camera=f"/World/{pair}/L_Xform/L")
        seen = frame.aovs["instance"] >= 0
        disparity = -shift * frame.camera.fx / frame.aovs["distance_to_image_plane"][seen]
        np.testing.assert_allclose(compute(frame, "cross_correspondence")[seen, 0] * 64, disparity, atol=1e-4)


def test_cameras_of_one_name_that_are_equally_near_are_told(stage, recwarn):
    for name in ("One", "Two"):
        other = UsdGeom.Camera.Define(stage, f"/World/{name}/Same")
        place(other.GetPrim(), translate=(1, 0, 10))
        render_products.add(render_products.HydraTexture(f"/Render/{name}", f"/World/{name}/Same", (64, 48)))
    reference = stage.GetPrimAtPath(CAMERA).GetAttribute("crossCameraReferenceName")
    reference.Set("/World/Two/Same")
    compute(make_frame(stage, (8, 6)), "cross_correspondence")
    assert not [each for each in recwarn if "Same" in str(each.message)]
    reference.Set("Same")
    compute(make_frame(stage, (8, 6)), "cross_correspondence")
    assert any("/World/One/Same and /World/Two/Same" in str(each.message) for each in recwarn)


def test_a_reference_that_is_not_there_is_told(stage):
    frame = make_frame(stage, (8, 6), camera="/World/Right")
    with pytest.raises(AnnotatorError, match="/World/Right has no crossCameraReferenceName"):
        annotators.get("cross_correspondence").compute(frame)
    stage.GetPrimAtPath(CAMERA).GetAttribute("crossCameraReferenceName").Set("Wrong")
    with pytest.raises(AnnotatorError, match=r"is 'Wrong', and no render product .* others have: /World/Right"):
        annotators.get("cross_correspondence").compute(make_frame(stage, (8, 6)))
