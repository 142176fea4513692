"""Capture on play, pause and resume, status callbacks and randomized settings."""

from __future__ import annotations

import asyncio
import gc

import numpy as np
import pytest
from pxr import Gf, UsdGeom

import usdsdg as rep
from tests.app.counting import Counting
from usdsdg import functional
from usdsdg.app.app import get_app
from usdsdg.app.frame_loop import get_orchestrator
from usdsdg.app.status import Status
from usdsdg.session import stage_context
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline


@pytest.fixture
def writer(stage):
    camera = rep.create.camera(position=(5, 0, 0), look_at=(0, 0, 0))
    product = rep.create.render_product(camera, (16, 12))
    counting = Counting()
    counting.attach(product)
    return counting


def test_every_update_of_a_playing_timeline_is_one_frame(writer):
    get_app().update()
    get_timeline().play()
    for _ in range(3):
        get_app().update()
    get_timeline().pause()
    get_app().update()
    assert writer.times == pytest.approx([1 / 60, 2 / 60, 3 / 60])
    get_timeline().stop()
    assert writer.ended == 1
    assert rep.orchestrator.get_is_stopped()


def test_randomizers_fire_while_the_timeline_plays_without_a_writer(stage):
    cube = rep.create.cube()
    with rep.trigger.on_frame(), cube:
        rep.modify.pose(position=rep.distribution.sequence([(0, 0, i) for i in range(10)]))
    op = cube.get_output_prims()["prims"][0].GetAttribute("xformOp:translate")
    get_timeline().play()
    heights = []
    for _ in range(4):
        get_app().update()
        heights.append(op.Get()[2])
    assert heights == [0, 1, 2, 3]
    get_timeline().pause()
    get_app().update()
    assert op.Get()[2] == 3
    get_timeline().stop()
    rep.orchestrator.set_capture_on_play(False)
    get_timeline().play()
    get_app().update()
    assert op.Get()[2] == 3


def test_without_capture_on_play_only_steps_capture(writer):
    rep.orchestrator.set_capture_on_play(False)
    get_timeline().play()
    for _ in range(3):
        get_app().update()
    assert writer.times == []
    rep.orchestrator.step(delta_time=0.0)
    assert len(writer.times) == 1


def test_randomizers_fire_once_for_every_frame_captured_on_play(writer):
    cube = rep.create.cube()
    with rep.trigger.on_frame() as trigger, cube:
        rep.modify.pose(position=rep.distribution.sequence([(0, 0, i) for i in range(10)]))
    get_timeline().play()
    for _ in range(4):
        get_app().update()
    assert len(writer.times) == 4
    assert trigger._trigger.executions == 4


def test_the_timeline_stops_when_all_triggers_have_reached_their_limits(writer):
    """Scripts update the application while the timeline plays; it loops, so that nothing else would stop it."""
    with rep.trigger.on_frame(max_execs=5) as trigger, rep.create.cube():
        rep.modify.pose(position=rep.distribution.uniform((-1, -1, -1), (1, 1, 1)))
    get_timeline().set_looping(True)
    for count in (5, 10):
        get_timeline().play()
        for _ in range(20):
            get_app().update()
        assert get_timeline().is_stopped()
        assert (len(writer.times), trigger._trigger.executions, writer.ended) == (count, count, count // 5)
        assert rep.orchestrator.get_is_stopped()


def test_time_triggers_that_end_stop_the_timeline_before_the_next_interval(writer):
    rep.trigger.on_time(interval=0.1, max_execs=3)
    get_timeline().play()
    for _ in range(60):
        get_app().update()
    assert get_timeline().is_stopped()
    # The trigger ends at 0.3 s, the 18th update, which has no picture.
    assert writer.times == pytest.approx([count / 60 for count in range(1, 18)])


def test_triggers_without_limits_do_not_stop_the_timeline(writer):
    rep.trigger.on_frame(max_execs=2)
    rep.trigger.on_custom_event("go")
    get_timeline().play()
    for _ in range(4):
        get_app().update()
    assert get_timeline().is_playing()
    assert len(writer.times) == 4


def test_nothing_is_captured_without_a_writer_or_annotator(writer):
    writer.detach()
    get_timeline().play()
    get_app().update()
    assert get_orchestrator().captures == 0


def test_a_paused_run_continues_after_resume(writer):
    seen = []

    async def watch():
        while not writer.times:
            await asyncio.sleep(0)
        rep.orchestrator.pause()
        before = len(writer.times)
        assert rep.orchestrator.get_is_paused()
        for _ in range(20):
            await asyncio.sleep(0)
        seen.append(len(writer.times) - before)
        rep.orchestrator.resume()

    async def both():
        await asyncio.gather(watch(), rep.orchestrator.run_async(num_frames=3))

    asyncio.run(both())
    assert seen == [0]
    assert len(writer.times) == 3


def test_after_resume_a_frame_shows_the_time_of_the_pause_again(writer):
    """Replicator plays the timeline one update after it goes on, as at the start of a run."""
    get_timeline().play()
    for _ in range(3):
        get_app().update()
    rep.orchestrator.pause()
    assert rep.orchestrator.get_is_paused()
    assert not get_timeline().is_playing()
    for _ in range(2):
        get_app().update()
    rep.orchestrator.resume()
    assert not get_timeline().is_playing()
    for _ in range(3):
        get_app().update()
    assert get_timeline().is_playing()
    assert writer.times == pytest.approx([count / 60 for count in (1, 2, 3, 3, 4, 5)])


def test_a_run_that_is_resumed_shows_the_time_of_the_pause_again(writer):
    async def pause_once():
        while len(writer.times) < 3:
            await asyncio.sleep(0)
        rep.orchestrator.pause()
        await asyncio.sleep(0)
        rep.orchestrator.resume()

    async def both():
        await asyncio.gather(pause_once(), rep.orchestrator.run_async(num_frames=6))

    asyncio.run(both())
    assert writer.times == pytest.approx([count / 60 for count in (0, 1, 2, 2, 3, 4)])


def test_pause_leaves_a_timeline_alone_that_is_not_captured(writer):
    rep.orchestrator.set_capture_on_play(False)
    get_timeline().play()
    rep.orchestrator.step(pause_timeline=False)
    rep.orchestrator.pause()
    assert get_timeline().is_playing()
    assert rep.orchestrator.get_is_paused()
    rep.orchestrator.resume()
    rep.orchestrator.step(pause_timeline=False)
    assert rep.orchestrator.get_is_started()
    assert writer.times == pytest.approx([0, 1 / 60])


def test_pausing_and_playing_the_timeline_pauses_its_captures_and_goes_on(writer):
    get_timeline().play()
    get_app().update()
    get_timeline().pause()
    assert rep.orchestrator.get_is_paused()
    get_timeline().play()
    assert rep.orchestrator.get_is_started()
    get_app().update()
    assert writer.times == pytest.approx([1 / 60, 2 / 60])
    get_timeline().pause()
    rep.orchestrator.run(num_frames=2)
    assert len(writer.times) == 4


@pytest.mark.parametrize("frames", [4, 6])  # 6 times 1/60, one added to the other, is less than 6/60
def test_a_timeline_that_does_not_loop_stops_after_the_frame_of_its_end(writer, frames):
    get_timeline().set_looping(False)
    get_timeline().set_end_time(frames / 60)
    get_timeline().play()
    updates = 0
    while not get_timeline().is_stopped() and updates < 20:
        get_app().update()
        updates += 1
    assert writer.times == pytest.approx([count / 60 for count in range(1, frames + 1)])
    assert (updates, writer.ended, rep.orchestrator.get_is_stopped()) == (frames, 1, True)
    writer.times.clear()
    rep.orchestrator.run_until_complete(num_frames=20)
    assert writer.times == pytest.approx([count / 60 for count in range(frames + 1)])
    assert get_timeline().is_stopped()


def test_a_status_callback_lives_as_long_as_its_handle(writer):
    heard: list[Status] = []
    handle = rep.orchestrator.register_status_callback(heard.append)
    rep.orchestrator.step()
    assert heard == [Status.STARTING, Status.STEPPING, Status.STEPPED]
    handle.unregister()
    rep.orchestrator.step()
    handle.register()
    rep.orchestrator.step()
    assert heard[3:] == [Status.STEPPING, Status.STEPPED]
    rep.orchestrator.stop()
    assert heard[5:] == [Status.STOPPING, Status.STOPPED]
    rep.orchestrator.run_until_complete(num_frames=2)
    assert heard[7:] == [Status.STARTING, Status.STARTED, Status.STOPPING, Status.STOPPED]
    del handle
    gc.collect()
    rep.orchestrator.step()
    assert len(heard) == 11


def test_the_physics_time_step_is_read_from_and_written_to_the_stage():
    stage_context.new_stage()
    assert rep.settings.get_physx_timestep() == pytest.approx(1 / 60)
    rep.settings.set_physx_timestep(1 / 240)
    scene = stage_context.current_stage().GetPrimAtPath("/PhysicsScene")
    assert scene.GetAttribute("physxScene:timeStepsPerSecond").Get() == 240
    assert rep.settings.get_physx_timestep() == pytest.approx(1 / 240)
    with pytest.raises(ValueError, match="above 0"):
        rep.settings.set_physx_timestep(0)


def test_a_setting_is_drawn_at_every_firing(writer):
    with rep.trigger.on_frame():
        rep.settings.carb_settings("/rtx//wetness", rep.distribution.sequence([3, 5, 7]))
    values = []
    for _ in range(3):
        rep.orchestrator.step()
        values.append(get_settings().get("/rtx/wetness"))
    assert values == [3, 5, 7]


def test_steps_play_the_timeline_from_the_second_frame_on(writer):
    for _ in range(3):
        rep.orchestrator.step()
        assert not get_timeline().is_playing()
    assert writer.times == pytest.approx([0, 1 / 60, 2 / 60])
    rep.orchestrator.step(delta_time=0.0)
    assert writer.times[-1] == pytest.approx(2 / 60)
    rep.orchestrator.wait_until_complete()
    assert get_timeline().is_stopped()
    assert get_timeline().get_current_time() == 0.0


def test_steps_leave_the_timeline_alone_without_capture_on_play_or_with_auto_update_off(writer):
    get_timeline().set_auto_update(False)
    rep.orchestrator.step()
    rep.orchestrator.step()
    get_timeline().set_auto_update(True)
    rep.orchestrator.set_capture_on_play(False)
    rep.orchestrator.step()
    assert writer.times == [0.0, 0.0, 0.0]
    assert get_timeline().is_stopped()


def test_a_run_plays_the_timeline_and_stops_it(writer):
    rep.orchestrator.run_until_complete(num_frames=4)
    assert writer.times == pytest.approx([0, 1 / 60, 2 / 60, 3 / 60])
    assert get_timeline().is_stopped()
    rep.orchestrator.run_until_complete(num_frames=2)
    assert writer.times[4:] == pytest.approx([0, 1 / 60])


def test_bodies_fall_during_a_run(stage):
    ball = rep.create.sphere(position=(0, 0, 5))
    with ball:
        rep.physics.rigid_body()
    product = rep.create.render_product(rep.create.camera(position=(20, 0, 4), look_at=(0, 0, 4)), (32, 32))
    boxes = rep.annotators.get("bounding_box_3d").attach(product)
    rep.modify.semantics([("class", "ball")], input_prims=ball)
    heights = []
    rep.orchestrator.get_orchestrator().on_captured(
        lambda: heights.append(float(boxes.get_data()["data"]["transform"][0, 3, 2]))
    )
    rep.orchestrator.run_until_complete(num_frames=31)
    assert heights[0] == 5.0
    assert heights[-1] == pytest.approx(5 - 9.81 / 8, abs=0.05)


@pytest.mark.parametrize(("setter", "unit"), [(rep.modify.time, 1.0), (rep.modify.frame, 60.0)])
def test_pictures_show_the_time_that_was_drawn_for_them(stage, setter, unit):
    """A cube that moves a meter per second is as far from the camera, at 100 m, as the drawn time says."""
    cube = stage.DefinePrim("/World/moves", "Cube")
    place = UsdGeom.Xformable(cube).AddTranslateOp()
    for second in (0, 50):
        place.Set(Gf.Vec3d(second, 0, 0), second * stage.GetTimeCodesPerSecond())
    depth = rep.annotators.get("distance_to_image_plane")
    depth.attach(rep.create.render_product(rep.create.camera(position=(100, 0, 0), look_at=(0, 0, 0)), (9, 9)))
    times = [1.0, 0.5, get_timeline().get_end_time() + 3.0, 2.25]
    with rep.trigger.on_frame():
        setter(rep.distribution.sequence([time * unit for time in times]))
    seen = []
    for _ in times:
        rep.orchestrator.step()
        seen.append((get_timeline().get_current_time(), 99.0 - depth.get_data()[4, 4]))
    assert np.array(seen) == pytest.approx(np.array([(time, time) for time in times]), abs=1e-4)


def test_physics_goes_on_while_times_are_drawn(stage):
    functional.physics.create_physics_scene()
    cube = functional.create.cube(position=(0, 0, 10))
    functional.physics.apply_rigid_body(cube)
    rep.create.render_product(rep.create.camera(), (8, 8))
    with rep.trigger.on_frame():
        rep.modify.time(0.25)
    for _ in range(7):
        rep.orchestrator.step()
    # Six steps of 1/60 s; the first frame shows the scene as it was set up.
    fallen = 10 - cube.GetAttribute("xformOp:translate").Get()[2]
    assert fallen == pytest.approx(9.81 / 3600 * 6 * 7 / 2, rel=1e-3)
    assert get_timeline().get_current_time() == 0.25
