"""Contacts and triggers of `omni.physx` and `omni.physics.core`, as scripts subscribe to them."""

from __future__ import annotations

import pytest
from pxr import Gf, UsdGeom, UsdPhysics

from usdsdg.compat.omni.physics import core
from usdsdg.compat.omni.physx import get_physx_interface, get_physx_simulation_interface
from usdsdg.compat.omni.physx.bindings._physx import ContactEventType, TriggerEventType
from usdsdg.compat.physics_schema_tools import intToSdfPath, sdfPathToInt
from usdsdg.session import stage_context
from usdsdg.stage.schemas import physx

STEP = 1 / 60


@pytest.fixture
def stage():
    """A box of 2 kg that rests on the ground inside a trigger."""
    stage = stage_context.new_stage()
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    for path, z, half in (("/ground", -1.0, 1.0), ("/box", 0.1, 0.1), ("/gate", 0.5, 0.5)):
        cube = UsdGeom.Cube.Define(stage, path)
        cube.CreateSizeAttr(2 * half)
        cube.AddTranslateOp().Set(Gf.Vec3d(0, 0, z))
        UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
    box = stage.GetPrimAtPath("/box")
    UsdPhysics.RigidBodyAPI.Apply(box)
    UsdPhysics.MassAPI.Apply(box).CreateMassAttr(2.0)
    physx.PhysxContactReportAPI.Apply(box).CreateThresholdAttr(0)
    physx.PhysxTriggerAPI.Apply(stage.GetPrimAtPath("/gate"))
    yield stage
    get_physx_interface().reset_simulation()


def _simulate(steps):
    for _ in range(steps):
        get_physx_simulation_interface().simulate(STEP, 0.0)


def test_contact_events_name_their_colliders_and_carry_impulses(stage):
    heard = []
    held = get_physx_simulation_interface().subscribe_contact_report_events(lambda *event: heard.append(event))
    _simulate(30)
    assert [headers[0].type for headers, _ in heard[:2]] == [
        ContactEventType.CONTACT_FOUND,
        ContactEventType.CONTACT_PERSIST,
    ]
    headers, points = heard[-1]
    (header,) = headers
    assert header.stage_id == stage_context.stage_id()
    assert str(intToSdfPath(header.actor0)) == str(intToSdfPath(header.collider0)) == "/box"
    assert str(intToSdfPath(header.collider1)) == "/ground"
    own = points[header.contact_data_offset : header.contact_data_offset + header.num_contact_data]
    assert sum(point.impulse.z for point in own) == pytest.approx(2.0 * 9.81 * STEP, rel=0.03)
    assert own[0].normal.z == pytest.approx(1.0)
    report = get_physx_simulation_interface().get_full_contact_report()
    assert (list(report[0]), list(report[1]), list(report[2])) == (list(headers), list(points), [])
    held.unsubscribe()
    count = len(heard)
    _simulate(1)
    assert len(heard) == count


def test_contacts_without_a_material_print_nothing(stage, capfd):
    _simulate(1)
    capfd.readouterr()
    heard = []
    held = get_physx_simulation_interface().subscribe_contact_report_events(lambda *event: heard.append(event))
    _simulate(2)
    held.unsubscribe()
    assert {(point.material0, point.material1) for _, points in heard for point in points} == {(0, 0)}
    assert capfd.readouterr().err == ""


def test_contact_events_of_isaac_sim_6_have_friction_anchors(stage):
    heard = []
    held = core.get_physics_simulation_interface().subscribe_physics_contact_report_events(
        lambda headers, points, anchors: heard.append((len(headers), len(points), len(anchors)))
    )
    _simulate(2)
    assert heard == [(1, 4, 0)] * 2
    del held


def test_trigger_events(stage):
    simulation, heard, others = get_physx_simulation_interface(), [], []
    number = simulation.subscribe_physics_trigger_report_events(heard.append, prim_id=sdfPathToInt("/gate"))
    elsewhere = simulation.subscribe_physics_trigger_report_events(others.append, 0, sdfPathToInt("/other"))
    _simulate(2)
    stage.GetPrimAtPath("/box").GetAttribute("xformOp:translate").Set(Gf.Vec3d(9, 0, 0.1))
    _simulate(1)
    assert [event.event_type for event in heard] == [
        TriggerEventType.TRIGGER_ON_ENTER,
        TriggerEventType.TRIGGER_ON_LEAVE,
    ]
    assert str(intToSdfPath(heard[0].trigger_collider_prim_id)) == "/gate"
    assert str(intToSdfPath(heard[0].other_body_prim_id)) == "/box"
    assert heard[0].subscription_id == number
    for each in (number, elsewhere):
        simulation.unsubscribe_physics_trigger_report_events(each)
    stage.GetPrimAtPath("/box").GetAttribute("xformOp:translate").Set(Gf.Vec3d(0, 0, 0.1))
    _simulate(1)
    assert (len(heard), others) == (2, [])


def test_a_function_that_is_subscribed_again_is_heard(stage):
    heard = []
    subscription = get_physx_interface().subscribe_physics_step_events(heard.append)
    subscription.unsubscribe()
    # The object of the first subscription is gone now, and had ended before.
    subscription = get_physx_interface().subscribe_physics_step_events(heard.append)
    _simulate(2)
    assert len(heard) == 2
    subscription.unsubscribe()
    _simulate(1)
    assert len(heard) == 2


@pytest.mark.parametrize("before", [False, True])
def test_listeners_of_steps_are_called_by_their_order(stage, before):
    heard = []
    held = [
        get_physx_interface().subscribe_physics_on_step_events(
            lambda _dt, order=order: heard.append(order), pre_step=before, order=order
        )
        for order in (2, 0, 1)
    ]
    held.append(
        core.get_physics_simulation_interface().subscribe_physics_on_step_events(
            pre_step=before, order=-1, on_update=lambda _dt, _context: heard.append(-1)
        )
    )
    _simulate(1)
    for each in held:
        each.unsubscribe()
    assert heard == [-1, 0, 1, 2]


def test_a_listener_may_end_the_ones_after_it(stage):
    heard = []
    held = {}

    def first(_dt):
        heard.append("first")
        held["second"].unsubscribe()

    held["first"] = get_physx_interface().subscribe_physics_step_events(first)
    held["second"] = get_physx_interface().subscribe_physics_step_events(lambda _dt: heard.append("second"))
    held["third"] = get_physx_interface().subscribe_physics_step_events(lambda _dt: heard.append("third"))
    _simulate(2)
    for each in held.values():
        each.unsubscribe()
    assert heard == ["first", "third"] * 2


def test_simulating_without_the_timeline_says_so(stage):
    assert not get_physx_interface().is_running()
    get_physx_simulation_interface().simulate(elapsed_time=STEP, current_time=0.0)
    assert get_physx_simulation_interface().check_results()
    assert get_physx_interface().is_running()
    get_physx_interface().reset_simulation()
    assert not get_physx_interface().is_running()
