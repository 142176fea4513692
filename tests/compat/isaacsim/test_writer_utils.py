"""`isaacsim.replicator.writers.scripts.utils`, of which copies of Isaac Sim's pose writers are made."""

import json

import numpy as np
import pytest

import usdsdg as rep
from usdsdg.compat.isaacsim.replicator import writer_utils
from usdsdg.errors import UsdsdgWarning


@pytest.mark.parametrize(
    "lens",
    [
        {},
        {"projection_type": "fisheyePolynomial", "fisheye_nominal_width": 64, "fisheye_nominal_height": 48,
         "fisheye_optical_centre_x": 32, "fisheye_optical_centre_y": 24, "fisheye_polynomial_b": 0.04},
    ],
)  # fmt: skip
def test_a_point_is_projected_to_the_pixel_that_shows_it(stage, lens):
    camera = rep.create.camera(position=(4, 0, 0), look_at=(0, 0, 0), **lens)
    rep.create.sphere(position=(0, 0.8, 0.5), scale=0.5, semantics=[("class", "dot")])
    product = rep.create.render_product(camera, (64, 48))
    params = rep.annotators.get("camera_params").attach(product)
    boxes = rep.annotators.get("bounding_box_2d_tight").attach(product)
    rep.orchestrator.step()
    payload, box = params.get_data(), boxes.get_data()["data"][0]
    in_camera = np.array([0, 0.8, 0.5, 1]) @ np.reshape(payload["cameraViewTransform"], (4, 4))
    column, row = writer_utils.project_point_to_screen(in_camera, payload)
    assert column == pytest.approx((box["x_min"] + box["x_max"] + 1) / 2, abs=1)
    assert row == pytest.approx((box["y_min"] + box["y_max"] + 1) / 2, abs=1)
    if not lens:
        assert writer_utils.project_pinhole(in_camera, payload) == (column, row)
        assert writer_utils.project_pinhole(np.zeros(4), payload) == (32, 24)


def test_the_radius_of_an_angle_is_found_or_said_to_be_inexact():
    curve = (0.0, 0.0025, 1e-7, 0.0, 0.0, 0.0)
    radius = writer_utils.invert_fisheye_polynomial(0.7, curve)
    assert np.polynomial.polynomial.polyval(radius, curve) == pytest.approx(0.7, abs=1e-9)
    assert writer_utils.invert_fisheye_polynomial(0.5, (0.1, 0.002, 0, 0, 0, 0)) == pytest.approx(200)
    with pytest.warns(UsdsdgWarning, match="no radius was found within 1 iterations"):
        writer_utils.invert_fisheye_polynomial(0.7, (0, 0.0025, 1e-5, 0, 0, 0), max_iterations=1)


def test_what_is_at_other_places_too_is_found_here():
    assert json.dumps({"a": np.eye(2)}, cls=writer_utils.NumpyEncoder) == '{"a": [[1.0, 0.0], [0.0, 1.0]]}'
    matrix = writer_utils.tf_matrix_from_pose((1, 2, 3), (1, 0, 0, 0))
    assert writer_utils.pose_from_tf_matrix(matrix)[0] == pytest.approx((1, 2, 3))
    points = writer_utils.get_image_space_points(np.array([[0.0, 0.0, -1.0]]), np.diag([1.0, 1.0, 1.0, 1.0]))
    assert points[0, :2] == pytest.approx((0.5, 0.5))
