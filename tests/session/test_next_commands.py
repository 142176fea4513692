"""Which commands are named at the end of a run."""

from types import SimpleNamespace

import pytest

import usdsdg as rep
from usdsdg.session import next_commands
from usdsdg.session.next_commands import next_commands as commands
from usdsdg.writers.formats.writer_basic import BasicWriter


class OwnWriter(rep.Writer):
    """Of a format that nothing reads back."""

    def write(self, data):
        """Write nothing."""


class OwnBasicWriter(BasicWriter):
    """Of BasicWriter's format."""


@pytest.mark.parametrize(
    ("writers", "portion", "expected"),
    [
        ([BasicWriter], None, ["inspect", "verify"]),
        ([OwnBasicWriter], None, ["inspect", "verify"]),
        ([], None, ["inspect", "verify"]),
        ([OwnWriter], None, ["verify"]),
        ([BasicWriter, OwnWriter], None, ["inspect", "verify"]),
        ([BasicWriter], "0/2", ["merge"]),
    ],
)
def test_only_commands_are_named_that_can_look_at_what_was_written(monkeypatch, tmp_path, writers, portion, expected):
    run = SimpleNamespace(portion=portion)
    session = SimpleNamespace(run=run, writers=[kind.__new__(kind) for kind in writers])
    monkeypatch.setattr(next_commands, "current", lambda: session)
    assert [line.partition("usdsdg ")[2].split()[0] for line in commands([tmp_path])] == expected
