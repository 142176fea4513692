"""SIGTERM, SIGHUP and SIGXCPU end a run after its frame, with whole files."""

import json
import signal
import threading
from types import SimpleNamespace

import pytest

from tests.signaled import run_and_signal
from usdsdg.cli.options import command_context
from usdsdg.session import session
from usdsdg.session.endings import termination
from usdsdg.writers.journal.earlier_run import Mode

SCRIPT = """
import os, sys
import omni.replicator.core as rep
from pxr import Gf
camera = rep.create.camera(position=(4, 4, 3), look_at=(0, 0, 0))
cube = rep.create.cube(semantics=[("class", "cube")])
rep.create.light(light_type="dome")
product = rep.create.render_product(camera, (64, 48))
for name, options in (("BasicWriter", {"rgb": True}), ("CocoWriter", {"dataset_id": "d"})):
    writer = rep.WriterRegistry.get(name)
    writer.initialize(output_dir=os.path.abspath(name), **options)
    writer.attach(product)
for frame in range(100000):
    rep.orchestrator.step()
    if frame == 1:
        print("ready", flush=True)
"""


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129), (signal.SIGXCPU, 152)])
def test_a_script_leaves_whole_datasets(tmp_path, number, code):
    returned, stderr = run_and_signal(tmp_path, SCRIPT, number)
    assert returned == code, stderr
    assert number.name in stderr
    assert "Traceback" not in stderr
    pictures = sorted(path.name for path in (tmp_path / "BasicWriter").glob("rgb_*.png"))
    assert len(pictures) >= 2
    (annotations,) = (tmp_path / "CocoWriter").rglob("coco_annotations*.json")
    images = json.loads(annotations.read_text())["images"]
    assert len(images) == len(pictures)
    assert not list(tmp_path.rglob("*.part"))


def test_a_limit_of_processor_time_asks_once():
    # As the system does each second, once the limit is passed.
    with termination.listening():
        with pytest.raises(termination.Terminated):
            signal.raise_signal(signal.SIGXCPU)
        signal.raise_signal(signal.SIGXCPU)
    assert signal.getsignal(signal.SIGXCPU) is signal.SIG_DFL


IN_DEL = """
import os, signal, time

class Last:
    def __del__(self):
        os.kill(os.getpid(), signal.NUMBER)
        time.sleep(0.01)

print("ready", flush=True)
time.sleep(0.3)
last = Last()
del last
time.sleep(30)
"""


@pytest.mark.parametrize(("name", "code"), [("SIGTERM", 143), ("SIGHUP", 129), ("SIGINT", 130)])
def test_a_signal_that_python_drops_in_a_del_ends_the_program(tmp_path, name, code):
    # SIGWINCH is ignored: the script sends itself the signal.
    returned, stderr = run_and_signal(tmp_path, IN_DEL.replace("NUMBER", name), signal.SIGWINCH)
    assert returned == code, stderr
    assert "Traceback" not in stderr


def test_an_interrupt_that_python_has_dropped_is_not_raised_again_once_another_has_ended_the_command(monkeypatch):
    raised = []
    monkeypatch.setattr(command_context, "interrupt_main_thread", raised.append)
    monkeypatch.setattr(command_context, "_is_ending", threading.Event())
    command_context._interrupt_again(signal.SIGINT)
    command_context._is_ending.set()
    command_context._interrupt_again(signal.SIGTERM)
    assert raised == [signal.SIGINT]


@pytest.mark.parametrize(
    ("command", "mode", "folders", "said"),
    [
        ("generate", Mode.NEW, ["out"], "; the same command with --resume goes on"),
        ("run", Mode.REPLACE, ["out"], "; the same command with --resume goes on"),
        ("generate", Mode.OVERWRITE, ["out"], "; the same command with --resume in place of --overwrite goes on"),
        ("generate", Mode.NEW, [], ""),
        ("python", Mode.NEW, ["out"], ""),
    ],
)
def test_a_command_says_how_to_go_on_if_it_can(command, mode, folders, said, monkeypatch):
    run = SimpleNamespace(folders=folders, scratch=None, recipe=SimpleNamespace(command=command), mode=mode)
    monkeypatch.setattr(session, "current", lambda: SimpleNamespace(run=run))
    assert command_context._how_to_go_on() == said
