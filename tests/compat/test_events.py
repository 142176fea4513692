"""`carb.eventdispatcher`, `omni.physics.core` and the file checks of Isaac Sim's examples."""

from __future__ import annotations

import gc
import sys
from functools import partial
from types import SimpleNamespace

import pytest
from pxr import UsdPhysics

import usdsdg as rep
from usdsdg import compat
from usdsdg.errors import Unsupported
from usdsdg.session import stage_context


@pytest.fixture
def omni(monkeypatch):
    """Install the foreign modules that scripts import, and remove them afterward."""
    before = (list(sys.meta_path), set(sys.modules))
    compat.install()
    import carb.eventdispatcher
    import omni.kit.app
    import omni.physics.core
    import omni.timeline
    import omni.usd

    stage_context.new_stage()
    yield SimpleNamespace(carb=carb, omni=omni)
    sys.meta_path[:] = before[0]
    for name in set(sys.modules) - before[1]:
        if name.split(".")[0] in ("carb", "omni"):
            del sys.modules[name]


def test_app_updates_and_ticks_of_the_timeline_are_events(omni):
    dispatcher = omni.carb.eventdispatcher.get_eventdispatcher()
    updates, ticks, plays = [], [], []
    held = [
        dispatcher.observe_event(event_name=name, on_event=heard.append)
        for name, heard in (
            (omni.omni.kit.app.GLOBAL_EVENT_UPDATE, updates),
            (omni.omni.timeline.GLOBAL_EVENT_CURRENT_TIME_TICKED, ticks),
            (omni.omni.timeline.GLOBAL_EVENT_PLAY, plays),
        )
    ]
    app, timeline = omni.omni.kit.app.get_app(), omni.omni.timeline.get_timeline_interface()
    app.update()
    timeline.play()
    app.update()
    app.update()
    timeline.stop()
    assert (len(updates), len(ticks), len(plays)) == (3, 2, 1)
    assert ticks[1]["currentTime"] == pytest.approx(2 / 60)
    held.clear()
    app.update()
    assert len(updates) == 3


def test_observers_are_called_in_order_and_filtered(omni):
    dispatcher = omni.carb.eventdispatcher.get_eventdispatcher()
    heard = []
    second = dispatcher.observe_event(order=5, event_name="mine", on_event=lambda event: heard.append("second"))
    first = dispatcher.observe_event(
        order=-1, event_name="mine", on_event=lambda event: heard.append(event.get("n")), filter={"n": 3}
    )
    assert dispatcher.dispatch_event("mine", {"n": 2}) == 1
    assert dispatcher.dispatch_event("mine", {"n": 3}) == 2
    assert heard == ["second", 3, "second"]
    first.reset()
    second.reset()
    assert dispatcher.dispatch_event("mine", {"n": 3}) == 0


@pytest.mark.parametrize("kind", ["observers", "subscriptions"])
def test_what_an_earlier_listener_ends_is_not_called_any_more(omni, kind):
    heard, held = [], {}
    if kind == "observers":
        dispatcher = omni.carb.eventdispatcher.get_eventdispatcher()
        push = partial(dispatcher.dispatch_event, "mine")

        def listen(function):
            return dispatcher.observe_event(event_name="mine", on_event=function)

    else:
        stream = omni.omni.kit.app.get_app().get_message_bus_event_stream()
        push, listen = partial(stream.push, 9), stream.create_subscription_to_pop

    def first(_event):
        heard.append("first")
        held["second"].reset()

    held["first"] = listen(first)
    held["second"] = listen(lambda _event: heard.append("second"))
    held["third"] = listen(lambda _event: heard.append("third"))
    push()
    push()
    assert heard == ["first", "third"] * 2


@pytest.mark.parametrize("kind", ["observers", "subscriptions"])
def test_events_reach_all_while_an_object_with_a_subscription_is_collected(omni, kind):
    seen = []
    if kind == "observers":
        dispatcher = omni.carb.eventdispatcher.get_eventdispatcher()
        send = partial(dispatcher.dispatch_event, "mine")

        def subscribe(fn):
            return dispatcher.observe_event(event_name="mine", on_event=fn)
    else:
        stream = omni.omni.kit.app.get_app().get_message_bus_event_stream()
        subscribe, send = stream.create_subscription_to_pop, stream.push
    kept = [subscribe(seen.append) for _ in range(50)]
    before = gc.get_threshold()
    try:
        for allocations in range(1, 120):  # after which the object is collected
            owner = SimpleNamespace()
            owner.me, owner.subscription = owner, subscribe(lambda _: None)
            del owner
            seen.clear()
            gc.set_threshold(gc.get_count()[0] + allocations)
            send()
            gc.set_threshold(*before)
            assert len(seen) == len(kept)
    finally:
        gc.set_threshold(*before)


def test_dispatching_a_custom_event_fires_its_trigger(omni):
    cube = rep.create.cube()
    with rep.trigger.on_custom_event("go") as trigger, cube:
        rep.modify.pose(position=(0, 0, 7))
    omni.carb.eventdispatcher.get_eventdispatcher().dispatch_event("omni.graph.action.go")
    omni.omni.kit.app.get_app().update()
    assert trigger.get_output("execCount") == 1


def test_every_captured_frame_dispatches_an_event(omni):
    name = omni.omni.usd.get_context().stage_rendering_event_name(omni.omni.usd.StageRenderingEventType.NEW_FRAME, True)
    heard = []
    held = omni.carb.eventdispatcher.get_eventdispatcher().observe_event(event_name=name, on_event=heard.append)
    rep.orchestrator.step()
    rep.orchestrator.step()
    assert len(heard) == 2
    held.reset()


def test_every_update_shows_a_new_frame_in_the_viewport(omni):
    """As Kit's does, also where nothing is captured; an update that captures shows one frame."""
    name = omni.omni.usd.get_context().stage_rendering_event_name(omni.omni.usd.StageRenderingEventType.NEW_FRAME, True)
    heard = []
    held = omni.carb.eventdispatcher.get_eventdispatcher().observe_event(event_name=name, on_event=heard.append)
    for _ in range(3):
        omni.omni.kit.app.get_app().update()
    numbers = [event["swh_frame_number"] for event in heard]
    assert numbers == [numbers[0], numbers[0] + 1, numbers[0] + 2]
    rep.annotators.get("rgb").attach(rep.create.render_product(rep.create.camera(), (16, 16)))
    rep.orchestrator.set_capture_on_play(True)
    omni.omni.timeline.get_timeline_interface().play()
    for _ in range(2):
        omni.omni.kit.app.get_app().update()
    assert len(heard) == 5
    held.reset()


def test_physics_step_listeners_are_called_until_unsubscribed(omni):
    stage = stage_context.current_stage()
    UsdPhysics.Scene.Define(stage, "/PhysicsScene")
    physics = omni.omni.physics.core.get_physics_simulation_interface()
    steps = []
    held = physics.subscribe_physics_on_step_events(pre_step=False, order=0, on_update=lambda dt, _: steps.append(dt))
    omni.omni.timeline.get_timeline_interface().play()
    omni.omni.kit.app.get_app().update()
    assert steps == pytest.approx([1 / 60])
    held.unsubscribe()
    omni.omni.kit.app.get_app().update()
    assert len(steps) == 1
    order = []
    first = physics.subscribe_physics_on_step_events(pre_step=False, on_update=lambda *_: order.append("after"))
    second = physics.subscribe_physics_on_step_events(pre_step=True, on_update=lambda *_: order.append("before"))
    omni.omni.kit.app.get_app().update()
    assert order == ["before", "after"]
    first.unsubscribe()
    second.unsubscribe()
    omni.omni.timeline.get_timeline_interface().stop()


def test_the_timeline_ticks_once_per_update(omni):
    timeline = omni.omni.timeline.get_timeline_interface()
    timeline.set_play_every_frame(True)
    timeline.set_ticks_per_frame(1)
    with pytest.raises(Unsupported, match="once per update"):
        timeline.set_ticks_per_frame(4)


@pytest.mark.parametrize(
    ("expected", "options", "fits"),
    [
        ({"png": 2, "json": 1}, {}, True),
        ({"PNG": 2}, {}, True),
        ({"png": 1}, {}, False),
        ({"png": 1}, {"exact_match": False}, True),
        ({"png": 3}, {"recursive": True}, True),
        ({"png": 2}, {"allowed_extra_extensions": set()}, False),
        ({"png": 2}, {"allowed_extra_extensions": {"json"}}, True),
        ({"png": 2, "json": 1}, {"fail_on_empty_files": True}, False),
        ({"png": 2}, {"min_file_size_bytes": 10}, False),
    ],
)
def test_folders_are_validated_as_isaac_sims_examples_do(tmp_path, capsys, expected, options, fits):
    from usdsdg.compat.isaacsim.test.utils.file_validation import validate_folder_contents

    files = {"a.png": "12345", "b.PNG": "12345", "c.json": "", "deep/d.png": "12345"}
    # What usdsdg keeps beside a dataset does not count.
    for name, content in {**files, ".usdsdg/classes.json": "{}", ".usdsdg/frames/0000.png": ""}.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(content)
    assert validate_folder_contents(tmp_path, expected, **options) is fits
    assert bool(capsys.readouterr().out) is not fits
    assert not validate_folder_contents(tmp_path / "missing", {})
