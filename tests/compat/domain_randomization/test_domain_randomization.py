"""Domain randomization: which environments are randomized when, and what is written to them."""

from types import SimpleNamespace

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics, UsdShade

from tests.articulations.robots import at, link, planar_arm
from usdsdg import distribution, orchestrator
from usdsdg.app.app import get_app
from usdsdg.articulations.articulations import get_articulations
from usdsdg.compat.isaacsim.replicator import domain_randomization as old
from usdsdg.compat.isaacsim.replicator.experimental import domain_randomization as dr
from usdsdg.compat.isaacsim.replicator.randomization.registry import get_registry
from usdsdg.errors import ArgumentError, Unsupported
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.physics import scenes

ENVS = 3


@pytest.fixture
def bodies(stage):
    """Three bodies at x = 0, 1, 2, registered as "bodies"."""
    prims = [link(stage, f"/World/env_{i}/body", (i, 0, 0)) for i in range(ENVS)]
    dr.physics_view.register_rigid_prim_view(SimpleNamespace(paths=[str(p.GetPath()) for p in prims]), name="bodies")
    return prims


def _positions(prims) -> np.ndarray:
    return np.array([at(prim) for prim in prims])


def test_an_interval_counts_the_frames_of_each_environment_since_its_reset(bodies):
    with dr.trigger.on_rl_frame(num_envs=ENVS), dr.gate.on_interval(interval=3):
        dr.physics_view.randomize_rigid_prim_view("bodies", position=(5.0, 5.0, 5.0))
    moved = []
    for frame in range(8):
        dr.physics_view.step_randomization([1] if frame == 2 else None)
        moved.append([bool(x == 5.0) for x in _positions(bodies)[:, 0]])
        for index, prim in enumerate(bodies):
            prim.GetAttribute("xformOp:translate").Set(Gf.Vec3d(index, 0, 0))
    # Environment 1 was reset at frame 2, so it counts to 3 at frame 5.
    assert [frame for frame, row in enumerate(moved) if row[0]] == [3, 6]
    assert [frame for frame, row in enumerate(moved) if row[1]] == [5]
    assert [frame for frame, row in enumerate(moved) if row[2]] == [3, 6]


def test_a_reset_acts_on_the_environments_that_are_reset(bodies):
    with dr.trigger.on_rl_frame(num_envs=ENVS), dr.gate.on_env_reset():
        dr.physics_view.randomize_rigid_prim_view("bodies", operation="additive", position=(0.0, 2.0, 0.0))
    dr.physics_view.step_randomization()
    assert _positions(bodies) == pytest.approx(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]]))
    dr.physics_view.step_randomization(np.array([0, 2]))
    assert _positions(bodies) == pytest.approx(np.array([[0, 2, 0], [1, 0, 0], [2, 2, 0]]))
    assert dr.context.get_reset_inds().tolist() == [0, 2]


def test_resets_start_from_the_registered_values_and_intervals_from_the_latest_reset(bodies):
    with dr.trigger.on_rl_frame(num_envs=ENVS):
        with dr.gate.on_interval(interval=2):
            dr.physics_view.randomize_rigid_prim_view("bodies", operation="additive", position=(0.0, 0.0, 1.0))
        with dr.gate.on_env_reset():
            dr.physics_view.randomize_rigid_prim_view("bodies", operation="additive", position=(0.0, 2.0, 0.0))
    for frame in range(5):
        dr.physics_view.step_randomization([0] if frame == 0 else [])
    assert _positions(bodies) == pytest.approx(np.array([[0, 2, 1], [1, 0, 1], [2, 0, 1]]))  # added once, not twice
    dr.physics_view.step_randomization([0])
    assert at(bodies[0]) == pytest.approx([0, 2, 0])


def test_draws_differ_between_environments_and_repeat_with_the_seed(bodies):
    from usdsdg.graph.sampling import set_global_seed

    with dr.trigger.on_rl_frame(num_envs=ENVS), dr.gate.on_env_reset():
        dr.physics_view.randomize_rigid_prim_view(
            "bodies", position=distribution.uniform((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
        )
    dr.physics_view.step_randomization(range(ENVS))
    first = _positions(bodies)
    assert len({tuple(row) for row in first.tolist()}) == ENVS
    assert first.min() >= 0
    assert first.max() <= 1
    dr.physics_view.step_randomization(range(ENVS))
    assert not np.allclose(_positions(bodies), first)
    set_global_seed(1)
    dr.physics_view.step_randomization(range(ENVS))
    assert _positions(bodies) == pytest.approx(first)


def test_orientations_are_angles_about_x_then_y_then_z(bodies, stage):
    with dr.trigger.on_rl_frame(num_envs=ENVS), dr.gate.on_env_reset():
        dr.physics_view.randomize_rigid_prim_view("bodies", orientation=(0.3, 0.4, 0.5))
    dr.physics_view.step_randomization([1])
    other = UsdGeom.Xformable(stage.DefinePrim("/World/Other", "Xform"))
    other.AddRotateXYZOp().Set(Gf.Vec3f(*np.degrees([0.3, 0.4, 0.5]).tolist()))
    found = UsdGeom.XformCache().GetLocalToWorldTransform(bodies[1])
    assert np.allclose(found.ExtractRotationMatrix(), other.GetLocalTransformation().ExtractRotationMatrix(), atol=1e-6)


def test_velocities_masses_and_materials_are_written_to_the_stage(bodies):
    UsdPhysics.MassAPI.Apply(bodies[0]).CreateMassAttr(2.0)
    with dr.trigger.on_rl_frame(num_envs=ENVS), dr.gate.on_env_reset():
        dr.physics_view.randomize_rigid_prim_view("bodies", velocity=[1, 2, 3, 0, 0, np.pi])
        dr.physics_view.randomize_rigid_prim_view("bodies", operation="scaling", mass=distribution.uniform(3.0, 3.0))
        dr.physics_view.randomize_rigid_prim_view("bodies", material_properties=(0.7, 0.6, 0.5))
    dr.physics_view.step_randomization([0])
    body = UsdPhysics.RigidBodyAPI(bodies[0])
    assert body.GetVelocityAttr().Get() == Gf.Vec3f(1, 2, 3)
    assert body.GetAngularVelocityAttr().Get()[2] == pytest.approx(180.0)
    assert UsdPhysics.MassAPI(bodies[0]).GetMassAttr().Get() == pytest.approx(6.0)
    bound, _ = UsdShade.MaterialBindingAPI(bodies[0].GetChild("geometry")).ComputeBoundMaterial("physics")
    material = UsdPhysics.MaterialAPI(bound.GetPrim())
    found = (material.GetStaticFrictionAttr(), material.GetDynamicFrictionAttr(), material.GetRestitutionAttr())
    assert [each.Get() for each in found] == pytest.approx([0.7, 0.6, 0.5])


def test_what_nobody_has_authored_cannot_be_scaled(bodies):
    with dr.trigger.on_rl_frame(num_envs=ENVS), dr.gate.on_env_reset():
        dr.physics_view.randomize_rigid_prim_view("bodies", operation="scaling", mass=2.0)
    with pytest.raises(Exception, match="/World/env_1/body: mass is not authored"):
        dr.physics_view.step_randomization([1])


def test_buckets_round_down_to_equal_parts_of_the_range(bodies):
    with dr.trigger.on_rl_frame(num_envs=ENVS), dr.gate.on_env_reset():
        drawn = distribution.uniform((0.0, 0.2, 0.0), (1.0, 0.6, 1.0))
        dr.physics_view.randomize_rigid_prim_view("bodies", num_buckets=4, material_properties=drawn)
    dr.physics_view.step_randomization(range(ENVS))
    found = get_registry().rigid["bodies"].values.read("material_properties")
    lower, size = np.array([0.0, 0.2, 0.0]), np.array([0.25, 0.1, 0.25])
    parts = (found - lower) / size
    assert parts == pytest.approx(np.round(parts), abs=1e-5)
    assert parts.min() > -0.01
    assert parts.max() < 3.01


def test_gravity_is_that_of_the_scene(stage, bodies):
    dr.physics_view.register_simulation_context()
    with dr.trigger.on_rl_frame(num_envs=ENVS), dr.gate.on_interval(interval=2):
        dr.physics_view.randomize_simulation_context(operation="scaling", gravity=(1.0, 1.0, 0.5))
    for _ in range(3):
        dr.physics_view.step_randomization()
    scene = UsdPhysics.Scene(scenes.physics_scene(stage))
    assert scene.GetGravityDirectionAttr().Get() == Gf.Vec3f(0, 0, -1)
    assert scene.GetGravityMagnitudeAttr().Get() == pytest.approx(9.81 / 2)


def test_forces_act_on_bodies_that_are_simulated(stage, bodies):
    for prim in bodies:
        UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(0.5)
    get_timeline().play()
    get_app().update()
    with dr.trigger.on_rl_frame(num_envs=ENVS), dr.gate.on_interval(interval=1):
        dr.physics_view.randomize_rigid_prim_view("bodies", force=(3.0, 0.0, 0.0))
    for _ in range(3):
        dr.physics_view.step_randomization()
        get_app().update()
    # The first frame is number 0, which no interval divides.
    velocities = [prim.GetAttribute("physics:velocity").Get()[0] for prim in bodies]
    assert velocities == pytest.approx([2 * 3.0 / 0.5 / 60] * ENVS, rel=1e-3)


@pytest.fixture
def arms(stage):
    roots = [str(planar_arm(stage, f"/World/env_{i}/arm").GetPath()) for i in range(2)]
    old.physics_view.register_articulation_view(SimpleNamespace(prim_paths=roots, name="arms"))
    return roots


def test_joints_of_articulations_are_set(stage, arms):
    with old.trigger.on_rl_frame(num_envs=2), old.gate.on_env_reset():
        old.physics_view.randomize_articulation_view(
            "arms", operation="additive", joint_positions=(0.1, 0.2, 0.05), position=(0.0, 0.0, 1.0)
        )
        old.physics_view.randomize_articulation_view(
            "arms", joint_velocities=(0.6, 0.0, 0.0), stiffness=(1.0, 2.0, 3.0)
        )
    old.physics_view.step_randomization([1])
    robots = [get_articulations().at(path) for path in arms]
    assert robots[0].positions == pytest.approx([0, 0, 0])
    assert robots[1].positions == pytest.approx([0.1, 0.2, 0.05])
    assert robots[1].velocities == pytest.approx([0.6, 0, 0])
    assert at(stage.GetPrimAtPath(arms[1])) == pytest.approx([0, 0, 1])
    assert at(stage.GetPrimAtPath(f"{arms[1]}/base")) == pytest.approx([0, 0, 1])
    drive = UsdPhysics.DriveAPI(stage.GetPrimAtPath(f"{arms[1]}/elbow"), "angular")
    assert drive.GetStiffnessAttr().Get() == pytest.approx(2.0 * np.pi / 180)


def test_forces_of_joints_are_unsupported(arms):
    with (
        old.trigger.on_rl_frame(num_envs=2),
        old.gate.on_env_reset(),
        pytest.raises(Unsupported, match="/World/env_0/arm: joint_efforts of an articulation"),
    ):
        old.physics_view.randomize_articulation_view("arms", joint_efforts=(1.0, 1.0, 1.0))


def test_wrong_use_is_told_at_once(bodies):
    with pytest.raises(ArgumentError, match=r"inside of `with gate\.on_interval"):
        dr.physics_view.randomize_rigid_prim_view("bodies", position=(0.0, 0.0, 0.0))
    with pytest.raises(ArgumentError, match=r"make a trigger with trigger\.on_rl_frame first"):
        dr.gate.on_env_reset()
    with dr.trigger.on_rl_frame(num_envs=ENVS):
        with pytest.raises(ValueError, match="interval"):
            dr.gate.on_interval(interval=0)
        with dr.gate.on_env_reset():
            with pytest.raises(ValueError, match="no registered rigid prim view 'none'; registered: bodies"):
                dr.physics_view.randomize_rigid_prim_view("none", mass=1.0)
            with pytest.raises(ValueError, match="operation is 'add'"):
                dr.physics_view.randomize_rigid_prim_view("bodies", operation="add", mass=1.0)
            with pytest.raises(ValueError, match="no simulation context is registered"):
                dr.physics_view.randomize_simulation_context(gravity=(0.0, 0.0, 0.0))
    with pytest.raises(ArgumentError, match="not within 0 and num_envs"):
        dr.physics_view.step_randomization([ENVS])


def test_frames_of_the_orchestrator_do_not_randomize(bodies):
    with dr.trigger.on_rl_frame(num_envs=ENVS), dr.gate.on_interval(interval=1):
        dr.physics_view.randomize_rigid_prim_view("bodies", position=(5.0, 5.0, 5.0))
    orchestrator.preview()
    orchestrator.step()
    assert _positions(bodies)[:, 0] == pytest.approx([0, 1, 2])


def test_parameters_of_distributions_change_between_steps(bodies):
    drawn = distribution.uniform((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    with dr.trigger.on_rl_frame(num_envs=ENVS), dr.gate.on_env_reset():
        dr.physics_view.randomize_rigid_prim_view("bodies", position=drawn)
    dr.utils.set_distribution_params(drawn, {"upper": (7.0, 0.0, 0.0), "lower": (7.0, 0.0, 0.0)})
    dr.physics_view.step_randomization([0])
    assert at(bodies[0]) == pytest.approx([7, 0, 0])
    assert dr.utils.get_distribution_params(drawn, ["lower"]) == [(7.0, 0.0, 0.0)]
    with pytest.raises(ValueError, match="no parameter 'mean'"):
        dr.utils.get_distribution_params(drawn, ["mean"])
