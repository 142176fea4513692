"""Errors of functions that are called for a script: each says which function it is, where, and what it is for."""

import re

import pytest

import usdsdg as rep
from usdsdg import errors
from usdsdg.app.app import get_app
from usdsdg.compat.carb.eventdispatcher import get_eventdispatcher
from usdsdg.compat.omni.kit.app import get_app as get_kit_app
from usdsdg.listeners import Listeners
from usdsdg.session import engines
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline


def fails(*_):
    raise ZeroDivisionError("in the script")


class Final(rep.Writer):
    """Fails at its last frame."""

    def __init__(self):
        self.annotators = ["rgb"]

    def write(self, data): ...

    def on_final_frame(self):
        fails()


def _product():
    return rep.create.render_product(rep.create.camera(), (8, 8))


def _condition():
    with rep.trigger.on_condition(fails):
        rep.modify.visibility(False, input_prims=rep.create.cube())
    rep.orchestrator.step()


def _writer_trigger(tmp_path):
    writer = rep.writers.get("BasicWriter", {"output_dir": str(tmp_path), "rgb": True})
    writer.attach(_product(), trigger=fails)
    rep.orchestrator.step()


def _final_frame():
    Final().attach(_product())
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()


def _step():
    end = engines.subscribe_step(lambda dt: fails(dt))
    get_timeline().play()
    try:
        get_app().update()
    finally:
        end()


def _setting():
    get_settings().subscribe_to_node_change_events("/a", fails)
    get_settings().set("/a", 1)


def _stream():
    held = get_kit_app().get_message_bus_event_stream().create_subscription_to_pop(fails)
    get_kit_app().get_message_bus_event_stream().push(1)
    assert held


def _observer():
    held = get_eventdispatcher().observe_event(event_name="mine", on_event=fails)
    get_eventdispatcher().dispatch_event("mine")
    assert held


def _status():
    held = rep.orchestrator.register_status_callback(fails)
    try:
        rep.orchestrator.step()
    finally:
        held.unregister()


@pytest.mark.parametrize(
    ("call", "function", "what"),
    [
        (_condition, "fails", r"the condition of trigger\.on_condition made at test_callbacks\.py:\d+"),
        (_writer_trigger, "fails", "the trigger of BasicWriter"),
        (_final_frame, "Final.on_final_frame", "at the last frame of Final"),
        (_step, "_step.<locals>.<lambda>", "which was subscribed"),
        (_setting, "fails", "which was subscribed"),
        (_stream, "fails", "which was subscribed to events of message bus"),
        (_observer, "fails", "which observes mine"),
        (_status, "fails", "a status callback of the orchestrator"),
    ],
)
def test_the_error_of_a_callback_names_it(call, function, what, stage, tmp_path):
    with pytest.raises(ZeroDivisionError, match="in the script") as raised:
        call(*([tmp_path] if call is _writer_trigger else []))
    (note,) = raised.value.__notes__
    assert re.fullmatch(rf"\(raised in {re.escape(function)}, test_callbacks\.py:\d+, {what}\)", note)


def test_an_error_of_the_project_itself_names_no_callback():
    known = Listeners()
    known.subscribe(errors.let_pass)
    with pytest.raises(errors.GraphError, match="ours") as raised:
        known.call(errors.GraphError("ours"))
    assert not hasattr(raised.value, "__notes__")
