"""What rep.physics authors on the stage."""

import pytest
from pxr import UsdPhysics

from usdsdg import physics
from usdsdg.errors import BadPrim, GraphError
from usdsdg.graph import evaluate
from usdsdg.stage.context import new_stage


@pytest.fixture
def stage():
    evaluate.reset()
    stage = new_stage()
    UsdPhysics.Scene.Define(stage, "/World/Second")
    stage.DefinePrim("/World/box", "Cube")
    return stage


def owners(stage, api):
    return [str(path) for path in api(stage.GetPrimAtPath("/World/box")).GetSimulationOwnerRel().GetTargets()]


@pytest.mark.parametrize(
    ("author", "api"), [(physics.collider, UsdPhysics.CollisionAPI), (physics.rigid_body, UsdPhysics.RigidBodyAPI)]
)
def test_the_physics_scene_becomes_the_simulation_owner(stage, author, api):
    author(input_prims="/World/box")
    assert owners(stage, api) == []
    author(physics_scene="/World/Second", input_prims="/World/box")
    assert owners(stage, api) == ["/World/Second"]
    author(physics_scene=stage.GetPrimAtPath("/World/Second"), input_prims="/World/box")
    assert owners(stage, api) == ["/World/Second"]


def test_what_is_no_physics_scene_is_named(stage):
    with pytest.raises(GraphError, match="/World/box"):
        physics.collider(physics_scene="/World/box", input_prims="/World/box")
    with pytest.raises(BadPrim, match="/World/nowhere"):
        physics.rigid_body(physics_scene="/World/nowhere", input_prims="/World/box")
