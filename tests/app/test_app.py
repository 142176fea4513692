"""Updates, the event loop of scripts, and the timeline."""

import asyncio

import pytest

from usdsdg import engines
from usdsdg.app import get_app
from usdsdg.graph import evaluate
from usdsdg.stage.context import new_stage
from usdsdg.timeline import get_timeline


class StandIn:
    """A physics engine that only counts."""

    def __init__(self):
        self.advanced = []

    def play(self): ...

    def stop(self): ...

    def advance(self, seconds):
        self.advanced.append(seconds)
        return 1


@pytest.fixture
def physics(monkeypatch):
    get_app()
    new_stage()
    stand_in = StandIn()
    monkeypatch.setattr(engines, "_physics", stand_in)
    yield stand_in
    get_timeline().stop()


def test_a_playing_timeline_advances_by_one_time_code_per_update(physics):
    timeline = get_timeline()
    get_app().update()
    assert timeline.get_current_time() == 0.0
    timeline.play()
    get_app().update()
    assert timeline.get_current_time() == pytest.approx(1 / 60)
    assert physics.advanced == [pytest.approx(1 / 60)]


def test_all_who_wait_see_the_same_update(physics):
    seen = []

    async def waits(name, times):
        for _ in range(times):
            await get_app().next_update_async()
            seen.append((name, get_app().get_update_number()))

    before = get_app().get_update_number()

    tasks = []
    get_app().run(lambda: tasks.extend(asyncio.ensure_future(waits(name, 2)) for name in "ab"))
    assert sorted(seen) == [("a", before + 1), ("a", before + 2), ("b", before + 1), ("b", before + 2)]


def test_run_ends_when_the_tasks_have_ended_and_raises_their_failure(physics):
    async def fails():
        await get_app().next_update_async()
        raise KeyError("lost")

    with pytest.raises(KeyError, match="lost"):
        get_app().run(lambda: asyncio.ensure_future(fails()))


def test_a_failure_that_the_script_handles_does_not_end_the_run(physics):
    handled = []

    async def fails():
        raise KeyError("caught")

    async def main():
        try:
            await asyncio.ensure_future(fails())
        except KeyError as error:
            handled.append(error)
        await get_app().next_update_async()
        handled.append("went on")

    get_app().run(lambda: asyncio.ensure_future(main()))
    assert handled[-1] == "went on"


def test_a_failing_update_reaches_who_waits(physics):
    def explode(dt):
        raise RuntimeError("listener failed")

    end = get_app().subscribe_update(explode)
    try:
        with pytest.raises(RuntimeError, match="listener failed"):
            get_app().run_until_complete(get_app().next_update_async())
    finally:
        end()


def test_a_timeline_that_does_not_loop_pauses_at_its_end(physics):
    timeline = get_timeline()
    timeline.set_looping(False)
    timeline.set_end_time(0.05)
    timeline.play()
    for _ in range(5):
        get_app().update()
    assert timeline.get_current_time() == 0.05
    assert not timeline.is_playing()


def test_a_looping_timeline_wraps(physics):
    timeline = get_timeline()
    timeline.set_end_time(2.5 / 60)
    timeline.play()
    for _ in range(3):
        get_app().update()
    assert timeline.get_current_time() == pytest.approx(0.5 / 60)


def test_a_new_stage_forgets_graph_timeline_and_engines(physics):
    from usdsdg import trigger

    trigger.on_frame()
    get_timeline().play()
    new_stage()
    assert evaluate.graph().triggers == []
    assert get_timeline().is_stopped()
    assert engines.physics_if_made() is None
