"""Omni-directional stereo against a search for the head direction, and the attributes that select the eye."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom
from scipy.optimize import brentq

from usdsdg.errors import Unsupported, UsdsdgWarning, forget_warnings
from usdsdg.stage.cameras.camera_view import CameraView, read_camera
from usdsdg.stage.cameras.lens_attributes import LensParameters

SIZE = (960, 480)


def view(*, left: bool, distance: float = 0.5, meters_per_unit: float = 1.0) -> CameraView:
    return CameraView("/cam", *SIZE, np.eye(4), projection_type="omniDirectionalStereo",
                      lens_parameters=LensParameters(eye_distance=distance, left_eye=left),
                      meters_per_unit=meters_per_unit)  # fmt: skip


def project_by_turning_the_head(point: np.ndarray, offset: float) -> tuple[float, float]:
    """Turn the head until the point is straight ahead of the eye, `offset` to its right; return column and row."""

    def miss(turn: float) -> float:
        right, ahead = np.array([np.cos(turn), 0, np.sin(turn)]), np.array([np.sin(turn), 0, -np.cos(turn)])
        toward = point - offset * right
        return float(toward @ right) if toward @ ahead > 0 else float(np.sign(toward @ right) * 1e3)

    turns = np.linspace(-np.pi, np.pi, 721)
    values = np.array([miss(turn) for turn in turns])
    crossings = np.flatnonzero((values[:-1] > 0) & (values[1:] <= 0) & (np.abs(values[:-1] - values[1:]) < 100))
    turn = brentq(miss, turns[crossings[0]], turns[crossings[0] + 1], xtol=1e-14)
    eye = offset * np.array([np.cos(turn), 0, np.sin(turn)])
    up = np.arctan2(point[1], np.linalg.norm((point - eye)[[0, 2]]))
    return (turn / (2 * np.pi) + 0.5) * SIZE[0], (0.5 - up / np.pi) * SIZE[1]


@pytest.mark.parametrize("left", [True, False])
def test_a_point_is_projected_to_the_column_whose_eye_looks_straight_at_it(left):
    points = np.random.default_rng(3).normal(size=(60, 3)) * 2.0
    points = points[np.hypot(points[:, 0], points[:, 2]) > 0.4]
    expected = [project_by_turning_the_head(point, -0.25 if left else 0.25) for point in points]
    np.testing.assert_allclose(view(left=left).project(points)[0], expected, atol=1e-6)


def test_the_left_eye_sees_near_points_farther_right():
    ahead = np.array([(0.0, 0.0, -1.0), (0.0, 0.0, -100.0)])
    left, right = (view(left=left).project(ahead)[0][:, 0] for left in (True, False))
    np.testing.assert_allclose((left - right) / SIZE[0] * 2 * np.pi, 2 * np.arcsin(0.25 / np.array([1.0, 100.0])))


def test_points_inside_of_the_circle_of_eye_positions_are_not_seen():
    inside, outside = view(left=True).project(np.array([(0.1, 3.0, 0.2), (0.2, 3.0, 0.2)]))[0]
    assert np.isnan(inside).all()
    assert np.isfinite(outside).all()


def test_eye_offsets_in_centimeters():
    camera = view(left=False, distance=0.064, meters_per_unit=0.01)
    origins, directions = camera.rays(np.array([(480.0, 240.0), (720.0, 240.0)]))
    np.testing.assert_allclose(origins, [(3.2, 0, 0), (0, 0, 3.2)], atol=1e-12)
    np.testing.assert_allclose(directions, [(0, 0, -1), (1, 0, 0)], atol=1e-12)


def test_attributes_select_the_eye():
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    camera = UsdGeom.Camera.Define(stage, "/cam")
    prim = camera.GetPrim()
    prim.CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token).Set("omniDirectionalStereo")

    def eye() -> float:
        lens = read_camera(stage, "/cam", SIZE).lens
        assert lens is not None
        return lens.eye_offset

    assert eye() == pytest.approx(3.2)
    camera.CreateStereoRoleAttr("left")
    assert eye() == pytest.approx(-3.2)
    prim.CreateAttribute("isLeftEye", Sdf.ValueTypeNames.Bool).Set(False)
    prim.CreateAttribute("interpupillaryDistance", Sdf.ValueTypeNames.Float).Set(7.0)
    assert eye() == pytest.approx(3.5)
    prim.GetAttribute("cameraProjectionType").Set("pinhole")
    prim.CreateAttribute("omni:lensdistortion:model", Sdf.ValueTypeNames.Token).Set("omniDirectionalStereo")
    assert eye() == pytest.approx(3.5)
    forget_warnings()
    prim.CreateAttribute("omni:lensdistortion:omniDirectionalStereo:ipd", Sdf.ValueTypeNames.Float).Set(1.0)
    with pytest.warns(UsdsdgWarning, match="/cam: omni:lensdistortion:omniDirectionalStereo:ipd are ignored"):
        assert eye() == pytest.approx(3.5)
    prim.GetAttribute("interpupillaryDistance").Set(float("nan"))
    with pytest.raises(Unsupported, match=r"/cam: .*interpupillaryDistance is not a number"):
        eye()
