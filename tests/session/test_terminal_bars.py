"""Bars on a terminal: one for each task, below the lines that are printed, on a screen that is put together here."""

import io
import os
import re
import signal
import sys
import threading
from types import SimpleNamespace

import pytest

from tests.session.clock import Clock
from tests.signaled import started
from usdsdg.session import progress
from usdsdg.session.progress import FRAMES, described
from usdsdg.session.reporters import terminal_bars
from usdsdg.session.reporters.terminal_bars import LONGEST_BAR, SHORTEST_BAR, BarReporter, LinesAbove

COLUMNS = 80


class Terminal(io.StringIO):
    """A terminal that knows the sequences that bars are drawn with."""

    encoding = "utf-8"

    def isatty(self) -> bool:
        return True

    def screen(self) -> list[str]:
        """Return its lines, as far as something was written; the last is the one with the cursor."""
        lines, row, column = [""], 0, 0
        for part in re.findall(r"\x1b\[\d*[A-Z]|.", self.getvalue(), re.DOTALL):
            if part == "\n":
                row, column = row + 1, 0
                lines += [""] * (row + 1 - len(lines))
            elif part == "\r":
                column = 0
            elif part == "\x1b[K":
                lines[row] = lines[row][:column]
            elif part == "\x1b[J":
                lines = [*lines[:row], lines[row][:column]]
            elif part.startswith("\x1b["):
                row -= int(part[2:-1])
            else:
                lines[row] = lines[row][:column].ljust(column) + part + lines[row][column + 1 :]
                column += 1
        return [line.rstrip() for line in lines]


@pytest.fixture
def clock(monkeypatch):
    found = Clock()
    monkeypatch.setattr(terminal_bars, "time", found)
    return found


@pytest.fixture
def terminal():
    """A terminal to which the test prints from `reporter` on; pytest sets the streams itself before each test."""
    before = sys.stdout, sys.stderr
    yield Terminal()
    sys.stdout, sys.stderr = before


def reporter(terminal: Terminal) -> BarReporter:
    sys.stdout = sys.stderr = terminal
    return BarReporter(described, kept=FRAMES)


def begins(lines: list[str]) -> list[str]:
    """Return what a line says before its bar, or all of a line without one."""
    return [re.split(" +[█░]", line)[0] for line in lines]


def test_a_bar_has_the_rate_and_the_time_left_and_stays_at_the_end(clock, terminal):
    bars = reporter(terminal)
    bars("simulating", 0, 40)
    clock.now = 4.0
    bars("simulating", 10, 40)
    (line,) = terminal.screen()
    assert line.split(None, 2) == ["simulating", "█" * 6 + "░" * 18, "10/40, 2.5/s, 12 s left"]
    clock.now = 16.0
    bars("simulating", 40, 40)
    bars.close()
    ended, cursor = terminal.screen()
    assert ended.split(None, 2) == ["simulating", "█" * 24, "40/40, 2.5/s"]
    assert cursor == ""


def test_bars_of_several_tasks_stand_below_what_has_ended(clock, terminal):
    bars = reporter(terminal)
    bars(FRAMES, 0, 3)
    bars("files written", 5, None)
    assert [" ".join(line.split()) for line in begins(terminal.screen())] == [FRAMES, "files written 5"]
    bars("geometry", 0, 2)
    clock.now = 1.0
    bars("geometry", 2, 2)
    assert begins(terminal.screen())[:2] == ["geometry", FRAMES]
    clock.now = 2.0
    bars(FRAMES, 3, 3)
    bars.close()
    assert begins(terminal.screen())[:2] == ["geometry", FRAMES]
    assert terminal.screen()[2].startswith("files written")
    assert terminal.screen()[3:] == [""]


def test_lines_appear_above_the_bars_when_they_end(clock, terminal):
    bars = reporter(terminal)
    print("before")
    bars(FRAMES, 0, 3)
    bars.say("said")
    print("printed")
    print("an error", file=sys.stderr)
    print("the beginning", end="", flush=True)
    assert begins(terminal.screen()) == ["before", "said", "printed", "an error", FRAMES]
    print(" and the end")
    sys.stdout.writelines(["one\n", "two\n"])
    assert begins(terminal.screen())[4:] == ["the beginning and the end", "one", "two", FRAMES]
    print("no end", end="")
    bars.close()
    print(", but later")
    assert begins(terminal.screen())[7:] == [FRAMES, "no end, but later", ""]


def test_results_go_to_a_file_that_stdout_is(clock, terminal):
    """They were printed on the terminal that has the bars."""
    bars = reporter(terminal)
    sys.stdout = file = io.StringIO()
    bars(FRAMES, 0, 3)
    print("result")
    assert file.getvalue() == "result\n"
    assert begins(terminal.screen()) == [FRAMES]


@pytest.mark.parametrize("stream", [None, SimpleNamespace(write=len)])
def test_streams_of_scripts_may_be_anything(clock, terminal, stream):
    bars = reporter(terminal)
    sys.stdout = stream
    bars(FRAMES, 0, 3)
    bars.close()
    assert sys.stdout is stream


def test_streams_are_as_before_at_the_end(clock, terminal):
    bars = reporter(terminal)
    bars(FRAMES, 0, 3)
    kept = sys.stdout
    assert isinstance(kept, LinesAbove)
    assert kept.isatty()
    bars.close()
    assert sys.stdout is sys.stderr is terminal
    kept.write("by one who kept it")
    assert terminal.screen()[-1] == "by one who kept it"


def test_tasks_that_end_at_once_have_no_bar_but_frames(clock, terminal):
    """A texture of each frame would fill the screen."""
    bars = reporter(terminal)
    for _ in range(3):
        bars("textures", 1, 1)
    bars(FRAMES, 1, 1)
    bars.close()
    assert begins(terminal.screen()) == [FRAMES, ""]


def test_bars_are_drawn_ten_times_a_second_at_most(clock, terminal):
    bars = reporter(terminal)
    for step in range(10_000):
        clock.now = step / 10_000
        bars(FRAMES, step, 10_000)
    assert terminal.getvalue().count("\r") <= 11


@pytest.mark.parametrize("size", [(40, 24), (60, 24), (200, 24), (80, 3), (0, 0)])
def test_bars_fit_the_terminal(clock, terminal, monkeypatch, size):
    monkeypatch.setattr(terminal, "fileno", lambda: 2)
    monkeypatch.setattr(os, "get_terminal_size", lambda _: os.terminal_size(size))
    bars = reporter(terminal)
    for number in range(5):
        bars(f"task {number}", 1, 2)
    columns, rows = size[0] or COLUMNS, size[1] or 24
    lines = terminal.screen()
    assert len(lines) == min(5, rows - 1)
    assert lines[-1].startswith("task 4")
    assert max(map(len, lines)) < columns
    assert SHORTEST_BAR <= len(re.findall("[█░]", lines[0])) <= LONGEST_BAR


def test_a_terminal_without_blocks_has_bars_of_ascii(clock, terminal, monkeypatch):
    monkeypatch.setattr(Terminal, "encoding", "ascii")
    bars = reporter(terminal)
    bars(FRAMES, 1, 2)
    assert terminal.getvalue().isascii()
    assert "####" in terminal.screen()[0]


def test_threads_and_handlers_of_signals_may_report_at_once(terminal):
    bars = reporter(terminal)
    threads = [
        threading.Thread(target=lambda name=name: [bars(name, step, 200) for step in range(200)]) for name in "abcd"
    ]
    for each in threads:
        each.start()
    with bars._lock:  # as a handler that is called within a report
        bars.say("said")
    for each in threads:
        each.join()
    bars.close()
    assert sorted(line[0] for line in terminal.screen() if re.match("[abcd] ", line)) == list("abcd")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system does not fork")
@pytest.mark.filterwarnings("ignore:This process")
def test_a_fork_prints_although_a_thread_has_the_lock(clock, terminal):
    bars = reporter(terminal)
    bars(FRAMES, 0, 3)
    held, done = threading.Event(), threading.Event()

    def hold():
        with bars._lock:
            held.set()
            done.wait(10)

    thread = threading.Thread(target=hold)
    thread.start()
    held.wait()
    child = os.fork()
    if child == 0:
        signal.alarm(5)  # which ends it, if it waits for the lock
        print("printed")
        bars(FRAMES, 1, 3)
        bars.say("said")
        bars.close()
        os._exit(0 if terminal.getvalue().endswith("printed\nsaid\n") else 1)
    _, status = os.waitpid(child, 0)
    done.set()
    thread.join()
    assert os.waitstatus_to_exitcode(status) == 0


def test_a_terminal_that_hung_up_is_no_error(clock, terminal, monkeypatch):
    bars = reporter(terminal)
    bars(FRAMES, 0, 3)

    def fail(_):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(terminal, "write", fail)
    clock.now = 1.0
    bars(FRAMES, 1, 3)
    bars(FRAMES, 3, 3)
    bars.close()


@pytest.mark.parametrize(
    ("quiet", "term", "kind"),
    [
        (False, "xterm", BarReporter),
        (False, "dumb", progress.LineReporter),
        (True, "xterm", progress.SilentReporter),
    ],
)
def test_terminals_that_obey_have_bars(terminal, monkeypatch, quiet, term, kind):
    monkeypatch.setenv("TERM", term)
    sys.stderr, before = terminal, progress.current().reporter
    try:
        progress.use_default(quiet)
        assert type(progress.current().reporter) is kind
    finally:
        progress.use(before)


INTERRUPTED = """
import os, signal, time
from usdsdg.cli.options.command_context import command_context
from usdsdg.session.progress import report
with command_context():
    for step in range(1000):
        report("frames captured", step, 1000)
        print("step", step)
        time.sleep(0.02)
        if step == 30:
            os.kill(os.getpid(), signal.SIGINT)
"""


@pytest.mark.skipif(os.name == "nt", reason="Windows has no pseudo terminals")
def test_an_interrupt_leaves_the_terminal_as_it_was(tmp_path):
    import pty
    import termios

    (tmp_path / "command.py").write_text(INTERRUPTED)
    leader, follower = pty.openpty()
    before = termios.tcgetattr(follower)
    code = f"import sys, runpy\ntry:\n    runpy.run_path({str(tmp_path / 'command.py')!r})\n"
    code += "except Exception as ended:\n    sys.exit(ended.exit_code)\n"
    streams, variables = dict.fromkeys(("stdin", "stdout", "stderr"), follower), os.environ | {"TERM": "xterm"}
    with started(["-c", code], env=variables, **streams) as process:
        text = ""
        while "files written so far are whole" not in text:
            text += os.read(leader, 4096).decode(errors="replace")
        assert process.wait(60) == 130
    assert termios.tcgetattr(follower) == before
    os.close(follower)
    os.close(leader)
    screen = Terminal()
    screen.write(text.replace("\r\n", "\n"))
    lines = begins(screen.screen())
    assert lines[:2] == ["step 0", "step 1"]
    steps = [line for line in lines if line.startswith("step")]
    assert steps == [f"step {number}" for number in range(len(steps))]
    assert lines[len(steps) : len(steps) + 3] == [
        FRAMES,
        "interrupted: finishing the files in hand; Ctrl-C again stops at once",
        "files written so far are whole",
    ]
