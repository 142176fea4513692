"""Triggers: nothing solid, and events at the steps at which things enter and leave.

In PhysX too (ovphysx 0.7.0) a body falls through one as if it were not there, with 9.81 m/s after a second.
"""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdPhysics

from tests.physics.scenes import add, fallen, make_body, mesh, new_stage, playing, position, warnings_of
from usdsdg.stage.schemas import physx

STEP = 1 / 60
CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
FACES = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4]]


def _trigger(stage, path="/World/gate", **options):
    prim = add(stage, path, body=options.pop("body", False), **options)
    physx.PhysxTriggerAPI.Apply(prim)
    return prim


def _run(engine, steps):
    """Events with the number of their step, as (step, enters, trigger, other)."""
    found, now = [], [0]
    unsubscribe = engine.subscribe_triggers(lambda e: found.append((now[0], e.entered, e.trigger, e.other)))
    for now[0] in range(1, steps + 1):
        engine.step(STEP)
    unsubscribe()
    return found


def test_a_box_falls_through_a_trigger_that_reports_it():
    """It enters with the first step after which it overlaps, and leaves with the first one after which it does not."""
    stage = new_stage()
    _trigger(stage, scale=(1, 1, 0.1))
    box = add(stage, "/World/box", at=(0, 0, 1))
    events = _run(playing(stage), 60)
    heights = [1.0 - fallen(n) for n in range(1, 61)]
    enters = next(n for n, z in enumerate(heights, 1) if z < 0.2)
    leaves = next(n for n, z in enumerate(heights, 1) if z < -0.2)
    assert events == [
        (enters, True, "/World/gate", "/World/box"),
        (leaves, False, "/World/gate", "/World/box"),
    ]
    assert position(box)[2] == pytest.approx(1 - fallen(60), abs=1e-3)


@pytest.mark.parametrize("kind", ["Sphere", "Capsule", "Cylinder", "Cone", "Mesh"])
def test_triggers_of_any_shape_report_what_is_inside_from_the_start(kind):
    stage = new_stage()
    if kind == "Mesh":
        prim = mesh(stage, "/World/gate", CORNERS, FACES).GetPrim()
        UsdPhysics.CollisionAPI.Apply(prim)
        physx.PhysxTriggerAPI.Apply(prim)
    else:
        _trigger(stage, kind=kind, scale=(1, 1, 1))
    add(stage, "/World/inside", at=(0, 0, -0.1), gravity=False)
    add(stage, "/World/outside", at=(1.2, 1.2, 0), gravity=False)
    assert _run(playing(stage), 2) == [(1, True, "/World/gate", "/World/inside")]


def test_a_trigger_on_a_body_moves_with_it_and_weighs_nothing():
    stage = new_stage()
    add(stage, "/World/wall", at=(1, 0, 0), body=False)
    car = UsdGeom.Xform.Define(stage, "/World/car").GetPrim()
    make_body(car, gravity=False)
    add(stage, "/World/car/hull", body=False)
    _trigger(stage, "/World/car/sensor", scale=(0.5, 0.1, 0.1))
    UsdPhysics.RigidBodyAPI(car).CreateVelocityAttr(Gf.Vec3f(1, 0, 0))
    # The sensor reaches 0.5 m, the wall begins at 0.9 m: after 0.4 m.
    engine = playing(stage)
    (event,) = _run(engine, 30)
    assert event[1:] == (True, "/World/car/sensor", "/World/wall")
    assert event[0] == pytest.approx(0.4 / STEP, abs=1.1)
    assert engine._session.world.mass == pytest.approx([1000 * 0.2**3])


def test_static_colliders_other_triggers_and_filtered_pairs_are_not_reported():
    stage = new_stage()
    gate = _trigger(stage, scale=(1, 1, 1))
    add(stage, "/World/table", body=False)
    _trigger(stage, "/World/other")
    box = add(stage, "/World/box", gravity=False)
    UsdPhysics.FilteredPairsAPI.Apply(box).CreateFilteredPairsRel().AddTarget(gate.GetPath())
    events = _run(playing(stage), 2)
    assert events == [(1, True, "/World/other", "/World/box")]


def test_switched_off_triggers_report_that_everything_left():
    stage = new_stage()
    gate = _trigger(stage)
    add(stage, "/World/box", gravity=False)
    engine = playing(stage)
    assert [event[1] for event in _run(engine, 1)] == [True]
    UsdPhysics.CollisionAPI(gate).CreateCollisionEnabledAttr(False)
    assert [event[1] for event in _run(engine, 1)] == [False]


def test_the_state_is_written_and_restored():
    stage = new_stage()
    gate = _trigger(stage)
    physx.PhysxTriggerStateAPI.Apply(gate)
    add(stage, "/World/box", gravity=False)
    engine = playing(stage)
    engine.step(STEP)
    inside = gate.GetRelationship("physxTrigger:triggeredCollisions")
    assert inside.GetTargets() == [Sdf.Path("/World/box")]
    stage.GetPrimAtPath("/World/box").GetAttribute("xformOp:translate").Set(Gf.Vec3d(9, 0, 0))
    engine.step(STEP)
    assert inside.GetTargets() == []
    engine.stop()
    assert not gate.GetRelationship("physxTrigger:triggeredCollisions").HasAuthoredTargets()


def test_the_last_body_leaves_when_it_is_removed():
    stage = new_stage()
    _trigger(stage, scale=(1, 1, 1))
    add(stage, "/World/box", gravity=False)
    engine = playing(stage)
    assert _run(engine, 2) == [(1, True, "/World/gate", "/World/box")]
    stage.RemovePrim("/World/box")
    assert _run(engine, 3) == [(1, False, "/World/gate", "/World/box")]


@pytest.mark.parametrize(
    ("kinematic", "trigger", "follows"),
    [
        (True, True, None),
        (True, False, "so nothing meets it"),
        (False, True, "so it falls through everything"),
        (False, False, "so it falls through everything"),
    ],
)
def test_a_moving_trigger_needs_no_other_collider_unless_it_falls(kinematic, trigger, follows):
    """A kinematic one was said to fall through everything."""
    stage = new_stage()
    prim = _trigger(stage, body=True) if trigger else stage.DefinePrim("/World/gate", "Xform")
    UsdPhysics.RigidBodyAPI.Apply(prim).CreateKinematicEnabledAttr(kinematic)
    told = warnings_of(stage)
    assert len(told) == (follows is not None)
    assert all(f"/World/gate has RigidBodyAPI but no collider below it, {follows}" in text for text in told)
