"""The help of every command has an example that the command takes; shells can complete them."""

import os
import subprocess
import sys

import click
import pytest
import typer
from typer.testing import CliRunner

from usdsdg.cli.commands import app
from usdsdg.cli.examples import EXAMPLES
from usdsdg.cli.options.optional_values import completed


def commands() -> dict[str, click.Command]:
    """Return all commands by name: "render", "assets get"."""
    top = typer.main.get_command(app)
    found = {}
    for name, command in top.commands.items():
        inner = getattr(command, "commands", None)
        found |= {f"{name} {each}": other for each, other in inner.items()} if inner else {name: command}
    return found


COMMANDS = commands()


def test_every_command_has_an_example():
    assert set(EXAMPLES) == set(COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_shows_examples_and_the_command_takes_them(name):
    command = COMMANDS[name]
    shown = shown_help(name)
    for arguments, what in EXAMPLES[name]:
        assert f"usdsdg {arguments}" in shown
        assert f"({what})" in shown
        given = completed(arguments.split(" > ")[0].split())[len(name.split()) :]
        # Raises if there is no such option, or if an argument is missing or has another type.
        command.make_context(name, list(given), resilient_parsing=False).close()


def shown_help(name: str) -> str:
    """Return what `usdsdg NAME --help` prints, on one line."""
    done = CliRunner().invoke(app, [*name.split(), "--help"], env={"COLUMNS": "300", "TERMINAL_WIDTH": "300"})
    assert done.exit_code == 0
    return " ".join(done.stdout.split())


@pytest.mark.parametrize(("shell", "part"), [("bash", "complete -o default -F"), ("zsh", "#compdef usdsdg")])
def test_shells_get_their_completion(shell, part):
    """The script for a shell, and what it asks for: commands that begin so, then options."""
    assert part in complete(f"source_{shell}", "")
    words = {"bash": {"COMP_WORDS": "usdsdg ver", "COMP_CWORD": "1"}, "zsh": {"_TYPER_COMPLETE_ARGS": "usdsdg ver"}}
    assert "verify" in complete(f"complete_{shell}", words[shell])
    words = {
        "bash": {"COMP_WORDS": "usdsdg render --cam", "COMP_CWORD": "2"},
        "zsh": {"_TYPER_COMPLETE_ARGS": "usdsdg render --cam"},
    }
    assert "--camera" in complete(f"complete_{shell}", words[shell])


def complete(what: str, words) -> str:
    program = "import sys; sys.argv[0] = 'usdsdg'; from usdsdg.cli.commands import main; main()"
    environment = {**os.environ, "_USDSDG_COMPLETE": what, **(words or {})}
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, env=environment)
    return done.stdout
