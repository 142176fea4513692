"""Capture on play, pause and resume, status callbacks and randomized settings."""

from __future__ import annotations

import asyncio
import gc

import pytest

import usdsdg as rep
from usdsdg.app.app import get_app
from usdsdg.app.frame_loop import get_orchestrator
from usdsdg.app.status import Status
from usdsdg.session import stage_context
from usdsdg.session.settings_store import get_settings
from usdsdg.session.timeline import get_timeline


class Counting(rep.Writer):
    """Records the time of every frame that it receives."""

    def __init__(self) -> None:
        self.annotators = ["camera_params"]
        self.times: list[float] = []
        self.ended = 0

    def write(self, data) -> None:
        self.times.append(get_timeline().get_current_time())

    def on_final_frame(self) -> None:
        self.ended += 1


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


def test_pause_pauses_the_timeline_and_resume_plays_it(writer):
    rep.orchestrator.set_capture_on_play(False)
    rep.orchestrator.step()
    get_timeline().play()
    rep.orchestrator.pause()
    assert not get_timeline().is_playing()
    rep.orchestrator.resume()
    assert get_timeline().is_playing()
    assert rep.orchestrator.get_is_started()


def test_a_status_callback_lives_as_long_as_its_handle(writer):
    heard: list[Status] = []
    handle = rep.orchestrator.register_status_callback(heard.append)
    rep.orchestrator.step()
    assert heard == [Status.INITIALIZING, Status.STARTED, Status.STEPPING, Status.STEPPED]
    handle.unregister()
    rep.orchestrator.step()
    handle.register()
    rep.orchestrator.step()
    assert heard[4:] == [Status.STEPPING, Status.STEPPED]
    del handle
    gc.collect()
    rep.orchestrator.step()
    assert len(heard) == 6


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
