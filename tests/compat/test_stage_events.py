"""Events of stages and new frames: the streams of `omni.usd`, and their names in `carb.eventdispatcher`."""

import warnings

import pytest

import usdsdg as rep
from usdsdg.app.app import get_app
from usdsdg.compat.carb.eventdispatcher import get_eventdispatcher
from usdsdg.compat.omni import usd
from usdsdg.errors import UsdsdgError, UsdsdgWarning
from usdsdg.session import stage_context
from usdsdg.session.timeline import get_timeline

Kind = usd.StageEventType


@pytest.fixture
def heard(stage):
    """The names of the stage events since the test began."""
    get_app().update()  # the assets of the first stage
    names = []
    subscription = (
        usd.get_context()
        .get_stage_event_stream()
        .create_subscription_to_pop(lambda event: names.append(Kind(event.type).name))
    )
    get_app().update()
    names.clear()
    yield names
    subscription.unsubscribe()


def test_the_numbers_are_those_of_kit():
    assert [int(each) for each in (Kind.SAVED, Kind.OPENED, Kind.CLOSED, Kind.SELECTION_CHANGED)] == [0, 3, 6, 7]
    assert (int(Kind.ASSETS_LOADED), int(Kind.SAVING), int(Kind.COUNT)) == (8, 28, 29)
    assert sorted(int(each) for each in Kind) == list(range(30))
    assert int(usd.StageRenderingEventType.NEW_FRAME) == 0


def test_a_stage_that_replaces_another_sends_events_in_kits_order(heard, tmp_path):
    file = str(tmp_path / "scene.usda")
    context = usd.get_context()
    context.save_as_stage(file)
    assert heard == ["SAVING", "SAVED"]
    heard.clear()
    context.open_stage(file)
    assert heard == ["CLOSING", "CLOSED", "OPENING", "OPENED"]
    get_app().update()
    get_app().update()
    assert heard[4:] == ["ASSETS_LOADED"]
    assert context.get_stage_state() is usd.StageState.OPENED


def test_the_stage_is_still_there_while_it_closes(stage, heard):
    seen = []
    subscription = (
        usd.get_context()
        .get_stage_event_stream()
        .create_subscription_to_pop_by_type(int(Kind.CLOSING), lambda event: seen.append(usd.get_context().get_stage()))
    )
    usd.get_context().new_stage()
    assert seen == [stage]
    subscription.unsubscribe()


def test_failures_are_events_and_errors(heard, tmp_path):
    with pytest.raises(UsdsdgError):
        usd.get_context().open_stage(str(tmp_path / "nothing.usd"))
    with pytest.raises(UsdsdgError):
        usd.get_context().save_as_stage(str(tmp_path / "scene.txt"))
    assert heard == ["OPEN_FAILED", "SAVING", "SAVE_FAILED"]


def test_the_selection_and_the_timeline_send_events_when_they_change(heard):
    selection, timeline = usd.get_context().get_selection(), get_timeline()
    selection.set_selected_prim_paths(["/World"], True)
    selection.set_selected_prim_paths(["/World"], True)
    selection.clear_selected_prim_paths()
    assert heard == ["SELECTION_CHANGED"] * 2
    heard.clear()
    timeline.play()
    timeline.pause()
    timeline.play()
    timeline.stop()
    play = ["SIMULATION_START_PLAY", "ANIMATION_START_PLAY"]
    assert heard == [*play, "SIMULATION_STOP_PLAY", "ANIMATION_STOP_PLAY"]


def test_stage_events_have_names_in_the_dispatcher(stage):
    context, heard = usd.get_context(), []
    name = context.stage_event_name(Kind.OPENED)
    assert context.stage_event_type(name) is usd.stage_event_type(name) is Kind.OPENED
    assert usd.stage_event_type("mine:opened") is None
    observer = get_eventdispatcher().observe_event(event_name=name, on_event=heard.append)
    stage_context.new_stage()
    assert [event.event_name for event in heard] == [name]
    observer.reset()


def test_a_new_frame_is_an_event_of_the_rendering_stream(stage):
    numbers = []
    subscription = (
        usd.get_context()
        .get_rendering_event_stream()
        .create_subscription_to_pop_by_type(
            int(usd.StageRenderingEventType.NEW_FRAME),
            lambda event: numbers.append(event.payload["swh_frame_number"]),
            name="frames",
        )
    )
    for _ in range(2):
        rep.orchestrator.step()
    assert numbers == [1, 2]
    subscription.unsubscribe()
    rep.orchestrator.step()
    assert len(numbers) == 2


def test_who_waits_for_events_that_never_happen_is_warned(stage):
    context = usd.get_context()
    with pytest.warns(UsdsdgWarning, match=r"StageEventType\.HIERARCHY_CHANGED never happens; those that do are SAVED"):
        context.get_stage_event_stream().create_subscription_to_pop_by_type(int(Kind.HIERARCHY_CHANGED), print)
    added = usd.StageRenderingEventType.HYDRA_ENGINE_FRAMES_ADDED
    with pytest.warns(UsdsdgWarning, match="HYDRA_ENGINE_FRAMES_ADDED never happens; those that do are NEW_FRAME"):
        context.stage_rendering_event_name(added)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        context.stage_event_name(Kind.ASSETS_LOADED)


def test_the_next_stage_event_is_awaited_with_updates(stage):
    async def script():
        await usd.get_context().new_stage_async()
        return await usd.get_context().next_stage_event_async()

    assert get_app().run_until_complete(script()) == (int(Kind.ASSETS_LOADED), {})
