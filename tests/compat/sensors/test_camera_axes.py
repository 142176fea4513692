"""Conventions of camera axes: what each calls ahead and up."""

import numpy as np
import pytest
from pxr import Gf

from usdsdg.compat.isaacsim.sensors.camera import camera_axes
from usdsdg.errors import ArgumentError

AHEAD = {"usd": (0, 0, -1), "ros": (0, 0, 1), "world": (1, 0, 0)}
UP = {"usd": (0, 1, 0), "ros": (0, -1, 0), "world": (0, 0, 1)}


def rotated(quaternion, vector):
    return np.array(Gf.Rotation(Gf.Quatd(*map(float, quaternion))).TransformDir(Gf.Vec3d(*vector)))


@pytest.mark.parametrize("axes", AHEAD)
def test_ahead_and_up_are_the_same_directions_in_all_conventions(axes):
    usd = Gf.Rotation((1, 2, 3), 70).GetQuat()
    given = (usd.GetReal(), *usd.GetImaginary())
    (turned,) = camera_axes.from_usd(given, axes)
    assert rotated(turned, AHEAD[axes]) == pytest.approx(rotated(given, AHEAD["usd"]))
    assert rotated(turned, UP[axes]) == pytest.approx(rotated(given, UP["usd"]))


@pytest.mark.parametrize("axes", AHEAD)
@pytest.mark.parametrize("left", [False, True])
def test_conversion_is_undone(axes, left):
    given = np.array([[0.1, 0.7, 0.5, 0.5]]) / np.linalg.norm([0.1, 0.7, 0.5, 0.5])
    back = camera_axes.to_usd(camera_axes.from_usd(given, axes, left=left), axes, left=left)
    assert back == pytest.approx(given)


def test_an_unknown_convention_is_refused():
    with pytest.raises(ArgumentError, match="ros, usd, world"):
        camera_axes.from_usd((1, 0, 0, 0), "opencv")
