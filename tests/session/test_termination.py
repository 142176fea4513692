"""Signals that ask the process to end."""

import signal

import pytest

from usdsdg.session.endings.termination import Terminated, listening, whole_frame


@pytest.fixture(autouse=True)
def _default_handlers():
    """Python's own handlers, whatever the tests run under."""
    before = {number: signal.signal(number, signal.SIG_DFL) for number in (signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_a_frame_is_finished_first(number, code):
    done = []

    def frame():
        with whole_frame():
            signal.raise_signal(number)
            done.append("frame")
        done.append("never")

    with listening(), pytest.raises(Terminated) as raised:
        frame()
    assert done == ["frame"]
    assert raised.value.exit_code == code
    assert str(raised.value) == number.name
    assert signal.getsignal(number) is signal.SIG_DFL


def test_between_frames_and_at_the_second_signal_the_end_is_at_once():
    reached = []

    def frame():
        with whole_frame():
            signal.raise_signal(signal.SIGTERM)
            reached.append("after the first")
            signal.raise_signal(signal.SIGTERM)
            reached.append("after the second")

    with listening():
        with pytest.raises(Terminated):
            signal.raise_signal(signal.SIGTERM)
        with pytest.raises(Terminated):
            frame()
    assert reached == ["after the first"]


def test_the_error_of_a_frame_is_not_replaced_by_the_signal():
    def frame():
        with whole_frame():
            signal.raise_signal(signal.SIGTERM)
            raise ValueError("frame failed")

    with listening(), pytest.raises(ValueError, match="frame failed"):
        frame()


def test_an_ignored_signal_stays_ignored():
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    with listening():
        signal.raise_signal(signal.SIGHUP)
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
