"""Ops of rare types, in a rare order, or that are not there: they take poses or are left out, and are restored."""

from __future__ import annotations

import pytest
from pxr import Sdf, Usd

from tests.physics.scenes import add, fallen, new_stage, playing, position
from usdsdg.errors import UsdsdgWarning


def _body_of(ops: str, order: str) -> Usd.Stage:
    stage = new_stage()
    layer = Sdf.Layer.CreateAnonymous("body.usda")
    layer.ImportFromString(
        f"""#usda 1.0
        def Cube "body" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]) {{
            double size = 0.2
            {ops}
            uniform token[] xformOpOrder = [{order}]
        }}"""
    )
    stage.GetRootLayer().subLayerPaths.append(layer.identifier)
    stage.SetEditTarget(layer)
    return stage


@pytest.mark.parametrize(
    ("ops", "order"),
    [
        ("point3d xformOp:translate = (1, 2, 3)", '"xformOp:translate"'),
        ("frame4d xformOp:transform = ((1,0,0,0), (0,1,0,0), (0,0,1,0), (1,2,3,1))", '"xformOp:transform"'),
        (
            "quatf xformOp:orient = (1,0,0,0)\ndouble3 xformOp:translate = (1,2,3)",
            '"xformOp:orient", "xformOp:translate"',
        ),
        ("double3 xformOp:translate = (1, 2, 3)", '"xformOp:translate", "xformOp:orient"'),
        ('string xformOp:orient = "1"\ndouble3 xformOp:translate = (1,2,3)', '"xformOp:translate", "xformOp:orient"'),
    ],
    ids=["point3d", "frame4d", "orient_before_translate", "missing_op", "text_op"],
)
def test_odd_ops_take_poses_and_are_restored(ops, order):
    """As USD does, what has another type than its name says, or is not there, is left out."""
    stage = _body_of(ops, order)
    layer = stage.GetEditTarget().GetLayer()
    body, before = stage.GetPrimAtPath("/body"), layer.ExportToString()
    engine = playing(stage)
    for _ in range(3):
        engine.step(1 / 60)
    assert position(body) == pytest.approx([1, 2, 3 - fallen(3)], abs=1e-5)
    engine.stop()
    assert layer.ExportToString() == before


def test_a_body_whose_transform_is_a_text_is_named():
    stage = _body_of('string xformOp:translate = "1 2 3"', '"xformOp:translate"')
    ball = add(stage, "/World/ball", "Sphere")
    with pytest.warns(UsdsdgWarning, match="another type.*/body"):
        playing(stage).step(1 / 60)
    assert position(ball)[2] == pytest.approx(-fallen(1), abs=1e-5)
