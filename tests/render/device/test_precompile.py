"""Kernels that are compiled on another thread are waited for by whoever needs them."""

import threading

import pytest

from usdsdg.errors import RenderError
from usdsdg_render.device import precompile as module


@pytest.fixture
def compiled(monkeypatch):
    """The calls of what compiles, which waits until it is let go on; on a machine with many cores."""
    calls, go_on = [], threading.Event()

    def compile_all(device, progress, *, everything=False):
        calls.append((device, everything))
        assert go_on.wait(10.0)
        progress("compiling", 1, 2)
        if device == "cuda:9":
            raise RenderError("no such device")
        return 3

    for name, value in (("_precompile", compile_all), ("_beside", {}), ("_ready", set()), ("_awaited", set())):
        monkeypatch.setattr(module, name, value)
    monkeypatch.setattr(module, "available_threads", lambda: 8)
    return calls, go_on


def test_it_goes_on_beside_and_is_waited_for_with_progress(compiled):
    calls, go_on = compiled
    heard = []
    module.precompile_beside("cuda:0", lambda *report: heard.append(report))
    module.precompile_beside("cuda:0")  # has begun already
    assert heard == []
    threading.Timer(0.1, go_on.set).start()
    module.precompile("cuda:0", lambda *report: None)
    assert heard == [("compiling", 1, 2)]  # `precompile` waited
    assert calls == [("cuda:0", False)] * 2


def test_there_is_no_progress_while_none_waits(compiled):
    _, go_on = compiled
    heard = []
    module.precompile_beside("cuda:0", lambda *report: heard.append(report))
    go_on.set()
    module._beside["cuda:0"].result()
    assert heard == []


def test_what_fails_is_raised_where_it_is_needed(compiled):
    _, go_on = compiled
    go_on.set()
    module.precompile_beside("cuda:9")
    with pytest.raises(RenderError, match="no such device"):
        module.precompile("cuda:9")


@pytest.mark.parametrize(("device", "cores"), [("cpu", 64), ("cuda:0", 2)])
def test_cpus_and_few_cores_compile_when_it_is_needed(compiled, monkeypatch, device, cores):
    calls, _ = compiled
    monkeypatch.setattr(module, "available_threads", lambda: cores)
    module.precompile_beside(device)
    assert calls == []
