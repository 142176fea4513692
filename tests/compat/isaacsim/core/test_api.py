"""`isaacsim.core.api`, `.cloner`, `.rendering_manager` and `.version`."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics

from usdsdg.compat.isaacsim.core import version
from usdsdg.compat.isaacsim.core.api import SimulationContext, World, materials, objects
from usdsdg.compat.isaacsim.core.api.tasks import BaseTask
from usdsdg.compat.isaacsim.core.cloner import Cloner, GridCloner
from usdsdg.compat.isaacsim.core.rendering_manager import RenderingManager, ViewportManager
from usdsdg.compat.omni.kit.app import get_app
from usdsdg.compat.omni.kit.viewport.utility import get_active_viewport
from usdsdg.compat.omni.timeline import TimelineEventType
from usdsdg.compat.omni.usd import StageEventType, get_context
from usdsdg.errors import BadPrim
from usdsdg.session import stage_context
from usdsdg.session.timeline import get_timeline

G = 9.81


@pytest.fixture
def world(stage):
    SimulationContext.clear_instance()
    yield World(stage_units_in_meters=1.0)
    World.clear_instance()


def test_a_world_falls_steps_and_is_reset(world):
    cube = world.scene.add(objects.DynamicCuboid("/World/cube", name="cube", position=np.array([0, 0, 5.0]), mass=1.0))
    world.reset()
    assert world.is_playing()
    np.testing.assert_allclose(cube.get_world_pose()[0], (0, 0, 5), atol=1e-6)
    for _ in range(10):
        world.step(render=False)
    fallen = 5.0 - cube.get_world_pose()[0][2]
    # Between the explicit and the implicit sum of steps of 1/60 s.
    assert G / 3600 * 45 - 1e-3 <= fallen <= G / 3600 * 55 + 1e-3
    time = world.current_time
    world.step()
    assert world.current_time == pytest.approx(time + 1 / 60)
    world.reset()
    np.testing.assert_allclose(cube.get_world_pose()[0], (0, 0, 5), atol=1e-6)
    np.testing.assert_allclose(cube.get_linear_velocity(), (0, 0, 0), atol=1e-6)


def test_there_is_one_world_until_it_is_cleared_or_the_stage_is_replaced(world):
    with pytest.warns(UserWarning, match="already"):
        assert World(physics_dt=0.5) is world
    assert world.get_physics_dt() == pytest.approx(1 / 60)
    stage_context.new_stage()
    assert World.instance() is None


def test_rendering_takes_time_and_holds_physics(world):
    ball = objects.DynamicSphere("/World/ball", position=(0, 0, 5))
    world.set_simulation_dt(physics_dt=1 / 120, rendering_dt=1 / 30)
    world.reset()
    steps = world.current_time_step_index
    world.render()
    assert world.current_time_step_index == steps
    world.step()
    assert world.current_time_step_index == steps + 4
    assert ball.get_world_pose()[0][2] < 5


def test_updates_of_no_length_leave_the_timeline_and_follow_one_physics_step_each(world):
    ball = objects.DynamicSphere("/World/ball", position=(0, 0, 5))
    world.reset()
    world.set_simulation_dt(physics_dt=1 / 50, rendering_dt=0)
    assert (world.get_rendering_dt(), world.get_physics_dt()) == (0.0, pytest.approx(1 / 50))
    time, steps = get_timeline().get_current_time(), world.current_time_step_index
    simulated, height = world.current_time, ball.get_world_pose()[0][2]
    world.render()
    assert world.current_time_step_index == steps
    for render in (True, False, True):
        world.step(render=render)
    assert world.current_time_step_index == steps + 3
    assert world.current_time == pytest.approx(simulated + 3 / 50)
    assert get_timeline().get_current_time() == time
    assert ball.get_world_pose()[0][2] < height
    world.pause()
    world.step()
    assert world.current_time_step_index == steps + 3
    world.play()
    world.set_simulation_dt(physics_dt=1 / 60, rendering_dt=1 / 60)
    assert world.get_rendering_dt() == pytest.approx(1 / 60)
    time = get_timeline().get_current_time()
    world.step()
    assert get_timeline().get_current_time() == pytest.approx(time + 1 / 60)
    assert world.current_time_step_index == steps + 4
    with pytest.raises(ValueError, match="negative"):
        world.set_simulation_dt(rendering_dt=-1)


def test_render_callbacks_and_updates_of_the_application_have_the_length_that_was_set(world):
    heard = []
    world.add_render_callback("heard", lambda event: heard.append(event.payload["dt"]))
    world.reset()
    heard.clear()
    world.set_simulation_dt(rendering_dt=0.0)
    time = get_timeline().get_current_time()
    world.render()
    get_app().update()
    assert asyncio.run(get_app().next_update_async()) == 0.0
    assert heard == [0.0, 0.0, 0.0]
    assert get_timeline().get_current_time() == time
    world.set_simulation_dt(rendering_dt=1 / 30)
    world.render()
    assert heard[3:] == [pytest.approx(1 / 30)]
    assert get_timeline().get_current_time() == pytest.approx(time + 1 / 30)


def test_a_physics_step_of_no_length_holds_physics_at_steps(world):
    ball = objects.DynamicSphere("/World/ball", position=(0, 0, 5))
    world.reset()
    time, height = world.current_time, ball.get_world_pose()[0][2]
    world.set_simulation_dt(physics_dt=0.0, rendering_dt=1 / 60)
    for render in (True, False):
        world.step(render=render)
    assert ball.get_world_pose()[0][2] == height
    assert world.get_physics_dt() == 0.0
    world.set_simulation_dt(physics_dt=1 / 60)
    world.step()
    assert ball.get_world_pose()[0][2] < height
    assert world.current_time > time


def test_callbacks_have_names(world):
    heard = []
    world.add_physics_callback("mine", heard.append)
    with pytest.warns(UserWarning, match="already"):
        world.add_physics_callback("mine", print)
    world.reset()
    world.step(render=False)
    assert heard == [pytest.approx(1 / 60)]
    assert world.physics_callback_exists("mine")
    world.remove_physics_callback("mine")
    world.step(render=False)
    assert len(heard) == 1


def test_callbacks_of_timeline_and_stage_get_events_with_types(world):
    heard = []
    world.add_timeline_callback("times", lambda event: heard.append(TimelineEventType(event.type).name))
    world.play()
    get_app().update()
    world.stop()
    assert heard[0] == "PLAY"
    assert heard[-1] == "STOP"
    assert "CURRENT_TIME_TICKED" in heard
    world.remove_timeline_callback("times")
    heard.clear()
    world.add_stage_callback("stages", lambda event: heard.append(event.type))
    assert world.stage_callback_exists("stages")
    get_context().get_selection().set_selected_prim_paths(["/World"], True)
    assert heard == [StageEventType.SELECTION_CHANGED]
    world.remove_stage_callback("stages")
    get_context().get_selection().clear_selected_prim_paths()
    world.play()
    assert len(heard) == 1


def test_tasks_are_set_up_once_and_reset(world):
    calls = []

    class Mine(BaseTask):
        def set_up_scene(self, scene):
            super().set_up_scene(scene)
            calls.append("set up")

        def pre_step(self, time_step_index, simulation_time):
            calls.append("step")

        def get_observations(self):
            return {"x": 1}

    world.add_task(Mine("mine"))
    world.reset()
    world.step(render=False)
    world.reset()
    assert calls == ["set up", "step"]
    assert world.get_observations() == {"x": 1}
    with pytest.raises(KeyError, match="no task 'other'"):
        world.get_task("other")


def test_tasks_are_prepared_before_physics_steps_of_updates(world):
    """As samples do it, which run on updates of the application and never call `step`."""
    from usdsdg.app.app import get_app

    prepared = []

    class Mine(BaseTask):
        def pre_step(self, time_step_index, simulation_time):
            prepared.append(round(simulation_time, 4))

    world.add_task(Mine("mine"))
    world.reset()
    world.add_physics_callback("tasks", world.step_async)
    world.get_data_logger().add_data_frame_logging_func(lambda tasks, scene: {"tasks": len(tasks)})
    world.get_data_logger().start()
    began = world.current_time
    world.play()
    for _ in range(3):
        get_app().update()
    np.testing.assert_allclose(np.diff(prepared), 1 / 60, atol=1e-3)
    assert len(prepared) == 3
    assert prepared[0] == pytest.approx(began, abs=1e-3)
    assert world.get_data_logger().get_num_of_data_frames() == 3
    assert world.get_data_logger().get_data_frame(2).data == {"tasks": 1}


def test_scenes_hold_objects_by_name(world):
    ground = world.scene.add_ground_plane(size=4.0, z_position=-1.0)
    assert ground.collision_geometry_prim.get_collision_enabled()
    assert world.scene.get_object("ground_plane") is ground
    np.testing.assert_allclose(ground.get_world_pose()[0], (0, 0, -1), atol=1e-6)
    world.scene.enable_bounding_boxes_computations()
    np.testing.assert_allclose(world.scene.compute_object_AABB("ground_plane")[:, :2], [(-4, -4), (4, 4)])
    with pytest.raises(ValueError, match="already"):
        world.scene.add(objects.VisualCuboid("/World/c", name="ground_plane"))
    world.scene.remove_object("ground_plane")
    assert not world.scene.object_exists("ground_plane")
    assert not world.stage.GetPrimAtPath("/World/groundPlane")


def test_awaited_clocks_do_what_the_others_do(world):
    from usdsdg.app.app import get_app

    async def work():
        await world.reset_async()
        await world.stop_async()

    get_app().run_until_complete(work())
    assert world.is_stopped()


@pytest.mark.parametrize("kind", ["Cuboid", "Sphere", "Cylinder", "Cone", "Capsule"])
def test_objects_are_seen_fixed_or_dynamic(stage, kind):
    sizes = {"size": 2.0} if kind == "Cuboid" else {"radius": 2.0}
    visual = getattr(objects, f"Visual{kind}")("/World/v", color=np.array([1, 0, 0]), **sizes)
    fixed = getattr(objects, f"Fixed{kind}")("/World/f", position=(1, 2, 3))
    dynamic = getattr(objects, f"Dynamic{kind}")("/World/d", linear_velocity=(0, 0, 1))
    assert visual.get_applied_visual_material().get_color().tolist() == [1, 0, 0]
    assert not visual.get_collision_enabled()
    assert fixed.get_collision_enabled()
    assert fixed.get_applied_physics_material().get_static_friction() == pytest.approx(0.2)
    assert (dynamic.get_mass(), dynamic.get_collision_enabled()) == (pytest.approx(0.02), True)
    assert dynamic.get_linear_velocity().tolist() == [0, 0, 1]
    ((name, value),) = sizes.items()
    assert getattr(visual, f"get_{name}")() == value
    assert max(visual.geom.GetExtentAttr().Get()[1]) >= value / 2
    with pytest.raises(TypeError, match="no width"):
        getattr(objects, f"Visual{kind}")("/World/w", width=1.0)
    with pytest.raises(BadPrim, match="not a"):
        getattr(objects, f"Visual{kind}")("/World")


def test_materials_have_their_values(stage):
    paint = materials.OmniPBR("/World/paint", color=np.array([0.1, 0.2, 0.3]))
    assert (paint.get_project_uvw(), paint.get_reflection_roughness()) == (True, 0.5)
    np.testing.assert_allclose(paint.get_color(), (0.1, 0.2, 0.3), rtol=1e-6)
    glass = materials.OmniGlass("/World/glass", ior=1.5, thin_walled=True)
    assert (glass.get_ior(), glass.get_thin_walled(), glass.get_color()) == (1.5, True, None)
    assert type(materials.material_at("/World/glass")) is materials.OmniGlass
    with pytest.raises(BadPrim, match="not a material"):
        materials.PreviewSurface("/World")


@pytest.mark.parametrize(("axis", "ground"), [("Z", [0, 1]), ("Y", [0, 2])])
def test_clones_stand_in_a_grid_around_the_origin(stage, axis, ground):
    UsdGeom.SetStageUpAxis(stage, axis)
    UsdGeom.Cube.Define(stage, "/World/envs/env_0").AddScaleOp().Set((1, 2, 3))
    cloner = GridCloner(spacing=2.0)
    paths = cloner.generate_paths("/World/envs/env", 6)
    places = np.array(cloner.clone("/World/envs/env_0", paths))
    np.testing.assert_allclose(places.mean(axis=0), (0, 0, 0), atol=1e-12)
    assert places[:, ({0, 1, 2} - set(ground)).pop()].tolist() == [0] * 6
    assert np.ptp(places[:, ground], axis=0).tolist() == [4, 2]
    last = UsdGeom.Xformable(stage.GetPrimAtPath(paths[-1]))
    matrix = last.ComputeLocalToWorldTransform(0)
    np.testing.assert_allclose(matrix.ExtractTranslation(), places[-1])
    assert Gf.IsClose(matrix.TransformDir(Gf.Vec3d(0, 0, 1)), Gf.Vec3d(0, 0, 3), 1e-6)
    assert last.GetPrim().IsA(UsdGeom.Cube)


def test_clones_follow_their_source_unless_they_are_copies(stage):
    source = UsdGeom.Cube.Define(stage, "/World/a")
    Cloner().clone("/World/a", ["/World/b"], positions=[(1, 0, 0)])
    Cloner().clone("/World/a", ["/World/c"], positions=np.array([(2, 0, 0)]), copy_from_source=True)
    source.CreateSizeAttr(5.0)
    assert [UsdGeom.Cube(stage.GetPrimAtPath(f"/World/{each}")).GetSizeAttr().Get() for each in "bc"] == [5, 2]
    with pytest.raises(ValueError, match="2 poses are given for 1"):
        Cloner().clone("/World/a", ["/World/d"], positions=np.zeros((2, 3)))


def test_copies_do_not_collide_with_each_other(stage):
    UsdPhysics.Scene.Define(stage, "/scene")
    Cloner().filter_collisions("/scene", "/World/groups", ["/World/a", "/World/b"], ["/World/ground"])
    first = UsdPhysics.CollisionGroup(stage.GetPrimAtPath("/World/groups/group0"))
    assert first.GetFilteredGroupsRel().GetTargets() == ["/World/groups/group1"]
    assert first.GetCollidersCollectionAPI().GetIncludesRel().GetTargets() == ["/World/a"]


def test_a_camera_view_keeps_its_center_of_interest(stage):
    camera = UsdGeom.Camera.Define(stage, "/World/camera").GetPrim()
    ViewportManager.set_camera_view("/World/camera", eye=(0, 0, 5), target=(0, 5, 5))
    looks_at = lambda: UsdGeom.XformCache().GetLocalToWorldTransform(camera).TransformDir(Gf.Vec3d(0, 0, -1))  # noqa: E731
    assert Gf.IsClose(looks_at(), Gf.Vec3d(0, 1, 0), 1e-6)
    from pxr import Sdf

    interest = camera.CreateAttribute("omni:kit:centerOfInterest", Sdf.ValueTypeNames.Vector3d)
    interest.Set((0, 5, 5))  # in the world, as Isaac Sim has it here
    ViewportManager.set_camera_view(camera, target=(1, 5, 5), relative_tracking=True)
    assert interest.Get() == (1, 5, 5)
    position = UsdGeom.XformCache().GetLocalToWorldTransform(camera).ExtractTranslation()
    np.testing.assert_allclose(position, (1, 0, 5), atol=1e-6)
    # It looks at the target also if it looked elsewhere before: here from (1, 0, 5) + (4, 5, 5) - (1, 5, 5).
    interest.Set((1, 5, 5))
    UsdGeom.XformCommonAPI(camera).SetRotate((0, 0, 0))
    ViewportManager.set_camera_view(camera, target=(4, 5, 5), relative_tracking=True)
    position = UsdGeom.XformCache().GetLocalToWorldTransform(camera).ExtractTranslation()
    np.testing.assert_allclose(position, (4, 0, 5), atol=1e-6)
    assert Gf.IsClose(looks_at(), Gf.Vec3d(0, 1, 0), 1e-6)
    ViewportManager.set_camera("/World/camera")
    assert ViewportManager.get_camera().GetPath() == "/World/camera"
    ViewportManager.set_resolution((640, 480))
    assert ViewportManager.get_resolution() == (640, 480)


def test_the_viewport_and_its_render_product_have_one_camera_and_resolution(stage):
    viewport = get_active_viewport()
    path = viewport.render_product_path
    stage.DefinePrim("/World/camera", "Camera")
    for number, target in enumerate((path, None, stage.GetPrimAtPath(path), "Viewport", viewport)):
        ViewportManager.set_resolution((64, 32 + number), render_product_or_viewport=target)
        assert viewport.resolution == ViewportManager.get_resolution() == (64, 32 + number)
        assert ViewportManager.get_resolution(path) == (64, 32 + number)
        assert ViewportManager.get_render_product(target).GetPath() == path
    assert ViewportManager.get_viewport_api(path) is None
    ViewportManager.set_camera("/World/camera", render_product_or_viewport=path)
    assert viewport.camera_path == "/World/camera"


def test_a_misspelled_render_product_is_not_the_viewport(stage):
    for wrong in ("/Render/nothing", "Viewport 2", stage.GetPrimAtPath("/World")):
        with pytest.raises(BadPrim, match="no render product"):
            ViewportManager.set_resolution((64, 32), render_product_or_viewport=wrong)
        with pytest.raises(BadPrim, match="no render product"):
            ViewportManager.get_resolution(wrong)
        assert ViewportManager.get_render_product(wrong) is None
        assert ViewportManager.get_viewport_api(wrong) is None
    assert ViewportManager.get_resolution() == (1280, 720)


def test_the_viewports_camera_moves_although_it_is_in_the_session_layer(stage):
    get_active_viewport().get_render_product_path()
    ViewportManager.set_camera_view("/OmniverseKit_Persp", eye=(1, 2, 3), target=(0, 0, 0))
    camera = stage.GetPrimAtPath("/OmniverseKit_Persp")
    assert UsdGeom.XformCache().GetLocalToWorldTransform(camera).ExtractTranslation() == Gf.Vec3d(1, 2, 3)


def test_rendering_updates_the_app_without_physics(stage):
    RenderingManager.set_dt(0.05)
    get_timeline().play()
    RenderingManager.render()
    assert get_timeline().get_current_time() == pytest.approx(0.05)
    assert RenderingManager.get_dt() == pytest.approx(0.05)


def test_versions_are_split_into_parts():
    parsed = version.parse_version("4.5.0-rc.36+release.1")
    assert (parsed.core, parsed.prerelease, parsed.buildtag) == ("4.5.0", "rc.36", "release.1")
    assert (parsed.major, parsed.patch, parsed.pretag, parsed.prebuild) == ("4", "0", "rc", "36")
    assert version.get_version()[2] == "6"
