"""Each function of `rep.orchestrator`, in its synchronous and asynchronous form."""

import asyncio
import math

import pytest

import usdsdg as rep
from tests.app.counting import Counting
from usdsdg.app.app import get_app
from usdsdg.app.status import Status
from usdsdg.orchestrator import OrchestratorError
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline


@pytest.fixture
def writer(stage, monkeypatch):
    """A writer attached to a camera of a new stage, with playSimulations off."""
    from usdsdg.session import engines

    monkeypatch.setattr(engines, "physics", lambda: type("Still", (), {"play": lambda self, time=None: None})())
    get_settings().set("/app/player/playSimulations", False)
    rep.orchestrator.set_capture_on_play(False)
    counting = Counting()
    counting.attach(rep.create.render_product(rep.create.camera(position=(5, 0, 0), look_at=(0, 0, 0)), (16, 12)))
    return counting


# Call either form of each function as a plain call.
FORMS = ["standalone", "asynchronous"]


def call(form, name, *args, **kwargs):
    if form == "standalone":
        return getattr(rep.orchestrator, name)(*args, **kwargs)
    return asyncio.run(getattr(rep.orchestrator, f"{name}_async")(*args, **kwargs))


def states():
    queries = (rep.orchestrator.get_is_stopped, rep.orchestrator.get_is_started, rep.orchestrator.get_is_paused)
    return [query() for query in queries]


@pytest.mark.parametrize("form", FORMS)
def test_a_step_captures_one_frame_and_the_run_continues_until_stop(writer, form):
    assert states() == [True, False, False]
    for count in (1, 2):
        call(form, "step")
        assert len(writer.times) == count
        assert states() == [False, True, False]
    assert rep.orchestrator.get_status() is Status.STEPPED
    assert writer.ended == 0
    call(form, "stop")
    assert states() == [True, False, False]
    assert writer.ended == 1


@pytest.mark.parametrize("form", FORMS)
def test_waiting_until_complete_ends_the_run(writer, form):
    call(form, "step")
    call(form, "wait_until_complete")
    assert writer.ended == 1
    assert rep.orchestrator.get_is_stopped()
    assert rep.orchestrator.get_sim_times_to_write() == []


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", ["run", "run_until_complete"])
def test_a_run_has_its_number_of_frames_or_that_of_its_triggers(writer, form, name):
    call(form, name, num_frames=3)
    assert len(writer.times) == 3
    assert rep.orchestrator.get_is_stopped()
    trigger = rep.trigger.on_frame(max_execs=2)
    call(form, name)
    assert len(writer.times) == 5
    assert trigger.executions == 2
    call(form, name, num_frames=0)
    assert len(writer.times) == 5


@pytest.mark.parametrize("num_frames", [None, 20])
@pytest.mark.parametrize(("limits", "frames"), [([(2, 3)], 6), ([(3, 1), (1, 2)], 3), ([(2, 3), (3, 3)], 9)])
def test_a_run_shows_the_last_draw_for_as_many_frames_as_the_others(writer, num_frames, limits, frames):
    """In Replicator a run ends when its triggers would fire once more; the preview has drawn the first frame."""
    for interval, max_execs in limits:
        rep.trigger.on_frame(interval=interval, max_execs=max_execs)
    for run in (1, 2):
        rep.orchestrator.run_until_complete(num_frames=num_frames)
        assert len(writer.times) == run * frames


@pytest.mark.parametrize("form", FORMS)
def test_run_and_run_until_complete_are_one_run(writer, form):
    """In Replicator `run` returns when the run has begun, and `run_until_complete` waits for the end of that one."""
    trigger = rep.trigger.on_frame(max_execs=3)
    call(form, "run")
    call(form, "run_until_complete")
    assert (len(writer.times), writer.ended, trigger.executions) == (3, 1, 3)
    call(form, "run_until_complete")
    assert len(writer.times) == 6
    call(form, "run")
    call(form, "run_until_complete", num_frames=1)
    assert len(writer.times) == 10


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("between", ["wait_until_complete", "get_is_stopped", "get_is_started", "stop"])
def test_a_run_that_a_script_has_waited_for_is_another_one(writer, form, between):
    rep.trigger.on_frame(max_execs=3)
    call(form, "run")
    call("standalone" if between.startswith("get") else form, between)
    call(form, "run_until_complete")
    assert len(writer.times) == 6


@pytest.mark.parametrize("form", FORMS)
def test_scripts_that_wait_for_the_start_and_the_end_of_a_run_go_on(writer, form):
    for count in (2, 4):
        call(form, "run", num_frames=2)
        updates = 0
        while not rep.orchestrator.get_is_started():
            updates += 1
            assert updates < 10
            get_app().update()
        while rep.orchestrator.get_is_started():
            updates += 1
            assert updates < 10
            get_app().update()
        assert len(writer.times) == count
        assert states() == [True, False, False]
    call(form, "run", num_frames=1)
    call(form, "stop")
    assert not rep.orchestrator.get_is_started()


@pytest.mark.parametrize("form", FORMS)
def test_a_run_can_start_the_timeline(writer, form):
    call(form, "run", num_frames=3, start_timeline=True)
    # The first captured frame does not advance the timeline.
    assert writer.times == pytest.approx([0, 1 / 60, 2 / 60])
    get_timeline().stop()
    call(form, "run", num_frames=2)
    assert writer.times[3:] == [0, 0]


@pytest.mark.parametrize("form", FORMS)
def test_a_preview_draws_without_capturing(writer, form):
    cube = rep.create.cube()
    with rep.trigger.on_frame(), cube:
        item = rep.modify.pose(position=rep.distribution.sequence([(1, 0, 0), (2, 0, 0), (3, 0, 0)]))
    for count in (1, 2):
        call(form, "preview")
        assert item.get_output("execCount") == count
    assert writer.times == []


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("wait_for_render", [True, False])
def test_a_step_advances_a_playing_timeline_by_delta_time(writer, form, wait_for_render):
    get_timeline().play()
    for delta in (0.5, None, 0.0, 0.25):
        call(form, "step", delta_time=delta, wait_for_render=wait_for_render)
    # The first captured frame does not advance the timeline; None is one time code.
    assert writer.times == pytest.approx([0, 1 / 60, 1 / 60, 1 / 60 + 0.25])


@pytest.mark.parametrize("form", FORMS)
def test_a_stopped_timeline_advances_only_by_a_delta_time(writer, form):
    # Isaac Sim's structured light camera goes through its patterns in this way, without playing.
    for delta in (0.25, 0.25, None, 0.0, 0.125):
        call(form, "step", delta_time=delta)
        assert get_timeline().is_stopped()
    assert writer.times == [0, 0.25, 0.25, 0.25, 0.375]


def test_a_step_without_play_shows_the_animation_at_its_time_and_simulates_nothing(stage):
    ball = stage.DefinePrim("/World/ball", "Sphere")
    stage.SetTimeCodesPerSecond(10)
    ball.GetAttribute("radius").Set(1.0, 0)
    ball.GetAttribute("radius").Set(2.0, 10)
    stage.DefinePrim("/World/body", "Cube")
    rep.physics.rigid_body(input_prims="/World/body")
    camera = rep.create.camera(position=(10, 0, 0), look_at=(0, 0, 0))
    rep.modify.semantics([("class", "ball")], input_prims="/World/ball")
    boxes = rep.annotators.get("bounding_box_3d")
    boxes.attach(rep.create.render_product(camera, (16, 16)))
    sizes = []
    for _ in range(2):
        rep.orchestrator.step(delta_time=0.5)
        sizes.append(boxes.get_data()["data"]["x_max"][0])
    assert sizes == pytest.approx([1.0, 1.5])
    assert not stage.GetPrimAtPath("/World/body").HasAttribute("xformOp:translate")


@pytest.mark.parametrize("form", FORMS)
def test_the_total_of_a_run_is_forgotten_at_its_end(writer, form, monkeypatch):
    reported = []
    monkeypatch.setattr("usdsdg.capture.capture.report_frames", lambda done, total: reported.append((done, total)))
    call(form, "run_until_complete", num_frames=2)
    for _ in range(2):
        call(form, "step")
    call(form, "run_until_complete", num_frames=1)
    assert reported == [(1, 2), (2, 2), (3, None), (4, None), (1, 1)]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("pause", [True, False])
def test_the_timeline_pauses_after_a_step_unless_pause_timeline_is_false(writer, form, pause):
    get_timeline().play()
    for _ in range(2):
        call(form, "step", pause_timeline=pause)
        assert get_timeline().is_playing() is not pause
    assert writer.times == pytest.approx([0, 1 / 60])


def test_pausing_before_a_run_does_nothing(writer):
    rep.orchestrator.pause()
    assert states() == [True, False, False]
    rep.orchestrator.step()
    rep.orchestrator.pause()
    assert states() == [False, False, True]
    rep.orchestrator.resume()
    assert states() == [False, True, False]


@pytest.mark.parametrize(
    ("name", "arguments", "message"),
    [
        ("step", {"rt_subframes": "many"}, "rt_subframes is 'many'; expected a whole number"),
        ("step", {"delta_time": "soon"}, "delta_time is 'soon'; expected seconds, 0 or more, or None"),
        ("step", {"delta_time": -0.1}, "delta_time is -0.1"),
        ("step", {"delta_time": math.inf}, "delta_time is inf"),
        ("run", {"num_frames": "5"}, "num_frames is '5'; expected a whole number, 0 or more"),
        ("run_until_complete", {"num_frames": -1}, "num_frames is -1"),
        ("set_next_rt_subframes", {"rt_subframes": 2.5}, "rt_subframes is 2.5"),
        ("set_capture_on_play", {"value": "no"}, "value is 'no'; expected True or False"),
    ],
)
def test_invalid_arguments_raise_and_capture_nothing(writer, name, arguments, message):
    with pytest.raises(OrchestratorError, match=message):
        getattr(rep.orchestrator, name)(**arguments)
    assert writer.times == []
    assert rep.orchestrator.get_is_stopped()
