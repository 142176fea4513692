"""What replaces parts of Newton on the CPU gives its bits: sweeps by island, pairs and contacts that are left out."""

from contextlib import nullcontext

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics
from scipy.spatial import ConvexHull

from tests.physics.mechanisms import drive, joint, limit, rod
from tests.physics.scenes import DEVICE, add, collide, make_body, mesh, set_value
from tests.physics.steps.test_step_records import contacts, ground, kinematic, pile, terrain, ties, trajectory
from tests.sampled_cases import sampled
from usdsdg_physics.model import build
from usdsdg_physics.parse.scene import parse
from usdsdg_physics.parse.shapes.convex_hulls import HullCache
from usdsdg_physics.solver.separated_pairs import drop_separated_pairs
from usdsdg_physics.solver.sweep_pairs import sweep_pairs_alone
from usdsdg_physics.solver.sweeps import sweep_by_island
from usdsdg_physics.solver.visited_contacts import VisitedContacts
from usdsdg_physics.world.world import World

pytestmark = pytest.mark.skipif(DEVICE != "cpu", reason="nothing of Newton is replaced there")


def gripper(stage):
    """A box between two driven fingers above a pile, a door with a limit, and a wheel with a limit of its speed."""
    ground(stage)
    pile(stage, 6)
    for name, side in (("left", 1), ("right", -1)):
        add(stage, f"/World/{name}", at=(0.8, side * 0.16, 0.3), scale=(0.1, 0.05, 0.1))
        slide = joint(
            stage,
            f"/World/{name}_slide",
            UsdPhysics.PrismaticJoint,
            "",
            f"/World/{name}",
            (0.8, side * 0.16, 0.3),
            axis="Y",
        )
        drive(slide, "linear", stiffness=20000.0, damping=300.0, target=-side * 0.05, max_force=400.0)
    add(stage, "/World/held", at=(0.8, 0, 0.3), scale=(0.1, 0.1, 0.1))
    rod(stage, "/World/door", (-0.8, 0, 0.5), (-0.8, 0.6, 0.5))
    hinge = joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, "", "/World/door", (-0.8, 0, 0.5), axis="X")
    limit(hinge, -20.0, 20.0)
    rod(stage, "/World/wheel", (-0.8, -0.8, 0.5), (-0.8, -0.2, 0.5))
    axle = joint(stage, "/World/axle", UsdPhysics.RevoluteJoint, "", "/World/wheel", (-0.8, -0.5, 0.5), axis="X")
    drive(axle, "angular", damping=10.0, target_velocity=2000.0)
    UsdPhysics.ArticulationRootAPI.Apply(axle.GetPrim())
    axle.GetPrim().AddAppliedSchema("PhysxJointAPI")
    axle.GetPrim().CreateAttribute("physxJoint:maxJointVelocity", Sdf.ValueTypeNames.Float).Set(300.0)
    return lambda engine, frame: None


def loop(stage):
    """Four rods that hinges join to a ring, which falls on the ground beside a pile."""
    ground(stage)
    pile(stage, 4)
    corners = [(0.8, y, z) for y, z in ((0, 0.5), (0.4, 0.5), (0.4, 0.9), (0, 0.9))]
    for i in range(4):
        rod(stage, f"/World/rod_{i}", corners[i], corners[(i + 1) % 4])
    for i in range(4):
        name = f"/World/rod_{(i + 1) % 4}"
        made = joint(
            stage, f"/World/j{i}", UsdPhysics.RevoluteJoint, f"/World/rod_{i}", name, corners[(i + 1) % 4], axis="X"
        )
        made.CreateCollisionEnabledAttr(False)
    return lambda engine, frame: None


@pytest.mark.parametrize("make", sampled([contacts, kinematic, terrain, gripper, loop], 3))
def test_motion_is_that_of_newtons_sweeps_to_the_bit(make, monkeypatch):
    replaced = []
    monkeypatch.setattr(build, "sweep_by_island", lambda solver: replaced.append(sweep_by_island(solver)))
    ours, _ = trajectory(make)
    assert all(replaced)
    monkeypatch.setattr(build, "sweep_by_island", lambda solver: None)
    newtons, _ = trajectory(make)
    assert ours.tobytes() == newtons.tobytes()
    assert np.ptp(ours[:, :, 2], axis=0).max() > 0.1  # something moved


def hulls(stage):
    """A heap of hulls, also of few corners, of as many as fit into one look at them, and of equally far ones."""
    ground(stage)
    rng = np.random.default_rng(3)
    for i, count in enumerate((4, 6, 7, 8, 9, 15, 16, 17, 40, 60) * 2):
        points = rng.normal(size=(count, 3))
        points *= 0.12 / np.linalg.norm(points, axis=1, keepdims=True)
        if i >= 10:
            points = np.round(points, 1) + 0.02 * np.sign(points)
        hull = ConvexHull(points, qhull_options="QJ")
        made = mesh(stage, f"/World/h{i}", points, hull.simplices)
        made.AddTranslateOp().Set(tuple(rng.uniform((-0.3, -0.3, 0.2), (0.3, 0.3, 0.9))))
        made.AddScaleOp().Set((1.0, 1.0, rng.choice([1.0, 0.5])))
        collide(made.GetPrim())
        make_body(made.GetPrim())
    pile(stage, 5)
    return lambda engine, frame: None


@pytest.mark.parametrize("make", sampled([contacts, kinematic, terrain, gripper, hulls], 2))
def test_pairs_that_are_left_out_have_no_contacts(make, monkeypatch):
    pipelines, left_out, kept = [], [], []

    def watched(stage):
        act = make(stage)

        def step(engine, frame):
            if pipelines:
                pipeline = pipelines[-1]
                pairs = pipeline.broad_phase_shape_pairs.numpy()[: pipeline.broad_phase_pair_count.numpy()[0]]
                left_out.append(int((pairs < 0).sum()))
                kept.append(int((pairs >= 0).sum()))
            return act(engine, frame)

        return step

    monkeypatch.setattr(
        build, "drop_separated_pairs", lambda made: pipelines.append(made) or drop_separated_pairs(made)
    )
    ours, _ = trajectory(watched)
    assert any(left_out)
    assert any(kept)
    monkeypatch.setattr(build, "drop_separated_pairs", lambda pipeline: None)
    newtons, _ = trajectory(make)
    assert ours.tobytes() == newtons.tobytes()


@pytest.mark.parametrize("make", sampled([contacts, kinematic, terrain, gripper, hulls], 2))
def test_motion_is_that_of_newtons_search_for_pairs(make, monkeypatch):
    replaced = []
    monkeypatch.setattr(build, "sweep_pairs_alone", lambda pipeline: replaced.append(sweep_pairs_alone(pipeline)))
    ours, _ = trajectory(make)
    assert replaced
    assert all(replaced)
    monkeypatch.setattr(build, "sweep_pairs_alone", lambda pipeline: None)
    newtons, _ = trajectory(make)
    assert ours.tobytes() == newtons.tobytes()


def test_pairs_of_many_shapes_are_those_of_newtons_search(monkeypatch):
    """Also where bodies jump to places that are sorted otherwise, and one of them to none."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    ground(stage)
    rng = np.random.default_rng(5)
    for i in range(150):
        add(stage, f"/World/b{i}", at=tuple(rng.uniform(-0.5, 0.5, 3)), scale=(0.1, 0.1, 0.1))
    pairs = []
    for replace in (sweep_pairs_alone, lambda pipeline: None):
        monkeypatch.setattr(build, "sweep_pairs_alone", replace)
        world = World(parse(stage, HullCache()), device="cpu")
        model, pipeline = world.model, world.pipeline
        shuffled = np.random.default_rng(6)
        for frame in range(4):
            state = model.state()
            poses = state.body_q.numpy()
            poses[:, :3] = shuffled.uniform(-0.5, 0.5, (len(poses), 3))
            if frame == 2:
                poses[7] = np.nan
            state.body_q.assign(poses)
            pipeline.collide(state, pipeline.contacts())
            found = pipeline.broad_phase_shape_pairs.numpy()[: pipeline.broad_phase_pair_count.numpy()[0]]
            pairs.append({tuple(pair) for pair in found.tolist() if pair[0] >= 0})
    assert pairs[:4] == pairs[4:]
    assert min(map(len, pairs)) > 300


def scattered(stage):
    """A heap, two thirds of which are in the air for a while, so that contacts go and come again."""
    ground(stage)
    prims = [
        add(stage, f"/World/b{i}", at=(0.21 * (i % 5), 0.21 * (i // 5 % 5), 0.1 + 0.2 * (i // 25))) for i in range(50)
    ]

    def edit(engine, frame):
        if frame in (12, 28):
            for i, prim in enumerate(prims[:34]):
                set_value(prim, "xformOp:translate", Gf.Vec3d(0.5 * (i % 6), 0.5 * (i // 6), 1.0))

    return edit


@pytest.mark.parametrize(("make", "counts"), [(scattered, 3), (kinematic, 1), (gripper, 1), (loop, 1), (ties, 1)])
def test_motion_is_that_of_visits_to_all_contacts(make, counts, monkeypatch):
    chosen = []
    choose = VisitedContacts.choose
    monkeypatch.setattr(VisitedContacts, "choose", lambda self: chosen.append(choose(self)) or chosen[-1])
    ours, _ = trajectory(make)
    assert len(set(chosen)) >= counts
    assert min(chosen) < 1000  # of which there is room for
    monkeypatch.setattr(VisitedContacts, "of", lambda *_, **__: None)
    newtons, _ = trajectory(make)
    assert ours.tobytes() == newtons.tobytes()
    assert np.ptp(ours[:, :, 2], axis=0).max() > 0.1  # something moved


def test_motion_is_that_of_newtons_search_for_the_corners_of_hulls(monkeypatch):
    pipelines = []
    monkeypatch.setattr(
        build, "drop_separated_pairs", lambda made: pipelines.append(made) or drop_separated_pairs(made)
    )
    ours, _ = trajectory(hulls)
    monkeypatch.setattr(build, "narrow_phase_of_fast_hulls", nullcontext)
    newtons, _ = trajectory(hulls)
    names = [pipeline.narrow_phase.narrow_phase_kernel.module.name for pipeline in pipelines]
    assert "fast_hulls" in names[0]
    assert "fast_hulls" not in names[-1]
    assert ours.tobytes() == newtons.tobytes()
    assert np.ptp(ours[:, :, 2], axis=0).max() > 0.1  # something moved
