"""Lines of progress: none of short tasks, one now and then of long ones, and the end."""

import contextlib
import io
import itertools
import os
import sys

import pytest

from tests.session.clock import Clock
from usdsdg.session import progress
from usdsdg.session.progress import FRAMES, LONGEST_INTERVAL, VARIABLE, LineReporter, SilentReporter


@pytest.fixture
def clock(monkeypatch):
    found = Clock()
    monkeypatch.setattr(progress, "time", found)
    return found


def lines(clock, steps, label="files written", total=None) -> list[str]:
    """Report (seconds, done), and return the lines without their beginning."""
    stream = io.StringIO()
    reporter = LineReporter(stream)
    for clock.now, done in steps:
        reporter(label, done, total)
    return [line.removeprefix(f"[usdsdg] {label}: ") for line in stream.getvalue().splitlines()]


def test_lines_go_to_the_stderr_of_their_time(monkeypatch):
    """Test runners replace it for each test, and close it."""
    first, second = io.StringIO(), io.StringIO()
    monkeypatch.setattr(sys, "stderr", first)
    reporter = LineReporter()
    reporter.say("one")
    first.close()
    monkeypatch.setattr(sys, "stderr", second)
    reporter.say("two")
    assert second.getvalue() == "[usdsdg] two\n"


def test_nothing_is_said_of_short_tasks_but_of_the_number_of_frames(clock):
    steps = [(0.0, 0), (0.3, 5), (0.5, 10)]
    assert lines(clock, steps, total=10) == []
    assert lines(clock, steps, FRAMES, total=10) == ["10/10, 20.0/s"]


def test_long_tasks_have_lines_with_rate_and_time_left_and_an_end(clock):
    steps = [(seconds / 10, seconds) for seconds in range(101)]
    assert lines(clock, steps, total=100) == [
        "10/100, 10.0/s, 9 s left", "60/100, 10.0/s, 4 s left", "100/100, 10.0/s",
    ]  # fmt: skip


def test_lines_become_rarer_the_longer_a_task_takes(clock):
    steps = [(float(second), second) for second in range(7201)]
    said = [int(line.split(",")[0]) for line in lines(clock, steps)]
    gaps = [later - earlier for earlier, later in itertools.pairwise(said)]
    assert gaps == sorted(gaps)
    assert (gaps[0], gaps[-1]) == (5, LONGEST_INTERVAL)
    assert len(said) < 150


@pytest.mark.parametrize(
    ("value", "kind"), [("", LineReporter), ("1", LineReporter), ("0", SilentReporter), ("OFF", SilentReporter)]
)
def test_the_environment_turns_it_off(monkeypatch, value, kind):
    monkeypatch.setenv(VARIABLE, value)
    assert type(progress.reporter_of_library()) is kind


class WithoutFlush:
    """A stream that only writes, as logging windows of applications have it."""

    def __init__(self) -> None:
        self.text = ""

    def write(self, text: str) -> None:
        self.text += text


def test_a_stream_that_cannot_be_flushed_gets_the_lines(monkeypatch):
    stream = WithoutFlush()
    monkeypatch.setattr(sys, "stderr", stream)
    LineReporter().say("one")
    assert stream.text == "[usdsdg] one\n"


def test_lines_that_nobody_can_read_are_lost_and_the_run_goes_on(monkeypatch, capsys):
    reading, writing = os.pipe()
    os.close(reading)
    with pytest.raises(BrokenPipeError):
        os.write(writing, b"SIGPIPE is ignored, as in programs of Python")
    closed = io.StringIO()
    closed.close()
    pipe = open(writing, "w", encoding="utf-8", buffering=1)  # noqa: SIM115 - its end has no reader
    for stream in (pipe, closed, None):
        monkeypatch.setattr(sys, "stderr", stream)
        LineReporter().say("one")
    with contextlib.suppress(BrokenPipeError):
        pipe.close()
    assert capsys.readouterr().out == ""
