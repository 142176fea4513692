"""Files and folders that the system does not let a command reach are an error of one line, whatever the command."""

import errno
import os

import pytest
from click.testing import CliRunner

from usdsdg.cli.app import app
from usdsdg.cli.options.command_context import as_usdsdg_error
from usdsdg.cli.options.file_kinds import no_file
from usdsdg.cli.options.optional_values import completed

LONG = "/" + "x" * 300  # an error of the system for each user, root too, as a folder that one may not enter is


@pytest.mark.parametrize(
    "arguments",
    [
        ("run", f"{LONG}.py"),
        ("compat", f"{LONG}.py"),
        ("convert", f"{LONG}.obj", "b.usd"),
        ("new", "script", f"{LONG}.py"),
        ("generate", f"{LONG}.yaml"),
    ],
)
def test_it_is_one_line(arguments):
    completed(arguments)
    done = CliRunner().invoke(app, list(arguments))
    assert (done.exit_code, done.output.count("\n")) == (1, 1), done.output
    assert "File name too long; give a shorter one" in done.output


@pytest.mark.parametrize("number", [errno.EACCES, errno.ESTALE])
def test_other_errors_of_the_system_are_those_of_programs(number):
    strerror = os.strerror(number)
    known = as_usdsdg_error(OSError(number, strerror, "/locked/a.usd"))
    assert str(known).startswith(f"/locked/a.usd: {strerror}; ")
    assert as_usdsdg_error(OSError(number, strerror)) is None
    assert as_usdsdg_error(IsADirectoryError(errno.EISDIR, "Is a directory", "/a")) is None


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names on this system")
def test_a_pipe_is_no_missing_file(tmp_path):
    os.mkfifo(tmp_path / "script.py")
    assert no_file(tmp_path / "script.py").endswith("is a pipe or device; give a file")
