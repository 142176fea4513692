"""The start and end of runs, their draws, and the timeline between steps."""

import asyncio

import pytest

from usdsdg import distribution, modify, orchestrator, trigger, utils
from usdsdg.app.status import Status, StatusCallback
from usdsdg.graph.sampling import set_global_seed
from usdsdg.orchestrator import OrchestratorError, get_orchestrator
from usdsdg.session.settings.store import get_settings
from usdsdg.session.stage_context import current_stage, new_stage
from usdsdg.session.timeline import get_timeline
from usdsdg.stage import assets


@pytest.fixture(autouse=True)
def stage(stage):
    """Without physics."""
    get_settings().set("/app/player/playSimulations", False)
    return stage


@pytest.fixture
def no_physics(monkeypatch):
    from usdsdg.session import engines

    monkeypatch.setattr(engines, "physics", lambda: type("Still", (), {"play": lambda self, time=None: None})())


def randomized(under):
    """Add a cube whose size is drawn under a trigger; return a function that reads the size."""
    path = str(current_stage().DefinePrim("/World/cube", "Cube").GetPath())
    with under:
        modify.attribute("size", distribution.uniform(1.0, 2.0), input_prims=path)
    return lambda: current_stage().GetPrimAtPath(path).GetAttribute("size").Get()


def captured(size, count, after_each=lambda: None):
    sizes = []
    for _ in range(count):
        orchestrator.step()
        sizes.append(size())
        after_each()
    return sizes


def test_waiting_for_files_between_frames_does_not_change_draws():
    expected = captured(randomized(trigger.on_frame()), 4)
    assert len(set(expected)) == 4
    new_stage()
    set_global_seed(1)
    assert captured(randomized(trigger.on_frame()), 4, orchestrator.wait_until_complete) == expected


def test_events_draw_new_values_after_waiting_for_files():
    size = randomized(trigger.on_custom_event("go"))
    sizes = []
    for _ in range(3):
        utils.send_og_event("go")
        sizes += captured(size, 1, orchestrator.wait_until_complete)
    assert len(set(sizes)) == 3


def test_stop_and_setting_the_seed_restart_the_draws():
    size = randomized(trigger.on_frame())
    first = captured(size, 3)
    orchestrator.stop()
    assert captured(size, 3) == first
    set_global_seed(5)
    other = captured(size, 2)
    set_global_seed(5)
    assert captured(size, 2) == other
    assert other[0] not in first


def sizes_of_runs(size, count):
    """The sizes that the frames of so many runs show, one list for each run."""
    runs = []
    for _ in range(count):
        sizes = []
        end = get_orchestrator().on_captured(lambda sizes=sizes: sizes.append(size()))
        try:
            orchestrator.run_until_complete()
        finally:
            end()
        runs.append(sizes)
    return runs


def test_a_second_run_repeats_the_draws_of_the_first():
    """Generators and counts of executions are reset whenever a stopped orchestrator starts a run, as in Replicator."""
    first, second, third = sizes_of_runs(randomized(trigger.on_frame(max_execs=3)), 3)
    assert len(set(first)) == 3
    assert first == second == third


def test_another_seed_gives_a_second_run_other_draws():
    size = randomized(trigger.on_frame(max_execs=3))
    [first] = sizes_of_runs(size, 1)
    set_global_seed(5)
    [other] = sizes_of_runs(size, 1)
    assert not set(first) & set(other)
    set_global_seed(5)
    assert sizes_of_runs(size, 1) == [other]


def test_a_run_after_a_stop_is_as_long_as_the_first(no_physics):
    sizes = randomized(trigger.on_time(interval=0.1, max_execs=2))
    [first] = sizes_of_runs(sizes, 1)
    orchestrator.stop()
    assert sizes_of_runs(sizes, 1) == [first]
    assert len(first) > 2


def test_steps_before_a_run_take_no_frames_from_it():
    """As those that load materials, before the run itself."""
    expected = sizes_of_runs(randomized(trigger.on_frame(max_execs=3)), 1)
    new_stage()
    set_global_seed(1)
    size = randomized(trigger.on_frame(max_execs=3))
    captured(size, 2)
    assert sizes_of_runs(size, 1) == expected


def test_a_run_that_starts_the_timeline_after_steps_plays_it(no_physics):
    orchestrator.step()
    trigger.on_frame(max_execs=3)
    times = []
    end = get_orchestrator().on_captured(lambda: times.append(get_timeline().get_current_time()))
    try:
        orchestrator.run(start_timeline=True)
    finally:
        end()
    assert times == pytest.approx([0, 1 / 60, 2 / 60])


def test_a_playing_timeline_resumes_at_the_next_step(no_physics):
    orchestrator.set_capture_on_play(False)
    timeline = get_timeline()
    timeline.play()
    times = []
    for _ in range(3):
        orchestrator.step(delta_time=0.1)
        assert not timeline.is_playing()
        times.append(timeline.get_current_time())
    # The first captured frame does not advance the timeline.
    assert times == pytest.approx([0.0, 0.1, 0.2])
    timeline.pause()
    orchestrator.step()
    assert timeline.get_current_time() == pytest.approx(0.2)
    orchestrator.step(delta_time=0.1)
    assert not timeline.is_playing()
    assert timeline.get_current_time() == pytest.approx(0.3)


def test_a_run_that_would_never_end_is_an_error():
    randomized(trigger.on_frame())
    with pytest.raises(OrchestratorError, match="num_frames"):
        orchestrator.run()


def test_a_run_that_waits_for_a_stopped_timeline_is_an_error():
    orchestrator.set_capture_on_play(False)
    randomized(trigger.on_time(interval=0.5, num=2, enable_capture_on_play=False))
    with pytest.raises(OrchestratorError, match=r"on_time.*start_timeline=True"):
        orchestrator.run()
    assert get_orchestrator().captures == 0


def test_a_run_with_a_time_trigger_plays_the_timeline_itself(no_physics):
    randomized(trigger.on_time(interval=0.5, num=2))
    orchestrator.run()
    # One time code per frame but the first.
    assert get_orchestrator().captures == pytest.approx(1 + 60, abs=2)
    assert get_timeline().is_stopped()
    assert get_timeline().get_current_time() == 0.0


def test_a_run_is_as_long_as_its_triggers_where_num_frames_is_longer():
    randomized(trigger.on_frame(max_execs=3))
    orchestrator.run_until_complete(num_frames=5)
    assert get_orchestrator().captures == 3


def test_a_trigger_without_end_does_not_end_a_run_before_num_frames():
    randomized(trigger.on_frame(max_execs=3))
    randomized(trigger.on_frame())
    orchestrator.run_until_complete(num_frames=5)
    assert get_orchestrator().captures == 5


def test_the_status_of_a_run_is_started():
    seen = []
    callback = StatusCallback(seen.append)
    callback.register()
    orchestrator.run_until_complete(num_frames=3)
    assert [each for each in seen if each in (Status.STEPPING, Status.STEPPED)] == []
    orchestrator.step()
    assert get_orchestrator().status is Status.STEPPED


def test_a_run_with_a_time_trigger_ends_when_the_timeline_plays(no_physics):
    randomized(trigger.on_time(interval=0.5, num=2))
    orchestrator.run(start_timeline=True)
    # One time code per frame but the first.
    assert get_orchestrator().captures == pytest.approx(1 + 60, abs=2)


def test_a_condition_that_is_never_true_ends_the_run_with_an_error():
    def settled():
        return False

    randomized(trigger.on_condition(settled, max_execs=2))
    with pytest.raises(OrchestratorError, match=r"'settled' was false at the last 1000 captures"):
        orchestrator.run()


def test_a_condition_that_becomes_true_late_ends_the_run():
    asked = []
    randomized(trigger.on_condition(lambda: asked.append(1) or len(asked) > 50, max_execs=2))
    orchestrator.run()
    assert get_orchestrator().captures == 52


def test_a_task_can_stop_a_run():
    randomized(trigger.on_frame())

    async def main():
        work = asyncio.ensure_future(orchestrator.run_async(num_frames=10_000))
        while get_orchestrator().captures < 5 and not work.done():
            await asyncio.sleep(0)
        await orchestrator.stop_async()
        await work

    asyncio.run(main())
    assert orchestrator.get_is_stopped()


def test_a_run_that_cannot_start_is_checked_again_the_next_time(stage, tmp_path):
    prim = stage.DefinePrim("/World/mug", "Xform")
    prim.GetReferences().AddReference(str(tmp_path / "mug.usda"))
    assets.set_on_missing(assets.OnMissing.ERROR)
    try:
        for _ in range(2):
            with pytest.raises(assets.MissingAssets, match=r"mug\.usda"):
                orchestrator.step()
            assert orchestrator.get_is_stopped()
        prim.SetActive(False)
        assets.set_on_missing(assets.OnMissing.ERROR)  # forgets those of the past
        orchestrator.step()
    finally:
        assets.set_on_missing(assets.OnMissing.RAISE)
