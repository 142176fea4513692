"""Bodies that fixed joints hold, on what moves them and when they are let go, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import ArrayLike
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from tests.physics.mechanisms import joint, rod
from tests.physics.scenes import DEVICE, add, new_stage, playing, position, set_value, velocity
from tests.sampled_cases import crossed
from usdsdg.errors import UsdsdgWarning
from usdsdg_physics import NewtonEngine

G, STEP = 9.81, 1.0 / 60.0
V = np.array([1.2, 0.0, 0.0])
# Single precision of positions near 5 m that are 1/60 s apart.
ROUNDING = 1e-4


def said(recorded: pytest.WarningsRecorder) -> list[str]:
    """Return the warnings of ours: the interpreter may find files of other tests that were left open meanwhile."""
    return [str(each.message) for each in recorded if issubclass(each.category, UsdsdgWarning)]


def hand(stage: Usd.Stage, *, at=(0.0, 0.0, 5.0)) -> Usd.Prim:
    """A kinematic body."""
    prim = add(stage, "/World/hand", at=at, rotate=(0, 0, 0))
    UsdPhysics.RigidBodyAPI(prim).CreateKinematicEnabledAttr(True)
    return prim


def item(stage: Usd.Stage, name: str, at, *, mass: float = 1.0, **options) -> Usd.Prim:
    prim = add(stage, f"/World/{name}", at=at, **options)
    UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(mass)
    return prim


def weld(stage: Usd.Stage, name: str, body0: str, body1: str, at) -> UsdPhysics.Joint:
    first = f"/World/{body0}" if body0 else ""
    return joint(stage, f"/World/{name}", UsdPhysics.FixedJoint, first, f"/World/{body1}", at)


def move(
    prim: Usd.Prim, step: int, *, start: ArrayLike = (0.0, 0.0, 5.0), rate: ArrayLike = V, turn: float = 0.0
) -> None:
    """Put a body where it is after so many steps at `rate` [m/s], turning by `turn` degrees per second about z."""
    translate, rotate, _ = UsdGeom.Xformable(prim).GetOrderedXformOps()
    translate.Set(Gf.Vec3d(*(np.array(start) + np.array(rate) * step * STEP).tolist()))
    rotate.Set(Gf.Vec3f(0, 0, turn * step * STEP))


def spin(prim: Usd.Prim) -> np.ndarray:
    """Angular velocity [rad/s]."""
    return np.radians(prim.GetAttribute("physics:angularVelocity").Get())


def carried(stage: Usd.Stage, *, written: bool = True) -> tuple[NewtonEngine, Usd.Prim, Usd.Prim, UsdPhysics.Joint]:
    """A hand that holds an item 0.3 m below it, after a step at rest."""
    moved, held = hand(stage), item(stage, "item", (0, 0, 4.7))
    made = weld(stage, "weld", "hand", "item", (0, 0, 4.7))
    engine = NewtonEngine(stage, device=DEVICE, writes_velocities=lambda: written)
    engine.play()
    engine.step(STEP)
    return engine, moved, held, made


def test_what_is_welded_to_a_moving_hand_has_its_velocity_and_flies_on_when_let_go(recwarn):
    stage = new_stage()
    engine, moved, held, made = carried(stage)
    for step in range(1, 31):
        move(moved, step)
        engine.step(STEP)
        assert velocity(held) == pytest.approx(V, abs=ROUNDING)
        assert position(held) == pytest.approx(V * step * STEP + (0, 0, 4.7), abs=1e-6)
    assert engine.velocities(["/World/hand", "/World/item"])[:, :3] == pytest.approx(np.array([V, V]), abs=ROUNDING)
    made.CreateJointEnabledAttr(False)
    for step in range(1, 21):
        engine.step(STEP)
        assert velocity(held) == pytest.approx(V - (0, 0, G * step * STEP), abs=ROUNDING)
    assert position(held)[0] == pytest.approx(1.2 * 50 * STEP, abs=1e-4)
    engine.stop()
    assert position(held).tolist() == [0, 0, 4.7]
    assert said(recwarn) == []


@pytest.mark.parametrize(("how", "written"), crossed(["disabled", "removed", "deactivated"], [True, False]))
def test_however_a_weld_ends_in_the_middle_of_a_motion(how, written, recwarn):
    """The hand goes on in the step that lets go, by what reads the stage again."""
    stage = new_stage()
    engine, moved, held, made = carried(stage, written=written)
    for step in range(1, 11):
        move(moved, step)
        engine.step(STEP)
    if how == "disabled":
        made.CreateJointEnabledAttr(False)
    elif how == "removed":
        stage.RemovePrim(made.GetPath())
    else:
        made.GetPrim().SetActive(False)
    move(moved, 11)
    engine.step(STEP)
    expected = np.array([V, V - (0, 0, G * STEP)])
    assert engine.velocities(["/World/hand", "/World/item"])[:, :3] == pytest.approx(expected, abs=ROUNDING)
    assert position(held) == pytest.approx(V * 11 * STEP + (0, 0, 4.7 - G * STEP**2), abs=1e-5)
    assert said(recwarn) == []


def test_time_samples_that_move_a_hand_move_what_it_holds():
    stage = new_stage()
    stage.SetTimeCodesPerSecond(60)
    moved, held = hand(stage), item(stage, "item", (0, 0, 4.7))
    made = weld(stage, "weld", "hand", "item", (0, 0, 4.7))
    made.CreateBreakForceAttr(100.0)  # of which the first step, in which it gets its speed, takes 72
    translate = UsdGeom.Xformable(moved).GetOrderedXformOps()[0]
    for step in range(61):
        translate.Set(Gf.Vec3d(1.2 * step * STEP, 0, 5), step)
    engine = playing(stage)
    for until in (*range(1, 31), 0, *range(1, 31)):  # a loop that begins again in half a second
        engine.advance(STEP, until=until * STEP)
        assert position(held) == pytest.approx([1.2 * until * STEP, 0, 4.7], abs=1e-5)
        assert velocity(held) == pytest.approx(V if until else np.zeros(3), abs=ROUNDING)
    made.CreateJointEnabledAttr(False)
    engine.advance(STEP, until=31 * STEP)
    assert velocity(held) == pytest.approx(V - (0, 0, G * STEP), abs=ROUNDING)


def test_a_chain_of_welds_turns_with_the_hand():
    """v + ω × r of the first and of the second body, before and after they are let go together."""
    stage = new_stage()
    moved = hand(stage)
    first, second = item(stage, "first", (0.5, 0, 5.3)), item(stage, "second", (0.5, 0.4, 5.3), mass=2.0)
    made = weld(stage, "weld", "hand", "first", (0.2, 0, 5.2))
    weld(stage, "second_weld", "second", "first", (0.5, 0.2, 5.3))
    engine = playing(stage)
    engine.step(STEP)
    turning = np.array([0, 0, np.radians(120.0)])
    for step in range(1, 31):
        move(moved, step, turn=120.0)
        engine.step(STEP)
        for prim in (first, second):
            arm = position(prim) - position(moved)
            assert velocity(prim) == pytest.approx(V + np.cross(turning, arm), abs=5 * ROUNDING)
            assert spin(prim) == pytest.approx(turning, abs=5 * ROUNDING)
    before = [np.array([*velocity(prim), *spin(prim)]) for prim in (first, second)]
    made.CreateJointEnabledAttr(False)
    engine.step(STEP)
    momentum = np.array([0, 0, -3.0 * G * STEP])
    momentum = momentum + before[0][:3] + 2.0 * before[1][:3]
    # The two are still one body, which turns by 2 degrees in a step: the solver's error of first order.
    assert velocity(first) + 2.0 * velocity(second) == pytest.approx(momentum, abs=5e-3)
    assert spin(first) == pytest.approx(turning, abs=5e-3)


def test_the_last_motion_of_a_hand_counts():
    """It stops from one step to the next; a jump is a motion of one step, as for bodies that it touches."""
    engine, moved, held, made = carried(new_stage())
    for step in range(1, 4):
        move(moved, step)
        engine.step(STEP)
    engine.step(STEP)
    assert engine.velocities(["/World/hand", "/World/item"]) == pytest.approx(np.zeros((2, 6)))
    assert velocity(held) == pytest.approx([0, 0, 0])
    move(moved, 1, rate=(60.0, 0, 0))
    engine.step(STEP)
    assert velocity(held) == pytest.approx([60.0 - 3 * 1.2, 0, 0], rel=1e-4)
    engine.step(STEP)
    assert velocity(held) == pytest.approx([0, 0, 0])
    made.CreateJointEnabledAttr(False)
    engine.step(STEP)
    assert velocity(held) == pytest.approx([0, 0, -G * STEP], abs=1e-6)
    assert position(held) == pytest.approx([1, 0, 4.7 - G * STEP**2], abs=1e-5)


def test_a_pendulum_below_a_hand_that_rises_rises_with_it():
    stage = new_stage()
    moved, bob = hand(stage), rod(stage, "/World/bob", (0, 0, 5), (0, 0, 4.5))
    joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, "/World/hand", "/World/bob", (0, 0, 5))
    engine = playing(stage)
    engine.step(STEP)
    for step in range(1, 11):
        move(moved, step, rate=(0, 0, 0.6))
        engine.step(STEP)
        assert velocity(bob) == pytest.approx([0, 0, 0.6], abs=ROUNDING)


def test_edits_that_need_a_new_world_do_not_stop_a_hand(recwarn):
    """A joint, a body, a mass; nothing of the motion is lost, also where it is asked for before the step."""
    stage = new_stage()
    engine, moved, held, _ = carried(stage)
    other = item(stage, "other", (0, 3, 5))
    for step in range(1, 25):
        move(moved, step)
        if step == 6:
            weld(stage, "other_weld", "", "other", (0, 3, 5))
        elif step == 12:
            item(stage, "late", (0, -3, 5))
        elif step == 18:
            UsdPhysics.MassAPI(other).GetMassAttr().Set(2.0)
            assert engine.velocities(["/World/item"])[0, :3] == pytest.approx(V, abs=ROUNDING)
            set_value(other, "physics:velocity", Gf.Vec3f(0, 0, 0))
        engine.step(STEP)
        assert velocity(held) == pytest.approx(V, abs=ROUNDING)
        assert engine.velocities(["/World/hand"])[0, :3] == pytest.approx(V, abs=ROUNDING)
        assert position(held) == pytest.approx(V * step * STEP + (0, 0, 4.7), abs=1e-5)
    assert said(recwarn) == []


def test_a_hand_without_joints_goes_on_where_a_body_is_added():
    """It pushes a box that touches it, which leaves with its speed."""
    stage = new_stage()
    moved = hand(stage)
    box = item(stage, "box", (0.2, 0, 5), gravity=False)
    engine = playing(stage)
    engine.step(STEP)
    for step in range(1, 7):
        move(moved, step)
        item(stage, f"late_{step}", (0, step, 5), gravity=False)
        engine.step(STEP)
    assert engine.velocities(["/World/hand"])[0, :3] == pytest.approx(V, abs=ROUNDING)
    assert velocity(box)[0] == pytest.approx(1.2, rel=0.02)


def test_a_motion_is_not_lost_where_another_edit_follows_before_the_step():
    engine, moved, held, _ = carried(new_stage())
    move(moved, 1)
    assert engine.velocities(["/World/item"])[0] == pytest.approx(np.zeros(6))
    held.CreateAttribute(
        "physxRigidBody:linearDamping", held.GetAttribute("physxRigidBody:angularDamping").GetTypeName()
    )
    held.GetAttribute("physxRigidBody:linearDamping").Set(0.0)
    engine.step(STEP)
    assert velocity(held) == pytest.approx(V, abs=ROUNDING)
    assert position(held) == pytest.approx(V * STEP + (0, 0, 4.7), abs=1e-6)


def test_a_hand_that_is_put_somewhere_before_the_first_step_takes_what_it_holds_along(recwarn):
    stage = new_stage()
    moved = hand(stage)
    first, second = item(stage, "first", (0.5, 0, 5)), item(stage, "second", (0.5, 0.4, 5))
    weld(stage, "weld", "hand", "first", (0.2, 0, 5))
    weld(stage, "second_weld", "first", "second", (0.5, 0.2, 5))
    engine = playing(stage)
    move(moved, 1, rate=(60, 0, 0), turn=5400.0)  # to x = 1, by 90 degrees
    engine.step(STEP)
    for prim, at in ((first, (1, 0.5, 5)), (second, (0.6, 0.5, 5))):
        assert position(prim) == pytest.approx(at, abs=1e-5)
        assert velocity(prim) == pytest.approx([0, 0, 0], abs=1e-6)
    engine.stop()
    assert position(first).tolist() == [0.5, 0, 5]
    assert said(recwarn) == []


def test_what_is_grasped_before_the_first_step_stays_where_it_is(recwarn):
    """The hand comes first, then the joint between both as they are: nothing is carried."""
    stage = new_stage()
    moved, held = hand(stage, at=(0, 0, 8)), item(stage, "item", (0, 0, 4.7))
    engine = playing(stage)
    move(moved, 0)
    weld(stage, "weld", "hand", "item", (0, 0, 4.7))
    for _ in range(3):
        engine.step(STEP)
    assert position(held) == pytest.approx([0, 0, 4.7], abs=1e-6)
    assert said(recwarn) == []


def test_what_is_welded_to_something_fixed_rests_and_falls_from_rest():
    stage = new_stage()
    add(stage, "/World/wall", at=(0, 0, 5), body=False)
    held = [item(stage, "on_wall", (0, 0, 5.5)), item(stage, "in_world", (2, 0, 5))]
    joints = [weld(stage, "a", "wall", "on_wall", (0, 0, 5.2)), weld(stage, "b", "", "in_world", (2, 0, 5))]
    engine = playing(stage)
    for _ in range(10):
        engine.step(STEP)
        assert [velocity(prim).tolist() for prim in held] == [[0, 0, 0], [0, 0, 0]]
    for made in joints:
        made.CreateJointEnabledAttr(False)
    engine.step(STEP)
    for prim in held:
        assert velocity(prim) == pytest.approx([0, 0, -G * STEP], abs=1e-6)


def test_two_bodies_that_part_in_flight_keep_their_momentum():
    stage = new_stage()
    turning, masses = np.array([1.0, 2.0, 3.0]), (1.0, 2.0)
    prims = [
        item(stage, name, at, mass=mass, gravity=False)
        for name, at, mass in (("a", (0, 0, 5), 1.0), ("b", (0.5, 0.1, 5.2), 2.0))
    ]
    center = sum(mass * position(prim) for mass, prim in zip(masses, prims)) / 3.0
    for prim in prims:
        body = UsdPhysics.RigidBodyAPI(prim)
        linear = np.array([0.3, 0.2, 0.0]) + np.cross(turning, position(prim) - center)
        body.CreateVelocityAttr(Gf.Vec3f(*linear.tolist()))
        body.CreateAngularVelocityAttr(Gf.Vec3f(*np.degrees(turning).tolist()))
    made = weld(stage, "weld", "a", "b", (0.25, 0.05, 5.1))

    def momenta() -> np.ndarray:
        """Linear, and angular about the origin; the moment of inertia of a cube is m s² / 6."""
        linear = sum(mass * velocity(prim) for mass, prim in zip(masses, prims))
        angular = sum(
            mass * (np.cross(position(prim), velocity(prim)) + 0.2**2 / 6 * spin(prim))
            for mass, prim in zip(masses, prims)
        )
        return np.concatenate([linear, angular])

    engine = playing(stage)
    for _ in range(10):
        engine.step(STEP)
    before, motion = momenta(), [velocity(prim) for prim in prims]
    arm = position(prims[1]) - position(prims[0])
    assert motion[1] - motion[0] == pytest.approx(np.cross(spin(prims[0]), arm), abs=1e-5)
    made.CreateJointEnabledAttr(False)
    for _ in range(20):
        engine.step(STEP)
        assert momenta() == pytest.approx(before, abs=5e-5)
        assert np.array([velocity(prim) for prim in prims]) == pytest.approx(np.array(motion), abs=1e-5)


@pytest.mark.parametrize(
    ("pull", "excluded"),
    crossed([((10.0, 0, 0), 5.0 * np.hypot(10.0, G)), ((0, 0, 5.0), 5.0 * (G + 5.0))], [False, True]),
)
def test_a_weld_breaks_under_what_accelerates_it(pull, excluded):
    """The joint bears weight and inertia, m |a - g|, of 2 kg and of the 3 kg that are welded to them."""
    acceleration, load = pull
    for share in (1.01, 0.99):
        stage = new_stage()
        moved, held = hand(stage), item(stage, "item", (0, 0, 4.5), mass=2.0)
        item(stage, "below", (0, 0, 4), mass=3.0)
        made = weld(stage, "weld", "hand", "item", (0, 0, 4.75))
        weld(stage, "second_weld", "item", "below", (0, 0, 4.25))
        made.CreateBreakForceAttr(share * load)
        made.CreateExcludeFromArticulationAttr(excluded)
        engine = playing(stage)
        engine.step(STEP)
        for step in range(1, 31):
            move(moved, step, rate=0.5 * np.array(acceleration) * (step + 1) * STEP)
            engine.step(STEP)
        holds = np.linalg.norm(position(held) - position(moved)) == pytest.approx(0.5, abs=1e-4)
        assert holds == (share > 1.0)


@pytest.mark.parametrize(("share", "holds"), [(1.01, True), (0.99, False)])
def test_a_weld_breaks_under_the_torque_of_what_is_accelerated_below_it(share, holds):
    """2 kg and 3 kg, 0.25 and 0.75 m below the joint, at 10 m/s² to the side."""
    stage = new_stage()
    moved, held = hand(stage), item(stage, "item", (0, 0, 4.5), mass=2.0)
    item(stage, "below", (0, 0, 4), mass=3.0)
    weld(stage, "second_weld", "item", "below", (0, 0, 4.25))
    weld(stage, "weld", "hand", "item", (0, 0, 4.75)).CreateBreakTorqueAttr(share * 10.0 * (2 * 0.25 + 3 * 0.75))
    engine = playing(stage)
    engine.step(STEP)
    for step in range(1, 31):
        move(moved, step, rate=(5.0 * (step + 1) * STEP, 0, 0))
        engine.step(STEP)
    assert (np.linalg.norm(position(held) - position(moved)) < 0.51) == holds


def test_a_weld_breaks_under_what_turns_it():
    """m sqrt((ω² r)² + g²) at one turn per second and 0.5 m."""
    load = 2.0 * np.hypot((2 * np.pi) ** 2 * 0.5, G)
    for limit, holds in ((1.01 * load, True), (0.99 * load, False)):
        stage = new_stage()
        moved, held = hand(stage), item(stage, "item", (0.5, 0, 5), mass=2.0)
        made = weld(stage, "weld", "hand", "item", (0.25, 0, 5))
        engine = playing(stage)
        engine.step(STEP)
        for step in range(1, 61):
            if step == 31:
                made.CreateBreakForceAttr(limit)
            move(moved, step, rate=(0, 0, 0), turn=360.0)
            engine.step(STEP)
        assert (np.linalg.norm(position(held) - position(moved)) < 0.51) == holds


def test_runs_repeat_bit_for_bit():
    def run() -> bytes:
        stage = new_stage()
        engine, moved, held, made = carried(stage)
        found = []
        for step in range(1, 31):
            if step == 12:
                made.CreateJointEnabledAttr(False)
            if step == 20:
                item(stage, "late", (0, 3, 5))
            move(moved, step, turn=100.0)
            engine.step(STEP)
            found.append([*position(held), *velocity(held), *spin(held)])
        engine.stop()
        return np.array(found).tobytes()

    assert run() == run()
