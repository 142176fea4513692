"""Subscriptions: each is ended for itself."""

import pytest

from usdsdg import listeners
from usdsdg.app.app import get_app
from usdsdg.app.frame_loop import get_orchestrator
from usdsdg.session import engines, stage_context
from usdsdg.session.settings_store import get_settings
from usdsdg.session.timeline import get_timeline


class Listener:
    """Counts its calls; its method is another object, and equal, each time that it is taken."""

    def __init__(self):
        self.calls = 0

    def hear(self, *_):
        self.calls += 1


@pytest.mark.parametrize(
    "subscribe",
    [
        lambda hear: get_timeline().subscribe(hear),
        lambda hear: get_app().subscribe_update(hear),
        lambda hear: get_app().subscribe_before_update(hear),
        lambda hear: get_orchestrator().on_captured(hear),
        lambda hear: get_settings().on_change("/a", hear),
        lambda hear: engines.subscribe_step(hear),
        lambda hear: engines.subscribe_step(hear, before=True),
        lambda hear: engines.subscribe_contacts(hear),
        lambda hear: engines.subscribe_triggers(hear),
        lambda hear: stage_context.on_new_stage(hear),
        lambda hear: stage_context.on_stage_closing(hear),
    ],
)
def test_an_ended_subscription_leaves_the_next_one_of_the_same_function(stage, subscribe, monkeypatch):
    held = []
    monkeypatch.setattr(listeners, "subscribe", _remembering(held, listeners.subscribe))
    listener = Listener()
    end = subscribe(listener.hear)
    end()
    end_again = subscribe(listener.hear)
    end()
    (called,) = {id(each): each for each in held}.values()
    assert len([each for each in called if getattr(each, "func", None) == listener.hear]) == 1
    end_again()
    assert not [each for each in called if getattr(each, "func", None) == listener.hear]


def _remembering(held, subscribe):
    def remembering(known, listener, **options):
        held.append(known)
        return subscribe(known, listener, **options)

    return remembering


def test_each_of_two_subscriptions_of_a_function_ends_itself_in_order():
    calls, known = [], []
    first = listeners.subscribe(known, calls.append)
    listeners.subscribe(known, lambda value: calls.append(-value))
    listeners.subscribe(known, calls.append)
    first()
    first()
    for listener in known:
        listener(1)
    assert calls == [-1, 1]


def test_a_listener_that_another_one_ends_is_not_called_any_more():
    calls, known = [], []

    def first(value):
        calls.append(("first", value))
        end_second()
        listeners.subscribe(known, lambda value: calls.append(("new", value)))

    listeners.subscribe(known, first)
    end_second = listeners.subscribe(known, lambda value: calls.append(("second", value)))
    listeners.subscribe(known, lambda value: calls.append(("third", value)))
    for listener in list(known):
        listener(1)
    assert calls == [("first", 1), ("third", 1)]


def test_a_method_is_called_for_as_long_as_its_object_lives():
    listener = Listener()
    hear = listeners.weakly(listener.hear)
    hear(1)
    assert listener.calls == 1
    del listener
    hear(2)
