"""How soon threads take turns at running Python while a frame is made."""

import sys
from types import SimpleNamespace

import pytest

from usdsdg.session.interpreter_lock import INTERVAL, switching_soon
from usdsdg.session.session import current


@pytest.fixture
def interval():
    before = sys.getswitchinterval()
    yield
    sys.setswitchinterval(before)


@pytest.mark.usefixtures("interval")
@pytest.mark.parametrize(
    ("device", "given", "expected"),
    [("cuda:0", 0.005, INTERVAL), ("cuda:0", 1e-5, 1e-5), ("cpu", 0.005, 0.005), (None, 0.005, 0.005)],
)
def test_threads_take_turns_sooner_where_a_gpu_renders(monkeypatch, device, given, expected):
    renderer = None if device is None else SimpleNamespace(device=device)
    monkeypatch.setattr(current().engines, "renderer", renderer)
    sys.setswitchinterval(given)
    found = []

    def frame():
        with switching_soon():
            found.append(sys.getswitchinterval())
            raise KeyError

    with pytest.raises(KeyError):
        frame()
    assert found == [pytest.approx(expected)]
    assert sys.getswitchinterval() == pytest.approx(given)
