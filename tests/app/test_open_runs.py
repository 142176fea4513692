"""Runs that nothing ends but `stop`: coroutines begin them, and each update of the application captures a frame."""

import asyncio

import pytest

import usdsdg as rep
from tests.app.counting import Counting
from usdsdg.app.app import get_app
from usdsdg.app.status import Status
from usdsdg.orchestrator import OrchestratorError
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline


@pytest.fixture
def writer(stage):
    get_settings().set("/app/player/playSimulations", False)
    counting = Counting()
    counting.attach(rep.create.render_product(rep.create.camera(position=(5, 0, 0), look_at=(0, 0, 0)), (16, 12)))
    return counting


async def updates(count):
    for _ in range(count):
        await get_app().next_update_async()


async def begin(form, **arguments):
    if form == "run":
        rep.orchestrator.run(**arguments)
    else:
        await rep.orchestrator.run_async(**arguments)


FORMS = ["run", "run_async"]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("plays", [True, False])
def test_each_update_captures_a_frame_until_stop(writer, form, plays):
    """The timeline plays after the first frame, where capture on play is set."""
    rep.orchestrator.set_capture_on_play(plays)

    async def script():
        await begin(form)
        assert rep.orchestrator.get_status() is Status.STARTED
        assert writer.times == []
        await updates(4)
        rep.orchestrator.stop()
        assert rep.orchestrator.get_is_stopped()
        await updates(2)

    asyncio.run(script())
    assert writer.times == pytest.approx([0, 1 / 60, 2 / 60, 3 / 60] if plays else [0] * 4)
    assert writer.ended == 1


def test_a_run_can_start_the_timeline(writer):
    rep.orchestrator.set_capture_on_play(False)

    async def script():
        await rep.orchestrator.run_async(start_timeline=True)
        await updates(3)
        await rep.orchestrator.stop_async()

    asyncio.run(script())
    assert writer.times == pytest.approx([0, 1 / 60, 2 / 60])


def test_it_pauses_and_goes_on(writer):
    async def script():
        await rep.orchestrator.run_async()
        await updates(3)
        rep.orchestrator.pause()
        await updates(3)
        assert len(writer.times) == 3
        rep.orchestrator.resume()
        await updates(2)
        rep.orchestrator.stop()

    asyncio.run(script())
    assert writer.times == pytest.approx([0, 1 / 60, 2 / 60, 2 / 60, 3 / 60])


def test_events_fire_between_its_frames(writer):
    rep.orchestrator.set_capture_on_play(False)
    cube = rep.create.cube()
    with rep.trigger.on_custom_event("go"), cube:
        rep.modify.pose(position=rep.distribution.sequence([(1, 0, 0), (2, 0, 0)]))
    position = cube.get_output_prims()["prims"][0].GetAttribute("xformOp:translate")

    async def script():
        await rep.orchestrator.run_async()
        for count in (1, 2):
            rep.utils.send_og_event("go")
            await updates(1)
            assert position.Get()[0] == count
            await updates(1)
        rep.orchestrator.stop()

    asyncio.run(script())
    assert len(writer.times) == 4


def test_a_single_step_ends_it(writer):
    async def script():
        await rep.orchestrator.run_async()
        await rep.orchestrator.step_async()
        assert rep.orchestrator.get_status() is Status.STEPPED
        rep.orchestrator.set_capture_on_play(False)
        await updates(2)

    asyncio.run(script())
    assert len(writer.times) == 1


@pytest.mark.parametrize("plays", [True, False])
def test_after_a_step_resume_captures_updates(writer, plays):
    rep.orchestrator.set_capture_on_play(plays)
    for _ in range(2):
        rep.orchestrator.step(delta_time=0.5)
    rep.orchestrator.resume()
    for _ in range(3):
        get_app().update()
    rep.orchestrator.stop()
    assert writer.times == pytest.approx([0, 0.5, 0.5, *([0.5 + 1 / 60, 0.5 + 2 / 60] if plays else [0.5, 0.5])])
    assert not get_timeline().is_playing()


@pytest.mark.parametrize("form", FORMS)
def test_one_without_updates_is_an_error_where_it_is_waited_for(writer, form):
    asyncio.run(begin(form))
    with pytest.raises(OrchestratorError, match="nothing ends the run"):
        rep.orchestrator.wait_until_complete()
    asyncio.run(begin(form))
    rep.orchestrator.stop()
    assert writer.times == []


def test_a_script_that_ends_with_one_is_an_error(tmp_path):
    from tests import forked

    script = tmp_path / "script.py"
    script.write_text(
        "import asyncio\nimport omni.replicator.core as rep\n"
        "with rep.trigger.on_frame():\n    rep.create.cube()\n"
        "asyncio.ensure_future(rep.orchestrator.run_async())\n"
    )
    done = forked.run(["-m", "usdsdg", "run", str(script)], cwd=tmp_path)
    assert done.returncode == 1
    assert "nothing ends the run" in done.stderr
    assert "--frames N" in done.stderr
