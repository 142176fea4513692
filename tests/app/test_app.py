"""App updates, the event loop of scripts, and the timeline."""

import asyncio

import pytest

from usdsdg.app.app import get_app
from usdsdg.errors import Unsupported
from usdsdg.graph import evaluate
from usdsdg.session import engines
from usdsdg.session.session import current
from usdsdg.session.stage_context import new_stage
from usdsdg.session.timeline import get_timeline


class StandIn:
    """A physics engine that only counts its steps."""

    def __init__(self):
        self.advanced = []

    def play(self, *, time=None): ...

    def stop(self): ...

    def close(self): ...

    def advance(self, seconds, *, until=None):
        self.advanced.append(seconds)
        return 1


@pytest.fixture
def physics(stage, monkeypatch):
    stand_in = StandIn()
    monkeypatch.setattr(current().engines, "physics", stand_in)
    return stand_in


def test_a_playing_timeline_advances_by_one_time_code_per_update(physics):
    timeline = get_timeline()
    get_app().update()
    assert timeline.get_current_time() == 0.0
    timeline.play()
    get_app().update()
    assert timeline.get_current_time() == pytest.approx(1 / 60)
    assert physics.advanced == [pytest.approx(1 / 60)]


def test_all_waiters_get_the_same_update(physics):
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


def test_an_exception_that_the_script_handles_does_not_end_the_run(physics):
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


def test_an_exception_that_is_retrieved_later_does_not_end_the_run(physics):
    collected = []

    async def fails():
        raise KeyError("caught")

    async def main():
        task = asyncio.ensure_future(fails())
        collected.extend(await asyncio.gather(fails(), asyncio.sleep(0.01), return_exceptions=True))
        with pytest.raises(KeyError):
            await task

    get_app().run(lambda: asyncio.ensure_future(main()))
    assert [type(each) for each in collected] == [KeyError, type(None)]


def test_an_exception_that_cannot_be_retrieved_ends_endless_tasks(physics):
    async def fails():
        raise KeyError("lost")

    async def runs_on():
        while True:
            await get_app().next_update_async()

    with pytest.raises(KeyError, match="lost"):
        get_app().run(lambda: [asyncio.ensure_future(work) for work in (runs_on(), fails())] and None)


class Own(BaseException):
    """What `except Exception` does not catch."""


@pytest.mark.parametrize("lost", [BaseExceptionGroup("lost", [Own(), KeyboardInterrupt()]), Own(), GeneratorExit()])
def test_what_is_no_exception_but_cannot_be_retrieved_is_raised(lost, physics):
    async def fails():
        await asyncio.sleep(0)
        raise lost

    def script():
        asyncio.ensure_future(fails())  # noqa: RUF006 - must not be referenced

    with pytest.raises(BaseException) as raised:  # noqa: PT011 - the very object
        get_app().run(script)
    assert raised.value is lost


def test_an_unretrieved_exception_is_raised_after_the_script_ran_the_loop_itself(physics):
    async def fails():
        raise KeyError("lost")

    async def runs_on():
        while True:
            await get_app().next_update_async()

    def script():
        for work in (runs_on(), fails()):
            asyncio.ensure_future(work)  # noqa: RUF006 - must not be referenced
        asyncio.get_event_loop().run_until_complete(asyncio.sleep(0.01))

    with pytest.raises(KeyError, match="lost"):
        get_app().run(script)


def test_an_exception_of_a_task_that_is_still_referenced_is_raised_at_the_end(physics):
    held = []

    async def fails():
        raise KeyError("held")

    with pytest.raises(KeyError, match="held"):
        get_app().run(lambda: held.append(asyncio.ensure_future(fails())))


def test_every_update_of_a_standalone_loop_runs_the_ready_tasks(physics):
    updates = []

    async def main():
        for _ in range(3):
            await get_app().next_update_async()
            updates.append(get_app().get_update_number())
        return "done"

    def script():
        task = asyncio.ensure_future(main())
        count = 0
        while not task.done():
            get_app().update()
            count += 1
            assert count < 20
        assert task.result() == "done"

    before = get_app().get_update_number()
    get_app().run(script)
    assert updates == [before + 2, before + 3, before + 4]


@pytest.mark.parametrize("run", [asyncio.run, lambda work: asyncio.get_event_loop().run_until_complete(work)])
def test_a_script_may_run_a_coroutine_itself(physics, run):
    async def main():
        await get_app().next_update_async()
        get_app().update()
        return get_app().get_update_number()

    results = []
    before = get_app().get_update_number()
    get_app().run(lambda: results.append(run(main())))
    assert results == [before + 2]


def test_updates_work_without_app_run(physics):
    assert asyncio.run(get_app().next_update_async()) == pytest.approx(1 / 60)


def test_an_exit_in_a_task_ends_the_run_and_cancels_the_others(physics):
    seen = []

    async def waits():
        try:
            await asyncio.get_running_loop().create_future()
        except asyncio.CancelledError:
            seen.append("cancelled")
            raise

    async def ends():
        await get_app().next_update_async()
        raise SystemExit(3)

    with pytest.raises(SystemExit, match="3"):
        get_app().run(lambda: [asyncio.ensure_future(work) for work in (waits(), ends())] and None)
    assert seen == ["cancelled"]


def test_tasks_are_not_waited_for_once_the_app_is_closed(physics):
    async def runs_on():
        while True:
            await get_app().next_update_async()

    tasks = []

    def script():
        tasks.append(asyncio.ensure_future(runs_on()))
        get_app().update()
        get_app().close()
        assert not get_app().is_running()

    get_app().run(script)
    assert tasks[0].cancelled()


def test_a_failing_update_is_raised_in_its_waiters(physics):
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


@pytest.mark.parametrize("between", [None, "pause", "stop"])
def test_a_held_timeline_resumes_unless_a_command_comes_in_between(physics, between):
    timeline = get_timeline()
    timeline.play()
    timeline.hold()
    assert not timeline.is_playing()
    if between:
        getattr(timeline, between)()
    timeline.release()
    assert timeline.is_playing() == (between is None)


def test_a_new_stage_resets_graph_timeline_and_engines(physics):
    from usdsdg import trigger

    trigger.on_frame()
    get_timeline().play()
    new_stage()
    assert evaluate.graph().triggers == []
    assert get_timeline().is_stopped()
    assert engines.physics_if_made() is None


def test_a_task_that_never_wakes_up_does_not_delay_the_end(monkeypatch):
    """Ctrl-C can come between the end of what a task awaits and its wake-up, which then never happens."""
    import asyncio

    from usdsdg.app import script_loop

    monkeypatch.setattr(script_loop, "CLEAN_UP_SECONDS", 0.05)
    loop = script_loop.ScriptLoop()
    waited = loop._loop.create_future()

    async def wait():
        await waited

    task = asyncio.ensure_future(wait(), loop=loop._loop)
    loop.run_ready()
    waited.set_result(None)
    loop._loop._ready.clear()
    loop.close()
    assert not task.done()


def test_a_coroutine_is_not_run_to_its_end_within_a_loop_but_awaited():
    async def work() -> int:
        return 5

    async def cell() -> int:
        with pytest.raises(Unsupported, match=r"`await .*work\(\.\.\.\)`"):
            get_app().run_until_complete(work())
        return await work()

    assert asyncio.run(cell()) == 5
