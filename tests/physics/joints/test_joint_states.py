"""States of joints that scripts set while physics plays show at once, also beside other edits."""

from __future__ import annotations

import pytest
from pxr import Sdf, UsdPhysics

from tests.physics.mechanisms import joint
from tests.physics.scenes import add, new_stage, playing, position


@pytest.mark.parametrize("beside", ["nothing", "a mass", "a new body"])
def test_an_angle_that_is_set_shows_before_the_next_step(beside):
    """A quarter turn about the vertical takes a body from x to y; beside another edit it took a step."""
    stage = new_stage()
    body = add(stage, "/World/body", at=(0.5, 0, 1), gravity=False)
    other = add(stage, "/World/other", at=(5, 0, 1))
    hinge = joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, "", "/World/body", (0, 0, 1), axis="Z").GetPrim()
    hinge.AddAppliedSchema("PhysicsJointStateAPI:angular")
    angle = hinge.CreateAttribute("state:angular:physics:position", Sdf.ValueTypeNames.Float)
    angle.Set(0.0)
    engine = playing(stage)
    engine.step(1 / 60)
    angle.Set(90.0)
    if beside == "a mass":
        UsdPhysics.MassAPI.Apply(other).CreateMassAttr(3.0)
    elif beside == "a new body":
        add(stage, "/World/new", at=(3, 3, 3))
    engine.read_edits()
    assert position(body) == pytest.approx([0, 0.5, 1], abs=1e-4)
    engine.step(1 / 60)
    assert position(body) == pytest.approx([0, 0.5, 1], abs=1e-4)
