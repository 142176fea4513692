"""`isaacsim.core.simulation_manager`."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import UsdGeom

from usdsdg.compat.isaacsim.core.experimental.objects import Cube
from usdsdg.compat.isaacsim.core.experimental.prims import GeomPrim, RigidPrim
from usdsdg.compat.isaacsim.core.simulation_manager import (
    IsaacEvents,
    PhysicsScene,
    PhysxGpuCfg,
    PhysxScene,
    SimulationEvent,
    SimulationManager,
)
from usdsdg.errors import Unsupported
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline


def falling_cube():
    Cube("/World/a", sizes=1.0, positions=(0, 0, 10))
    GeomPrim("/World/a", apply_collision_apis=True)
    return RigidPrim("/World/a", masses=1.0)


def test_steps_move_bodies_and_leave_the_timeline(stage):
    body = falling_cube()
    SimulationManager.setup_simulation(dt=0.01)
    assert SimulationManager.get_physics_dt() == pytest.approx(0.01)
    SimulationManager.initialize_physics()
    SimulationManager.initialize_physics()  # once
    assert SimulationManager.get_num_physics_steps() == 1
    seen = []
    SimulationManager.step(steps=10, callback=lambda number, steps: seen.append(number) or number < 4)
    assert seen == [1, 2, 3, 4]
    assert SimulationManager.get_simulation_time() == pytest.approx(0.05)
    assert body.get_velocities()[0].numpy()[0, 2] == pytest.approx(-9.81 * 0.05, rel=1e-3)
    assert get_timeline().get_current_time() == 0.0
    assert get_timeline().is_stopped()


def test_the_rate_is_whole_and_cannot_change_while_the_timeline_plays(stage):
    SimulationManager.set_physics_dt(1.0 / 90.0)
    (scene,) = SimulationManager.get_physics_scenes()
    assert (scene.path, scene.get_steps_per_second()) == ("/PhysicsScene", 90)
    get_timeline().play()
    with pytest.raises(RuntimeError, match="plays"):
        SimulationManager.set_physics_dt(0.01)
    get_timeline().stop()
    with pytest.raises(ValueError, match="within 0 and 1"):
        SimulationManager.set_physics_dt(2.0)


def test_callbacks_of_steps_are_called_before_and_after_in_order(stage):
    body = falling_cube()
    heard = []
    height = lambda: float(body.get_world_poses()[0].numpy()[0, 2])  # noqa: E731
    register = SimulationManager.register_callback
    register(lambda dt, _: heard.append(("after", height())), SimulationEvent.PHYSICS_POST_STEP)
    first = register(lambda dt, _: heard.append(("first", dt)), IsaacEvents.PRE_PHYSICS_STEP, order=-1)
    register(lambda dt, _: heard.append(("before", height())), SimulationEvent.PHYSICS_PRE_STEP)
    SimulationManager.initialize_physics()
    assert heard == []  # the step that warms physics up has no callbacks
    SimulationManager.step()
    assert [name for name, _ in heard] == ["first", "before", "after"]
    assert heard[2][1] < heard[1][1]
    assert SimulationManager.deregister_callback(first)
    with pytest.warns(UserWarning, match="no such callback"):
        assert not SimulationManager.deregister_callback(first)
    heard.clear()
    SimulationManager.step()
    assert [name for name, _ in heard] == ["before", "after"]
    with pytest.raises(Unsupported, match="IsValid"):
        register(print, SimulationEvent.PRIM_DELETED)


def test_the_timeline_sends_the_events_of_the_simulation(stage):
    heard = []
    for event in (
        IsaacEvents.PHYSICS_READY, SimulationEvent.SIMULATION_STARTED, SimulationEvent.SIMULATION_PAUSED,
        SimulationEvent.SIMULATION_RESUMED, SimulationEvent.SIMULATION_STOPPED,
    ):  # fmt: skip
        SimulationManager.register_callback(lambda _, name=event.name: heard.append(name), event)
    timeline = get_timeline()
    for command in (timeline.play, timeline.pause, timeline.play, timeline.stop):
        command()
    assert heard == [
        "PHYSICS_READY", "SIMULATION_STARTED", "SIMULATION_PAUSED", "SIMULATION_RESUMED", "SIMULATION_STOPPED",
    ]  # fmt: skip


def test_gravity_is_in_stage_units(stage):
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    scene = PhysicsScene("/scene")
    np.testing.assert_allclose(scene.get_gravity(), (0, 0, -981), rtol=1e-5)
    scene.set_gravity((0, -300, -400))
    np.testing.assert_allclose(scene.get_gravity(), (0, -300, -400), rtol=1e-5)
    assert scene.physics_scene.GetGravityMagnitudeAttr().Get() == pytest.approx(500)
    scene.set_gravity((0, 0, 0))
    assert tuple(scene.get_gravity()) == (0, 0, 0)
    with pytest.raises(ValueError, match="TGS"):
        scene.set_solver_type("XPBD")
    stage.DefinePrim("/World/cube", "Cube")
    with pytest.raises(ValueError, match="no PhysicsScene but a Cube"):
        PhysicsScene("/World/cube")


def test_sizes_of_the_buffers_of_a_gpu_are_kept_on_the_stage(stage):
    scene = PhysxScene("/scene")
    assert scene.get_gpu_configuration() == PhysxGpuCfg(
        gpu_collision_stack_size=67108864, gpu_found_lost_aggregate_pairs_capacity=1024,
        gpu_found_lost_pairs_capacity=262144, gpu_heap_capacity=67108864, gpu_max_deformable_surface_contacts=1048576,
        gpu_max_num_partitions=8, gpu_max_particle_contacts=1048576, gpu_max_rigid_contact_count=524288,
        gpu_max_rigid_patch_count=81920, gpu_max_soft_body_contacts=1048576, gpu_temp_buffer_capacity=16777216,
        gpu_total_aggregate_pairs_capacity=1024,
    )  # fmt: skip
    scene.set_gpu_configuration(PhysxGpuCfg(gpu_max_num_partitions=16))
    scene.set_gpu_configuration({"gpu_temp_buffer_capacity": 2**33})
    assert scene.prim.GetAttribute("physxScene:gpuMaxNumPartitions").Get() == 16
    assert scene.prim.GetAttribute("physxScene:gpuTempBufferCapacity").Get() == 2**33
    assert scene.get_gpu_configuration().gpu_max_num_partitions == 16
    assert not scene.prim.GetAttribute("physxScene:gpuHeapCapacity").HasAuthoredValue()
    with pytest.raises(TypeError, match="gpu_heap"):
        scene.set_gpu_configuration({"gpu_heap": 1})


def test_the_default_engine_is_the_one_that_a_setting_names():
    assert SimulationManager.get_default_engine() == "newton"
    get_settings().set("/exts/isaacsim.core.simulation_manager/default_engine", "physx")
    assert SimulationManager.get_default_engine() == "physx"
