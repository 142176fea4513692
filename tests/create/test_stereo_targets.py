"""Stereo pairs as the camera of `rep.modify.pose_camera_relative`."""

import numpy as np

import usdsdg as rep
from usdsdg.graph import evaluate


def test_positions_are_relative_to_the_left_camera_of_a_pair(stage):
    rep.settings.set_stage_up_axis("Y")
    pair, cube = rep.create.stereo_camera(stereo_baseline=0.2), rep.create.cube()
    products = rep.create.render_product(pair, (64, 32))
    for shown in (products[0], products):
        with cube:
            rep.modify.pose_camera_relative(pair, shown, distance=100)
        evaluate.graph().evaluate()
        placed = stage.GetPrimAtPath(cube.prims[0]).GetAttribute("xformOp:translate").Get()
        np.testing.assert_allclose(placed, (-0.1, 0, -100), atol=1e-6)
