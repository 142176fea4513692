"""Bodies and colliders whose simulationOwner is no PhysicsScene are not simulated, as in PhysX, and named."""

from __future__ import annotations

import pytest
from pxr import Usd, UsdGeom, UsdPhysics

from tests.physics.mechanisms import joint
from tests.physics.scenes import add, fallen, new_stage, playing, position, warnings_of


def _own(prim: Usd.Prim, *owners: str) -> None:
    prim.CreateRelationship("physics:simulationOwner").SetTargets(list(owners))


@pytest.mark.parametrize("owner", ["/World/nothing", "/World/other"])
def test_a_body_of_no_scene_stays_and_is_named(owner):
    stage = new_stage()
    box = add(stage, "/World/box", at=(0, 0, 1))
    other = add(stage, "/World/other", at=(1, 0, 1))
    _own(box, owner)
    playing(stage).advance(0.5)
    assert position(box)[2] == 1.0
    assert position(other)[2] == pytest.approx(1.0 - fallen(30), abs=1e-3)
    (message,) = warnings_of(stage)
    assert "names no active PhysicsScene are not simulated: /World/box. Name the PhysicsScene" in message


def test_one_scene_among_the_owners_is_enough():
    stage = new_stage()
    box = add(stage, "/World/box", at=(0, 0, 1))
    _own(box, "/World/nothing", "/PhysicsScene")
    assert not warnings_of(stage)
    playing(stage).advance(0.5)
    assert position(box)[2] < 0.5


def test_colliders_of_no_scene_do_not_collide():
    """Those below a body have its scene; in PhysX, too, what is below one without a scene is no static collider."""
    stage = new_stage()
    floor = add(stage, "/World/floor", scale=(1, 1, 0.1), body=False)
    shelf = stage.DefinePrim("/World/shelf", "Xform")
    UsdPhysics.RigidBodyAPI.Apply(shelf)
    add(stage, "/World/shelf/board", at=(5, 0, 0), scale=(1, 1, 0.1), body=False)
    tray = stage.DefinePrim("/World/tray", "Xform")
    UsdPhysics.RigidBodyAPI.Apply(tray).CreateKinematicEnabledAttr(True)
    board = add(stage, "/World/tray/board", at=(10, 0, 0), scale=(1, 1, 0.1), body=False)
    boxes = [add(stage, f"/World/box{x}", at=(x, 0, 0.5)) for x in (0, 5, 10)]
    for prim in (floor, shelf, board):
        _own(prim, "/World/nothing")
    (message,) = warnings_of(stage)
    assert "not simulated: /World/floor, /World/shelf. " in message
    playing(stage).advance(1.0)
    assert [position(box)[2] < -3.0 for box in boxes] == [True, True, False]


def test_a_joint_to_a_body_of_no_scene_is_one_to_the_world():
    stage = new_stage()
    post = add(stage, "/World/post", at=(0, 0, 1))
    box = add(stage, "/World/box", at=(0, 0, 2))
    joint(stage, "/World/joint", UsdPhysics.FixedJoint, "/World/post", "/World/box", (0, 0, 1.5))
    _own(post, "/World/nothing")
    playing(stage).advance(0.5)
    assert position(box) == pytest.approx([0, 0, 2], abs=1e-4)


def test_an_owner_that_is_set_while_playing_counts():
    stage = new_stage()
    box = add(stage, "/World/box", at=(0, 0, 1))
    _own(box, "/World/nothing")
    engine = playing(stage)
    engine.advance(0.5)
    _own(box, "/PhysicsScene")
    engine.advance(0.5)
    assert position(box)[2] == pytest.approx(1.0 - fallen(30), abs=1e-3)


def test_instances_of_a_prototype_of_no_scene_stay_and_are_named():
    stage = new_stage()
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/many")
    _own(add(stage, "/World/many/box"), "/World/nothing")
    instancer.CreatePrototypesRel().SetTargets(["/World/many/box"])
    instancer.CreateProtoIndicesAttr([0])
    instancer.CreatePositionsAttr([(0, 0, 1)])
    (message,) = warnings_of(stage)
    assert "not simulated: /World/many/box. " in message
    playing(stage).advance(0.5)
    assert instancer.GetPositionsAttr().Get()[0][2] == 1.0
