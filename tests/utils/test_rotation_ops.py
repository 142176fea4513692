"""`rep.utils.look_at`, and the op of a prim that holds its rotation."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom

import usdsdg as rep
from usdsdg.errors import BadValue
from usdsdg.stage.poses.rotations import ROTATION_ORDERS

TURN = Gf.Rotation((1, 2, 3), 50)


def rotation_of(prim):
    return UsdGeom.Xformable(prim).GetLocalTransformation().ExtractRotation()


def between(one, other):
    angle = (one * other.GetInverse()).GetAngle()
    return min(angle, 360 - angle)


@pytest.mark.parametrize(
    ("eye", "target", "up"),
    [((0, 0, 0), (1, 2, 3), (0, 1, 0)), ((4, 5, 6), (-1, 0, 2), (0, 0, 1)), ((1, 1, 1), (2, 1, 0), (1, 5, 0))],
)
def test_a_rotation_towards_a_point_is_that_of_usd(eye, target, up):
    expected = Gf.Matrix4d().SetLookAt(Gf.Vec3d(eye), Gf.Vec3d(target), Gf.Vec3d(up)).GetInverse().ExtractRotation()
    assert between(rep.utils.look_at(target, up, eye), expected) < 1e-4


@pytest.mark.parametrize(("axis", "up", "right"), [("Y", (0, 1, 0), (1, 0, 0)), ("Z", (0, 0, 1), (0, 1, 0))])
@pytest.mark.parametrize("height", [-4, 4])
def test_a_view_straight_up_or_down_has_sides(axis, up, right, height):
    turn = rep.utils.look_at(np.multiply(up, height).tolist(), up, stage_up_axis=axis)
    np.testing.assert_allclose(turn.TransformDir(Gf.Vec3d(0, 0, -1)), np.multiply(up, np.sign(height)), atol=1e-6)
    np.testing.assert_allclose(turn.TransformDir(Gf.Vec3d(1, 0, 0)), right, atol=1e-6)


def test_a_direction_without_length_is_a_value_error():
    with pytest.raises(ValueError, match="look_at_up_axis has no length"):
        rep.utils.look_at((1, 0, 0), (0, 0, 0))
    with pytest.raises(ValueError, match="is the eye"):
        rep.utils.look_at((1, 0, 0), eye=(1, 0, 0))


@pytest.mark.parametrize("order", ROTATION_ORDERS)
def test_a_rotation_is_written_in_any_order_of_axes(stage, order):
    prim = stage.DefinePrim("/World/box", "Cube")
    UsdGeom.Xformable(prim).AddXformOp(getattr(UsdGeom.XformOp, f"TypeRotate{order}"))
    name = rep.utils.select_rotation_op(prim)
    assert name == f"xformOp:rotate{order}"
    rep.utils.set_rotation_by_op(prim, name, TURN)
    assert between(rotation_of(prim), TURN) < 1e-3


def test_a_rotation_is_written_as_quaternion_or_into_the_transform(stage):
    prim = stage.DefinePrim("/World/box", "Cube")
    UsdGeom.Xformable(prim).AddOrientOp()
    rep.utils.set_rotation_by_op(prim, rep.utils.select_rotation_op(prim), TURN)
    assert between(rotation_of(prim), TURN) < 1e-3
    other = stage.DefinePrim("/World/other", "Cube")
    matrix = Gf.Matrix4d().SetScale(2) * Gf.Matrix4d().SetTranslate(Gf.Vec3d(1, 2, 3))
    UsdGeom.Xformable(other).AddTransformOp().Set(matrix)
    assert rep.utils.select_rotation_op(other) == "xformOp:transform"
    rep.utils.set_rotation_by_op(other, "xformOp:transform", TURN)
    parts = Gf.Transform(UsdGeom.Xformable(other).GetLocalTransformation())
    assert between(parts.GetRotation(), TURN) < 1e-6
    np.testing.assert_allclose(parts.GetTranslation(), (1, 2, 3))
    np.testing.assert_allclose(parts.GetScale(), (2, 2, 2))


def test_a_missing_rotation_comes_before_the_scale_and_further_ones_go(stage):
    prim = stage.DefinePrim("/World/box", "Cube")
    xformable = UsdGeom.Xformable(prim)
    xformable.AddTranslateOp()
    xformable.AddScaleOp()
    assert rep.utils.select_rotation_op(prim) == "xformOp:rotateXYZ"
    assert list(prim.GetAttribute("xformOpOrder").Get()) == [
        "xformOp:translate", "xformOp:rotateXYZ", "xformOp:scale",
    ]  # fmt: skip
    xformable.AddOrientOp()
    assert rep.utils.select_rotation_op(prim) == "xformOp:rotateXYZ"
    assert "xformOp:orient" not in prim.GetAttribute("xformOpOrder").Get()
    xformable.AddRotateXOp()
    with pytest.raises(ValueError, match="'xformOp:rotateX' of /World/box holds no whole rotation"):
        rep.utils.set_rotation_by_op(prim, "xformOp:rotateX", TURN)
    wrong = stage.DefinePrim("/World/wrong", "Cube")
    wrong.CreateAttribute("xformOp:orient", Sdf.ValueTypeNames.Float)
    with pytest.raises(BadValue):
        rep.utils.set_rotation_by_op(wrong, "xformOp:orient", TURN)
