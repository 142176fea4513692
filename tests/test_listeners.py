"""Subscriptions: each is ended for itself."""

import gc
from types import SimpleNamespace

import pytest

from usdsdg.app.app import get_app
from usdsdg.app.frame_loop import get_orchestrator
from usdsdg.listeners import Listeners, weakly
from usdsdg.session import engines, stage_context
from usdsdg.session.settings.store import get_settings
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
    monkeypatch.setattr(Listeners, "subscribe", _remembering(held, Listeners.subscribe))
    listener = Listener()
    end = subscribe(listener.hear)
    end()
    end_again = subscribe(listener.hear)
    end()
    (called,) = {id(each): each for each in held}.values()
    assert len(_subscriptions(called, listener.hear)) == 1
    end_again()
    assert not _subscriptions(called, listener.hear)


def _remembering(held, subscribe):
    def remembering(known, listener, **options):
        held.append(known)
        return subscribe(known, listener, **options)

    return remembering


def _subscriptions(known, listener):
    return [each for each in known._subscriptions if each.listener == listener]


def test_each_of_two_subscriptions_of_a_function_ends_itself_in_order():
    calls, known = [], Listeners()
    first = known.subscribe(calls.append)
    known.subscribe(lambda value: calls.append(-value))
    known.subscribe(calls.append)
    first()
    first()
    known.call(1)
    assert calls == [-1, 1]


def test_functions_are_called_by_their_order_and_then_as_they_subscribed():
    calls, known = [], Listeners()
    for name, order in (("b", 1), ("a", -2), ("c", 1), ("last", 9), ("between", 0)):
        known.subscribe(lambda name=name: calls.append(name), order=order)
    known.call()
    assert calls == ["a", "between", "b", "c", "last"]


def test_one_that_passes_on_what_it_hears_counts_while_it_has_listeners():
    inner, outer = Listeners(), Listeners()
    end_outer = outer.subscribe(inner.call, heard=inner.__bool__)
    assert not outer
    end_inner = inner.subscribe(print)
    assert outer
    end_inner()
    assert not outer
    inner.subscribe(print)
    end_outer()
    assert not outer


@pytest.mark.parametrize("use", [Listeners.call, bool])
def test_listeners_are_all_reached_while_an_object_with_a_subscription_is_collected(use):
    calls, known = [], Listeners()
    for number in range(50):
        known.subscribe(lambda number=number: calls.append(number), order=number % 5, heard=lambda: False)
    before = gc.get_threshold()
    try:
        for allocations in range(1, 120):  # after which the object is collected
            owner = SimpleNamespace()
            owner.me, owner.held = owner, _Held(known.subscribe(lambda: None, order=allocations % 5))
            del owner
            calls.clear()
            gc.set_threshold(gc.get_count()[0] + allocations)
            use(known)
            gc.set_threshold(*before)
            assert use is bool or calls == sorted(range(50), key=lambda number: (number % 5, number))
    finally:
        gc.set_threshold(*before)
    gc.collect()
    assert not known
    assert len(known._subscriptions) == 50


class _Held:
    """Ends a subscription when it is collected."""

    def __init__(self, end):
        self._end = end

    def __del__(self):
        self._end()


def test_a_listener_that_another_one_ends_is_not_called_any_more():
    calls, known = [], Listeners()

    def first(value):
        calls.append(("first", value))
        end_second()
        known.subscribe(lambda value: calls.append(("new", value)))

    known.subscribe(first)
    end_second = known.subscribe(lambda value: calls.append(("second", value)))
    known.subscribe(lambda value: calls.append(("third", value)))
    known.call(1)
    assert calls == [("first", 1), ("third", 1)]


def test_a_method_is_called_for_as_long_as_its_object_lives():
    listener = Listener()
    hear = weakly(listener.hear)
    hear(1)
    assert listener.calls == 1
    del listener
    hear(2)
