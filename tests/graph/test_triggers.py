"""When each trigger fires, how often, and the sub-frames that it requires."""

import pytest

import usdsdg as rep
from usdsdg.errors import GraphError
from usdsdg.graph import evaluate
from usdsdg.session.settings.store import get_settings


@pytest.fixture(autouse=True)
def stage(stage):
    """Without physics."""
    get_settings().set("/app/player/playSimulations", False)
    return stage


def firings(count, **moments):
    """Return which of `count` captures after the preview fire a trigger."""
    graph = evaluate.graph()
    graph.evaluate(preview=True)
    return [bool(graph.evaluate(capture=capture)) for capture in range(count)]


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        # The first capture shows what the preview drew.
        ({}, [0, 1, 1, 1, 1, 1]),
        ({"interval": 2}, [0, 0, 1, 0, 1, 0]),
        ({"max_execs": 2}, [0, 1, 0, 0, 0, 0]),
        ({"num_frames": 2}, [0, 1, 0, 0, 0, 0]),
        ({"num_frames": 2, "max_execs": 3}, [0, 1, 1, 0, 0, 0]),
    ],
)
def test_on_frame_fires_every_interval_up_to_max_execs(arguments, expected):
    rep.trigger.on_frame(**arguments)
    assert firings(6) == expected


@pytest.mark.parametrize(("arguments", "count"), [({}, 4), ({"max_execs": 3}, 3), ({"max_execs": 0}, 4)])
def test_a_condition_is_called_once_per_capture_and_fires_if_true(arguments, count):
    asked = []

    def even():
        asked.append(None)
        return len(asked) % 2 == 1

    trigger = rep.trigger.on_condition(even, **arguments)
    fired = firings(8)
    assert fired == [index % 2 == 0 and index // 2 < count for index in range(8)]
    assert trigger.executions == count
    assert len(asked) == (8 if count == 4 else 5)


def test_an_event_fires_only_its_own_trigger():
    one, other = rep.trigger.on_custom_event("one"), rep.trigger.on_custom_event(event_name="other")
    for event in ("one", "other", "one"):
        rep.utils.send_og_event(event)
    evaluate.graph().evaluate()
    assert (one.executions, other.executions) == (2, 1)


@pytest.fixture
def subframes(monkeypatch):
    """The sub-frames with which each capture is rendered."""
    from usdsdg.app import frame_loop

    asked = []
    draw = frame_loop.render_mode
    monkeypatch.setattr(frame_loop, "render_mode", lambda count: asked.append(count) or draw(count))
    return asked


@pytest.mark.parametrize(
    "make",
    [
        lambda: rep.trigger.on_frame(interval=2, rt_subframes=7),
        lambda: rep.trigger.on_condition(lambda: rep.orchestrator.get_orchestrator().captures == 2, rt_subframes=7),
    ],
    ids=["on_frame", "on_condition"],
)
def test_a_trigger_requires_sub_frames_of_the_capture_that_it_fires_for(subframes, make):
    make()
    for _ in range(4):
        rep.orchestrator.step()
    assert subframes == [1, 1, 7, 1]


def test_the_largest_required_number_of_sub_frames_is_used(subframes):
    rep.trigger.on_frame(rt_subframes=3)
    settings = get_settings()
    rep.orchestrator.step(rt_subframes=5)
    settings.set("/omni/replicator/RTSubframes", 4)
    rep.orchestrator.step()
    rep.orchestrator.step(rt_subframes=2)
    settings.set("/omni/replicator/RTSubframes", 1)
    for function in (rep.orchestrator.set_next_rt_subframes, rep.orchestrator.set_minimum_next_rt_subframes):
        function(6)
        rep.orchestrator.step()
        rep.orchestrator.step()
    assert subframes == [5, 4, 4, 6, 3, 6, 3]


def test_a_step_overrides_the_next_number_of_sub_frames_and_a_minimum_never_lowers_it(subframes):
    """As Replicator's orchestrator, which keeps one number for the next frame."""
    rep.orchestrator.set_next_rt_subframes(8)
    rep.orchestrator.set_minimum_next_rt_subframes(4)
    rep.orchestrator.step()
    rep.orchestrator.set_minimum_next_rt_subframes(4)
    rep.orchestrator.set_next_rt_subframes(2)
    rep.orchestrator.step()
    rep.orchestrator.set_next_rt_subframes(8)
    rep.orchestrator.step(rt_subframes=2)
    rep.orchestrator.step()
    assert subframes == [8, 2, 2, 1]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: rep.trigger.on_frame(interval=0), "interval is 0; expected a whole number, 1 or more"),
        (lambda: rep.trigger.on_frame(interval="often"), "interval is 'often'"),
        (lambda: rep.trigger.on_frame(interval=1.5), "interval is 1.5"),
        (lambda: rep.trigger.on_frame(max_execs="3"), "max_execs is '3'; expected a whole number"),
        (lambda: rep.trigger.on_frame(num_frames="3"), "num_frames is '3'; expected a whole number"),
        (lambda: rep.trigger.on_time(num="3"), "^num is '3'; expected a whole number"),
        (lambda: rep.trigger.on_frame(rt_subframes=None), "rt_subframes is None"),
        (lambda: rep.trigger.on_time(interval="soon"), "interval='soon' must be above 0"),
        (lambda: rep.trigger.on_time(interval=0), "interval=0 must be above 0"),
        (lambda: rep.trigger.on_time(interval=float("inf")), "interval=inf must be above 0, in seconds, and finite"),
        (lambda: rep.trigger.on_condition(True), "condition is True; expected a function"),
        (lambda: rep.trigger.on_condition(lambda frame: frame > 3), "<lambda> needs frame, and it is called without"),
        (lambda: rep.trigger.on_condition(bool, max_execs=2.5), "max_execs is 2.5"),
        (lambda: rep.trigger.on_custom_event(""), "event_name is ''; expected a name"),
        (lambda: rep.trigger.on_custom_event(5), "event_name is 5; expected a name"),
    ],
)
def test_invalid_triggers_raise_and_are_not_added(stage, make, message):
    with pytest.raises(GraphError, match=message):
        make()
    assert evaluate.graph().triggers == []
    assert not stage.GetPrimAtPath("/Replicator/SDGPipeline")


def test_inputs_of_a_trigger_can_be_set_between_frames(stage):
    cube = rep.create.cube()
    with rep.trigger.on_frame(rt_subframes=2) as trigger, cube:
        rep.modify.pose(position_x=rep.distribution.sequence(list(range(9))))
    shown = []

    def step(count):
        for _ in range(count):
            rep.orchestrator.step()
            shown.append(stage.GetPrimAtPath(cube.prims[0]).GetAttribute("xformOp:translate").Get()[0])

    step(3)
    trigger.node.get_attribute("inputs:interval").set(2)
    step(4)
    trigger.set_input("maxExecs", 5)
    step(3)
    assert shown == [0, 1, 2, 2, 3, 3, 4, 4, 4, 4]
    [made] = evaluate.graph().triggers
    assert (made.max_execs, made.rt_subframes) == (5, 2)


@pytest.mark.parametrize(
    ("make", "name", "value"),
    [
        (rep.trigger.on_frame, "interval", 0),
        (rep.trigger.on_frame, "maxExecs", 1.5),
        (rep.trigger.on_time, "interval", -1.0),
        (lambda: rep.trigger.on_custom_event("a"), "eventName", ""),
        (lambda: rep.trigger.on_condition(lambda: True), "rtSubframes", "many"),
    ],
)
def test_a_trigger_refuses_what_it_cannot_have_and_keeps_what_it_had(stage, make, name, value):
    trigger = make()
    before = trigger.get_input(name)
    with pytest.raises(GraphError):
        trigger.set_input(name, value)
    assert trigger.get_input(name) == before


def test_the_event_of_a_trigger_can_be_set(stage, capsys):
    cube = rep.create.cube()
    with rep.trigger.on_custom_event("go") as trigger, cube:
        rep.modify.pose(position=(1, 2, 3))
    trigger.set_input("eventName", "move")
    rep.utils.send_og_event("move")
    evaluate.graph().evaluate()
    assert stage.GetPrimAtPath(cube.prims[0]).GetAttribute("xformOp:translate").Get() == (1, 2, 3)
    assert "no trigger waits" not in capsys.readouterr().err
