"""What is caught between a floor and something much heavier comes out."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from pxr import Gf, Usd, UsdGeom

from tests.physics.scenes import add, collide, make_body, mesh, new_stage, playing, position


@pytest.mark.parametrize("side", [0.3, 0.6])
def test_a_plate_that_a_box_presses_into_the_floor_rises(side):
    """It is 36 mm thick and starts half in the floor, below an edge of a box of 27 or 108 kg that stands on the floor.

    After half a second it is at most 6 mm deep; its contacts alone would turn it from corner to corner, 28 mm deep.
    """
    stage = _floor()
    points = _add_plate(stage)
    add(stage, "/World/box", at=(-0.2, -0.1, 0.15), scale=(side / 2, side / 2, 0.15))
    engine = playing(stage)
    engine.advance(0.5)
    assert _lowest(stage, points) > -6e-3
    engine.advance(3.5)
    assert _lowest(stage, points) > -3e-3


def test_a_small_thing_lifts_one_that_is_ten_thousand_times_heavier():
    """A capsule of 10 mm radius, half in the floor, half in a box of 108 kg: neither would move by contacts alone."""
    stage = _floor()
    add(stage, "/World/box", at=(0, 0, 0.15), scale=(0.3, 0.3, 0.15))
    at, rotate = (0.25, 0, 0), (90, 10, 0)
    small = add(stage, "/World/small", "Capsule", at=at, rotate=rotate, scale=(0.02, 0.02, 0.02), gravity=False)
    box = stage.GetPrimAtPath("/World/box")
    heights: list[float] = []
    engine = playing(stage)
    engine.subscribe_step(lambda dt: heights.append(position(box)[2]))
    engine.advance(1.0)
    assert position(small)[2] > 5e-3
    # It is lifted by about as much as the capsule is thick, not thrown.
    assert 0.155 < max(heights) < 0.175


def _floor() -> Usd.Stage:
    stage = new_stage()
    add(stage, "/World/floor", at=(0, 0, -0.5), scale=(5, 5, 0.5), body=False)
    return stage


def _add_plate(stage: Usd.Stage, *, at=(0.0, 0.0, 0.0)) -> np.ndarray:
    """Add a plate of 30 x 18 x 3.6 cm whose domed faces are many small ones, and return its vertices."""
    x, y = (each.ravel() for each in np.meshgrid(np.linspace(-1, 1, 5), np.linspace(-1, 1, 5)))
    dome = 1.0 - 0.1 * (x * x + y * y)
    points = np.vstack([np.stack([x, y, dome], axis=1), np.stack([x, y, -dome], axis=1)]) * (0.15, 0.09, 0.018)
    hull = trimesh.convex.convex_hull(points)
    plate = mesh(stage, "/World/plate", hull.vertices, hull.faces)
    plate.AddTranslateOp().Set(Gf.Vec3d(*at))
    plate.AddRotateXYZOp().Set(Gf.Vec3f(4, 3, 0))
    collide(plate.GetPrim())
    make_body(plate.GetPrim())
    return hull.vertices


def _lowest(stage: Usd.Stage, points: np.ndarray) -> float:
    """Return the height of the lowest of the plate's vertices."""
    matrix = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(stage.GetPrimAtPath("/World/plate")))
    return float((points @ matrix[:3, :3] + matrix[3, :3])[:, 2].min())
