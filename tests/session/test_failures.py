"""Errors that several files, or several datasets of a run, have in common are printed once by a command."""

import pytest

from usdsdg.errors import OutputNotWritable, WriterError
from usdsdg.session import session
from usdsdg.session.endings import failures
from usdsdg.session.endings.failures import tell


@pytest.fixture(autouse=True)
def new_session():
    session.restart()
    yield
    session.restart()


def test_errors_of_one_cause_and_equal_ones_are_told_once(capsys):
    for name in "ab":
        error = OutputNotWritable(f"{name} cannot be written: the disk is full.")
        error.cause = "the disk is full"
        tell(error)
        tell(WriterError("the journal is damaged."), "at the end of the run: " if name == "b" else "")
    tell(WriterError("the recipe is damaged."))
    assert capsys.readouterr().err.splitlines() == [
        "error: a cannot be written: the disk is full.",
        "error: the journal is damaged.",
        "error: the recipe is damaged.",
    ]


def test_a_command_tells_what_an_earlier_one_of_the_process_has_told(capsys):
    for _ in range(2):
        failures.begin()
        tell(WriterError("the journal is damaged."))
    assert capsys.readouterr().err.splitlines() == ["error: the journal is damaged."] * 2
