"""Bodies that are put to sleep are held until something wakes them."""

import numpy as np
import pytest
from pxr import Gf, UsdPhysics

from tests.physics.scenes import add, new_stage, playing, position, set_value, velocity
from usdsdg.errors import PhysicsError
from usdsdg_physics import NewtonEngine

DT = 1 / 60


@pytest.fixture
def stage():
    return new_stage()


def advance(engine, steps):
    for _ in range(steps):
        engine.advance(DT)


def asleep(engine):
    return engine._session.world.asleep()


def floating(stage, name, x, *, speed=0.0):
    """A cube of 0.2 m without gravity, with a velocity along x."""
    prim = add(stage, f"/World/{name}", at=(x, 0, 5), gravity=False)
    UsdPhysics.RigidBodyAPI(prim).CreateVelocityAttr(Gf.Vec3f(speed, 0, 0))
    return prim


def test_a_sleeping_body_neither_falls_nor_moves_on(stage):
    box = add(stage, "/World/box", at=(0, 0, 5))
    UsdPhysics.RigidBodyAPI(box).CreateVelocityAttr(Gf.Vec3f(2, 0, 0))
    engine = playing(stage)
    advance(engine, 6)
    there = position(box)
    engine.put_to_sleep(["/World/box"])
    assert (velocity(box) == 0).all()
    advance(engine, 60)
    assert (position(box) == there).all()


def test_an_impact_wakes_and_passes_its_momentum_on(stage):
    floating(stage, "sleeper", 0.0)
    floating(stage, "bullet", -1.0, speed=4.0)
    engine = playing(stage)
    engine.put_to_sleep(["/World/sleeper"])
    advance(engine, 40)
    speeds = [velocity(stage.GetPrimAtPath(f"/World/{name}"))[0] for name in ("sleeper", "bullet")]
    assert asleep(engine) == []
    # Equal masses without restitution share the momentum.
    assert speeds == pytest.approx([2.0, 2.0], abs=0.05)


def test_a_pile_of_sleeping_bodies_wakes_as_a_whole(stage):
    names = ["a", "b", "c"]
    for index, name in enumerate(names):
        floating(stage, name, 0.2 * index)
    floating(stage, "bullet", -1.0, speed=8.0)
    engine = playing(stage)
    engine.put_to_sleep([f"/World/{name}" for name in names])
    advance(engine, 40)
    speeds = [velocity(stage.GetPrimAtPath(f"/World/{name}"))[0] for name in (*names, "bullet")]
    assert asleep(engine) == []
    assert sum(speeds) == pytest.approx(8.0, rel=0.02)
    assert min(speeds) > 1.0


def test_bodies_that_pass_by_or_lie_still_wake_no_body(stage):
    floating(stage, "sleeper", 0.0)
    floating(stage, "still", 0.2)
    floating(stage, "far", -5.0, speed=1.0)
    passing = floating(stage, "passing", -1.0, speed=4.0)
    passing.GetAttribute("xformOp:translate").Set(Gf.Vec3d(-1, 0, 5.25))
    engine = playing(stage)
    engine.put_to_sleep(["/World/sleeper"])
    advance(engine, 40)
    assert position(passing)[0] > 1.0
    assert asleep(engine) == ["/World/sleeper"]
    assert (position(stage.GetPrimAtPath("/World/sleeper")) == (0, 0, 5)).all()


def test_a_kinematic_body_wakes_when_it_comes_and_cannot_sleep(stage):
    floating(stage, "sleeper", 0.0)
    pusher = add(stage, "/World/pusher", at=(-0.5, 0, 5))
    UsdPhysics.RigidBodyAPI(pusher).CreateKinematicEnabledAttr(True)
    engine = playing(stage)
    engine.put_to_sleep(["/World/sleeper", "/World/pusher", "/World/nobody"])
    assert asleep(engine) == ["/World/sleeper"]
    for step in range(1, 31):
        set_value(pusher, "xformOp:translate", Gf.Vec3d(-0.5 + step * 0.02, 0, 5))
        advance(engine, 1)
    assert asleep(engine) == []
    assert position(stage.GetPrimAtPath("/World/sleeper"))[0] > 0.25


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("physics:velocity", Gf.Vec3f(0, 0, 1)),
        ("xformOp:translate", Gf.Vec3d(0, 0, 9)),
        ("physxRigidBody:disableGravity", False),
    ],
)
def test_setting_its_velocity_pose_or_gravity_wakes_it(stage, name, value):
    box = floating(stage, "box", 0.0)
    UsdPhysics.RigidBodyAPI(box).CreateVelocityAttr(Gf.Vec3f(0, 0, 0))
    engine = playing(stage)
    engine.put_to_sleep(["/World/box"])
    advance(engine, 5)
    set_value(box, name, value)
    advance(engine, 1)
    assert asleep(engine) == []


def test_sleep_outlives_changes_elsewhere(stage):
    box = add(stage, "/World/box", at=(0, 0, 5))
    engine = playing(stage)
    engine.put_to_sleep(["/World/box"])
    add(stage, "/World/new", at=(3, 0, 5))
    set_value(stage.GetPrimAtPath("/PhysicsScene"), "physics:gravityMagnitude", 3.0)
    advance(engine, 20)
    assert set(engine.rigid_bodies) == {"/World/box", "/World/new"}
    assert (position(box) == (0, 0, 5)).all()
    assert position(stage.GetPrimAtPath("/World/new"))[2] < 4.9


def test_starts_asleep_counts_when_the_simulation_begins(stage):
    box = add(stage, "/World/box", at=(0, 0, 5))
    UsdPhysics.RigidBodyAPI(box).CreateStartsAsleepAttr(True)
    UsdPhysics.RigidBodyAPI(box).CreateVelocityAttr(Gf.Vec3f(3, 0, 0))
    engine = playing(stage)
    advance(engine, 10)
    assert (position(box) == (0, 0, 5)).all()
    engine.wake_up(["/World/box"])
    # Building anew because of another prim does not let it sleep again.
    add(stage, "/World/new", at=(3, 0, 5))
    advance(engine, 10)
    assert position(box)[2] < 5
    engine.stop()
    assert tuple(velocity(box)) == (3, 0, 0)


def test_reset_wakes_and_repeats_the_fall(stage):
    box = add(stage, "/World/box", at=(0, 0, 5))
    engine = playing(stage)
    advance(engine, 12)
    fallen = position(box)[2]
    engine.put_to_sleep(["/World/box"])
    engine.reset(["/World/box"])
    assert tuple(position(box)) == (0, 0, 5)
    advance(engine, 12)
    assert position(box)[2] == pytest.approx(fallen, abs=1e-5)


def test_reset_of_one_body_repeats_also_where_its_ops_were_made_for_it(stage):
    box = stage.DefinePrim("/World/bare", "Cube")
    UsdPhysics.CollisionAPI.Apply(box)
    UsdPhysics.RigidBodyAPI.Apply(box)
    before = stage.GetRootLayer().ExportToString()
    engine = playing(stage)
    heights = []
    for _ in range(2):
        for _ in range(10):
            engine.advance(DT)
            heights.append(position(box)[2])
        engine.reset(["/World/bare"])
        assert tuple(position(box)) == (0, 0, 0)
    assert heights[10:] == pytest.approx(heights[:10], abs=1e-5)
    engine.stop()
    assert stage.GetRootLayer().ExportToString() == before


def test_a_whole_reset_repeats_bit_for_bit(stage):
    boxes = [add(stage, f"/World/box_{i}", at=(0.05 * i, 0, 0.3 + 0.25 * i)) for i in range(4)]
    add(stage, "/World/floor", at=(0, 0, -0.1), scale=(2, 2, 0.1), body=False)
    engine = playing(stage)
    runs = []
    for _ in range(2):
        advance(engine, 40)
        runs.append(np.array([position(box) for box in boxes]))
        engine.reset()
    assert (runs[0] == runs[1]).all()


def test_sleep_needs_a_running_simulation(stage):
    engine = NewtonEngine(stage, device="cpu")
    for call in (engine.put_to_sleep, engine.wake_up):
        with pytest.raises(PhysicsError, match=f"call play\\(\\) before {call.__name__}"):
            call(["/World/box"])
    engine.reset()


def test_paths_that_are_no_bodies_are_ignored(stage):
    engine = playing(stage)
    engine.put_to_sleep(["/World/nobody"])
    engine.wake_up(["/World/nobody"])
    advance(engine, 1)
    assert engine.rigid_bodies == ()
