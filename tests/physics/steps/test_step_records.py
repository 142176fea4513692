"""A step that is replayed from a record gives the same bits as one launched from Python."""

import threading

import numpy as np
import pytest
import warp as wp
from pxr import Gf, UsdPhysics, UsdShade

from tests.physics.joints.test_distance_joints import tie
from tests.physics.joints.test_gears import gear, wheel
from tests.physics.mechanisms import drive, joint, rod
from tests.physics.scenes import add, collide, mesh, new_stage, physics_material, playing, set_value
from usdsdg_physics.world import step_records
from usdsdg_physics.world.step_records import StepRecords

FRAMES = 48
KINDS = ("Cube", "Sphere", "Capsule", "Cone", "Cylinder")


def ground(stage):
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(2, 2, 0.1), body=False)


def pile(stage, count):
    rng = np.random.default_rng(0)
    return [
        add(
            stage,
            f"/World/b{i}",
            KINDS[i % 5],
            at=tuple(rng.uniform((-0.3, -0.3, 0.3), (0.3, 0.3, 0.9))),
            rotate=tuple(rng.uniform(0, 360, 3)),
            gravity=i % 4 > 0,
        )
        for i in range(count)
    ]


def contacts(stage):
    ground(stage)
    pile(stage, 16)
    return lambda engine, frame: None


def sleeping(stage):
    ground(stage)
    prims = pile(stage, 12)

    def edit(engine, frame):
        if frame == 5:
            engine.put_to_sleep([str(prim.GetPath()) for prim in prims[:8]])
        if frame == 25:
            engine.wake_up([str(prims[3].GetPath())])

    return edit


def depenetration(stage):
    ground(stage)
    pile(stage, 12)
    camera = add(stage, "/World/camera", "Sphere", at=(0, 0, 0.3), scale=(0.3, 0.3, 0.3), body=False)
    set_value(camera, "physics:collisionEnabled", False)

    def edit(engine, frame):
        if frame in (15, 30):
            set_value(camera, "physics:collisionEnabled", frame == 15)
        if frame == 20:
            set_value(camera, "xformOp:translate", Gf.Vec3d(0.1, 0.1, 0.2))

    return edit


def kinematic(stage):
    ground(stage)
    pile(stage, 8)
    pusher = add(stage, "/World/pusher", at=(-0.8, 0, 0.11), scale=(0.1, 0.5, 0.1), rotate=(0, 0, 0))
    UsdPhysics.RigidBodyAPI(pusher).CreateKinematicEnabledAttr(True)

    def edit(engine, frame):
        if frame % 3 != 2:
            set_value(pusher, "xformOp:translate", Gf.Vec3d(0.03 * frame - 0.8, 0, 0.11))
            set_value(pusher, "xformOp:rotateXYZ", Gf.Vec3f(0, 0, 5 * frame))

    return edit


def edits(stage):
    ground(stage)
    prims = pile(stage, 12)
    scene = UsdPhysics.Scene(stage.GetPrimAtPath("/PhysicsScene"))

    def edit(engine, frame):
        if frame == 5:
            set_value(prims[3], "xformOp:translate", Gf.Vec3d(0, 0, 1.5))
        if frame % 7 == 0:
            set_value(prims[frame % 12], "physics:velocity", Gf.Vec3f(1, -2, 0.1 * frame))
        if frame == 15:
            scene.CreateGravityMagnitudeAttr(3.0)
        if frame == 20:
            set_value(prims[6], "physxRigidBody:disableGravity", True)
        if frame in (25, 28):
            set_value(scene.GetPrim(), "physxScene:timeStepsPerSecond", 320 if frame == 25 else 60)
        if frame in (30, 31):
            engine.apply_forces(["/World/b2", "/World/b9"], [(0, 0, 30.0), (5, 0, 10)], [(0, 0, 1.0), (0.2, 0, 0)])
        if frame == 35:
            set_value(stage.GetPrimAtPath("/World/ground"), "xformOp:translate", Gf.Vec3d(0, 0, -0.05))

    return edit


def terrain(stage):
    side = np.linspace(-2, 2, 8)
    points = np.array([(x, y, 0.15 * np.sin(3 * x) * np.cos(2 * y)) for x in side for y in side])
    corners = [8 * i + j for i in range(7) for j in range(7)]
    triangles = [t for a in corners for t in ((a, a + 8, a + 1), (a + 1, a + 8, a + 9))]
    collide(mesh(stage, "/World/terrain", points, np.array(triangles)).GetPrim(), approximation="none")
    prims = pile(stage, 8)

    def edit(engine, frame):
        if frame % 16 == 8:  # takes more substeps
            set_value(prims[4], "xformOp:translate", Gf.Vec3d(0.2, 0.3, 1.2))
            set_value(prims[4], "physics:velocity", Gf.Vec3f(1, 0, -25))

    return edit


def world_of(engine):
    world = engine._session.world
    assert world is not None
    return world


def joints(stage):
    ground(stage)
    pile(stage, 6)
    add(stage, "/World/lifted", at=(0, 0, 1))
    rail = joint(stage, "/World/rail", UsdPhysics.PrismaticJoint, "", "/World/lifted", (0, 0, 1), axis="Z")
    target = drive(rail, "linear", stiffness=1000.0, damping=100.0, target=-0.5)
    rod(stage, "/World/bob", (0.5, 0, 1.2), (0.5, -0.3, 0.9))
    joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, "", "/World/bob", (0.5, 0, 1.2))

    def edit(engine, frame):
        if frame in (20, 35):
            target.GetTargetPositionAttr().Set(-0.8 if frame == 20 else 0.3)

    return edit


def rebounds(stage):
    """A pile that bounces beside a top on a ball joint, and a box that is pushed against more static friction."""
    material = physics_material(stage, "/World/rubber", friction=0.3, restitution=0.6)
    UsdPhysics.MaterialAPI(material.GetPrim()).GetStaticFrictionAttr().Set(0.6)
    for prim in [add(stage, "/World/floor", at=(0, 0, -0.1), scale=(2, 2, 0.1), body=False), *pile(stage, 10)]:
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, UsdShade.Tokens.weakerThanDescendants, "physics")
    top = add(stage, "/World/top", "Cylinder", at=(0.8, 0, 1), scale=(0.1, 0.1, 0.02), rotate=(0, 30, 0))
    UsdPhysics.RigidBodyAPI(top).CreateAngularVelocityAttr(Gf.Vec3f(500, 0, 2000))
    joint(stage, "/World/ball", UsdPhysics.SphericalJoint, "", "/World/top", (0.8, 0, 0.9))

    def edit(engine, frame):
        engine.apply_forces(["/World/b1"], [[3.0, 0, 0]])

    return edit


def ties(stage):
    """A rope, a spring and a rod between bodies of a pile, a gear, and a plate on two rails, which is cut."""
    ground(stage)
    pile(stage, 6)
    for number, (first, second) in enumerate([("b0", "b1"), ("b2", "b3"), ("b4", "")]):
        ends = [f"/World/{name}" if name else "" for name in (first, second)]
        spring = (50.0, 1.0) if number == 1 else None
        least = 0.4 if number == 2 else -1.0
        tie(stage, f"/World/tie_{number}", *ends, (0, 0, 0), (0, 0, 0), least=least, most=0.4, spring=spring)
    for name, y in (("first", 3.0), ("second", 3.3)):
        wheel(stage, name, y)
    gear(stage, "/World/gear", "first", "second", 2.0)
    add(stage, "/World/plate", at=(0, 5, 1))
    for name, y in (("left", 4.9), ("right", 5.1)):
        rail = joint(stage, f"/World/{name}", UsdPhysics.PrismaticJoint, "", "/World/plate", (0, y, 1), axis="Z")
        drive(rail, "linear", stiffness=500.0, damping=20.0, target=0.3)

    def edit(engine, frame):
        if frame in (10, 20):
            engine.apply_joint_efforts(["/World/first_joint"], [3.0])

    return edit


def moved_platform(stage):
    ground(stage)
    platform = add(stage, "/World/platform", at=(0, 0, 0.05), scale=(1, 1, 0.05), body=False)
    pile(stage, 8)

    def edit(engine, frame):
        if frame % 16 > 4:
            set_value(platform, "xformOp:translate", Gf.Vec3d(0.005 * frame, 0, 0.05))

    return edit


def trajectory(make):
    """Poses and velocities after every frame, and of how many kinds of steps the world ended with records."""
    stage = new_stage()
    edit = make(stage)
    engine = playing(stage)
    states = []
    for frame in range(FRAMES):
        edit(engine, frame)
        engine.advance(1 / 60)
        states.append(np.hstack([world_of(engine).poses(), world_of(engine).velocities()]))
    keys = world_of(engine)._launches.records._records
    records = len({key[0] if isinstance(key, tuple) else key for key in keys})
    engine.stop()
    return np.array(states), records


@pytest.mark.parametrize(
    ("make", "kinds"),
    [
        (contacts, 1),
        (sleeping, 2),
        (depenetration, 2),
        (kinematic, 2),
        (edits, 3),
        (terrain, 2),
        (joints, 1),
        (rebounds, 1),
        (ties, 1),
        (moved_platform, 2),
    ],
)
def test_recorded_and_unrecorded_steps_are_bit_equal(make, kinds, monkeypatch):
    recorded, records = trajectory(make)
    assert records >= kinds
    monkeypatch.setattr(step_records, "RECORD_AT_USE", 10**9)
    unrecorded, records = trajectory(make)
    assert records == 0
    assert (recorded.view(np.int32) == unrecorded.view(np.int32)).all()
    assert np.ptp(recorded[:, :, 2], axis=0).max() > 0.1  # something moved


@wp.kernel
def add_one(values: wp.array[wp.int32]):
    wp.atomic_add(values, 0, 1)  # pyright: ignore[reportArgumentType]


def test_what_cannot_be_recorded_is_launched_with_a_warning(monkeypatch):
    warnings = []
    monkeypatch.setattr(step_records, "warn_once", warnings.append)
    device = wp.get_device("cpu")
    values = wp.zeros(1, dtype=wp.int32, device=device)

    def launch():
        if device.is_capturing:
            raise RuntimeError("it reads back")
        wp.launch(add_one, dim=1, outputs=[values], device=device)

    records = StepRecords(device)
    for _ in range(4):
        records.run("kind", launch)
    assert values.numpy()[0] == 4
    assert len(warnings) == 1
    assert "it reads back" in warnings[0]


def test_kinds_that_do_not_come_back_are_forgotten():
    device = wp.get_device("cpu")
    values = wp.zeros(1, dtype=wp.int32, device=device)
    records = StepRecords(device)
    for kind in range(2 * step_records.MAX_KINDS):
        records.run(kind, lambda: wp.launch(add_one, dim=1, outputs=[values], device=device))
        records.run("often", lambda: wp.launch(add_one, dim=1, outputs=[values], device=device))
    assert values.numpy()[0] == 4 * step_records.MAX_KINDS
    assert len(records._records) == 1
    assert len(records._uses) <= step_records.MAX_KINDS


@wp.kernel
def _add_one(numbers: wp.array(dtype=int)):
    i = wp.tid()
    numbers[i] = numbers[i] + 1


def test_a_record_has_nothing_of_what_other_threads_launch_meanwhile():
    """Frames are rendered while physics records; an array of theirs in the record could take the number of another."""
    own, other = wp.zeros(8, dtype=int, device="cpu"), wp.zeros(1 << 10, dtype=int, device="cpu")
    copied = wp.zeros(1 << 10, dtype=int, device="cpu")

    def render() -> None:
        for _ in range(20):
            wp.launch(_add_one, dim=other.shape, inputs=[other], device="cpu")
        wp.copy(copied, other)

    def launch() -> None:
        wp.launch(_add_one, dim=own.shape, inputs=[own], device="cpu")
        thread = threading.Thread(target=render)
        thread.start()
        thread.join()

    records = StepRecords(wp.get_device("cpu"))
    for _ in range(step_records.RECORD_AT_USE):
        records.run("kind", launch)
    graph = records._records["kind"]
    held = {id(base) for _, _, _, base in graph._apic_capture._regions.values()}
    assert held == {id(own)}
    assert (other.numpy() == 20 * step_records.RECORD_AT_USE).all()  # what they launch is run
    assert (copied.numpy() == other.numpy()).all()
    records.run("kind", launch)
    assert (own.numpy() == step_records.RECORD_AT_USE + 1).all()
