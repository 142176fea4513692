"""Contact reports, against what bodies weigh and what an impact takes from them."""

import numpy as np
import pytest
from pxr import Gf, UsdPhysics

from tests.physics.scenes import add, new_stage, physics_material, playing
from usdsdg.stage.schemas import physx

STEP = 1 / 60
MASS = 2.0


def _reported(prim, threshold=0.0):
    physx.PhysxContactReportAPI.Apply(prim).CreateThresholdAttr(threshold)
    return prim


def _resting(*, meters=1.0):
    """A box of 2 kg on the ground."""
    stage = new_stage(meters_per_unit=meters)
    size = 0.1 / meters
    material = physics_material(stage, "/World/m")
    add(stage, "/World/ground", at=(0, 0, -size), scale=(5 / meters, 5 / meters, size), body=False)
    box = add(stage, "/World/box", at=(0, 0, size), scale=(size, size, size), material=material)
    UsdPhysics.MassAPI.Apply(box).CreateMassAttr(MASS)
    return stage, _reported(box)


@pytest.mark.parametrize("meters", [1.0, 0.01])
def test_the_impulses_of_a_box_at_rest_carry_its_weight(meters):
    stage, _ = _resting(meters=meters)
    engine = playing(stage)
    engine.advance(1.0)
    (event,) = engine.contacts
    assert (event.kind, event.body0, event.collider1) == ("persist", "/World/box", "/World/ground")
    assert (event.material0, event.material1) == ("/World/m", "")
    impulse = np.sum([point.impulse for point in event.points], axis=0)
    assert impulse == pytest.approx([0, 0, MASS * 9.81 / meters * STEP], rel=0.03, abs=1e-3 / meters)
    assert len(event.points) == 4
    for point in event.points:
        assert point.normal == pytest.approx((0, 0, 1), abs=1e-4)
        assert np.abs(point.position) == pytest.approx([0.1 / meters, 0.1 / meters, 0], abs=2e-3 / meters)
        assert point.separation == pytest.approx(0.0, abs=2e-3 / meters)


def test_contacts_are_found_persist_and_are_lost():
    stage, box = _resting()
    box.GetAttribute("xformOp:translate").Set(Gf.Vec3d(0, 0, 0.2))
    engine, kinds = playing(stage), []
    engine.subscribe_contacts(lambda events: kinds.extend(event.kind for event in events))
    engine.advance(0.5)
    assert kinds[0] == "found"
    assert set(kinds[1:]) == {"persist"}
    kinds.clear()
    box.GetAttribute("xformOp:translate").Set(Gf.Vec3d(0, 0, 1))
    engine.advance(2 * STEP)
    assert kinds == ["lost"]


def test_an_impact_gives_the_momentum_that_it_takes():
    stage, box = _resting()
    box.GetAttribute("xformOp:translate").Set(Gf.Vec3d(0, 0, 0.5))
    UsdPhysics.RigidBodyAPI(box).CreateVelocityAttr(Gf.Vec3f(0, 0, -3))
    engine, impulses = playing(stage), []
    engine.subscribe_contacts(
        lambda events: impulses.extend(point.impulse[2] for event in events for point in event.points)
    )
    engine.advance(0.5)
    # Over half a second the ground gives the speed and what gravity adds.
    assert sum(impulses) == pytest.approx(MASS * (3 + 9.81 * 0.5), rel=0.02)


def test_a_threshold_leaves_light_contacts_out():
    for threshold, reported in ((10.0, True), (30.0, False)):
        stage, box = _resting()
        _reported(box, threshold)
        engine = playing(stage)
        engine.advance(1.0)
        assert bool(engine.contacts) == reported


def test_a_report_names_partners_only():
    stage, box = _resting()
    add(stage, "/World/top", at=(0, 0, 0.3))
    report = physx.PhysxContactReportAPI(box)
    report.CreateReportPairsRel().AddTarget("/World/top")
    engine = playing(stage)
    engine.advance(1.0)
    assert [(event.collider0, event.collider1) for event in engine.contacts] == [("/World/box", "/World/top")]


def test_reports_change_no_bit_of_the_motion():
    poses = []
    for reports in (False, True):
        stage, box = _resting()
        box.GetAttribute("xformOp:translate").Set(Gf.Vec3d(0, 0, 0.4))
        for index in range(3):
            add(
                stage,
                f"/World/b{index}",
                at=(0.05 * index, 0.02 * index, 0.7 + 0.3 * index),
                rotate=(20 * index, 10, 0),
            )
        if not reports:
            box.RemoveAppliedSchema("PhysxContactReportAPI")
        engine = playing(stage)
        engine.advance(1.0)
        poses.append(engine._session.poses)
    assert np.array_equal(*poses)


def test_contacts_of_the_last_body_are_lost_once_when_it_is_removed():
    stage = new_stage()
    add(stage, "/World/floor", at=(0, 0, -0.5), scale=(5, 5, 0.5), body=False)
    _reported(add(stage, "/World/box", at=(0, 0, 0.1)))
    engine, kinds = playing(stage), []
    engine.subscribe_contacts(lambda events: kinds.extend(event.kind for event in events))
    engine.advance(3 / 60)
    assert kinds == ["found", "persist", "persist"]
    stage.RemovePrim("/World/box")
    engine.advance(3 / 60)
    assert kinds[3:] == ["lost"]
    assert engine.contacts == []
