"""The help of every command has an example that the command takes; shells can complete them."""

import os
import subprocess
import sys

import click
import pytest
from click.shell_completion import BashComplete
from click.testing import CliRunner

from tests.scripts.conftest import ROOT
from usdsdg.cli.app import app
from usdsdg.cli.examples import EXAMPLES
from usdsdg.cli.options.optional_values import completed


def commands() -> dict[str, click.Command]:
    """Return all commands by name: "render", "assets get"."""
    found = {}
    for name, command in app.commands.items():
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
    done = CliRunner().invoke(app, [*name.split(), "--help"], env={"COLUMNS": "300"})
    assert done.exit_code == 0
    return " ".join(done.stdout.split())


@pytest.mark.parametrize("columns", [80, 120])
@pytest.mark.parametrize("name", COMMANDS)
def test_help_has_the_width_of_the_terminal_and_breaks_no_word(name, columns):
    done = CliRunner().invoke(app, [*name.split(), "--help"], env={"COLUMNS": str(columns)})
    text, _, examples = done.output.partition("\nExample")
    lines = text.splitlines()
    assert max(map(len, lines)) <= columns
    assert not [line for line in lines if line.rstrip().endswith("-")]
    assert [line.removeprefix("  usdsdg ") for line in examples.splitlines() if line.startswith("  usdsdg ")] == [
        arguments for arguments, _ in EXAMPLES[name]
    ]


def test_the_help_of_the_program_has_whole_sentences():
    shown = " ".join(CliRunner().invoke(app, ["--help"], env={"COLUMNS": "80"}).output.split())
    for command in app.commands.values():
        assert " ".join(command.help.partition("\n\n")[0].split()) in shown


@pytest.mark.parametrize("arguments", [[], ["assets"]])
def test_without_a_command_the_help_is_printed(arguments):
    done, asked = (CliRunner().invoke(app, [*arguments, *more]) for more in ([], ["--help"]))
    assert (done.exit_code, asked.exit_code) == (2, 0)
    assert done.output == asked.output


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["generat"], "No such command 'generat'. Did you mean 'generate' or 'render'?"),
        (["assets", "gt"], "No such command 'gt'. Did you mean 'get'?"),
        (["abacus"], "No such command 'abacus'."),
        ([f"{ROOT}/configs/detection.yaml"], "which `usdsdg generate "),
        ([f"{ROOT}/examples/first_script.py", "--seed", "3"], "a script, which `usdsdg run "),
        ([f"{ROOT}/docs"], "`usdsdg inspect "),
        (["--abacus"], "No such option"),
        (["render", "a", "b", "--camra", "c"], "--camera"),
        (["render", "a"], "Missing argument 'OUTPUT'."),
        (
            ["new", "detectio"],
            "Invalid value for 'KIND': 'detectio' is not one of 'detection', 'bin-picking', 'script'.",
        ),
        (["render", "a", "b", "--spp", "0"], "Invalid value for '--spp': 0 is not in the range 1<=x<=1048576."),
        (["simulate", "a", "b", "--seconds", "nan"], "Invalid value for '--seconds': nan is not a number."),
        (["generate", "a", "--gpus-per-worker", "inf"], "is not in the range 0.0<=x<=1024.0."),
    ],
)
def test_a_wrong_command_line_ends_with_code_2_and_a_sentence_on_one_line(arguments, said):
    done = CliRunner().invoke(app, arguments, env={"COLUMNS": "40"})
    assert done.exit_code == 2
    assert said in done.output.splitlines()[-1]


@pytest.mark.parametrize(
    ("shell", "part"),
    [("bash", "complete -o nosort -F"), ("zsh", "#compdef usdsdg"), ("fish", "complete --no-files --command usdsdg")],
)
def test_shells_get_their_completion(shell, part):
    """The script that is printed asks the program, which answers with the commands that begin so."""
    script = CliRunner().invoke(app, ["completion", shell]).output
    assert part in script
    assert f"_USDSDG_COMPLETE={shell}_complete" in script
    program = "import sys; sys.argv[0] = 'usdsdg'; from usdsdg.cli.program import main; main()"
    words = {"COMP_WORDS": "usdsdg ver", "COMP_CWORD": "ver" if shell == "fish" else "1"}
    environment = {**os.environ, "_USDSDG_COMPLETE": f"{shell}_complete", **words}
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, env=environment)
    assert "verify" in done.stdout
    assert "generate" not in done.stdout


@pytest.mark.parametrize(
    ("line", "answers"),
    [
        ("assets l", ["plain,list"]),
        ("render --cam", ["plain,--camera"]),
        ("new d", ["plain,detection"]),
        ("run --new-stage ", ["plain,kit", "plain,isaac"]),
        ("completion ", ["plain,bash", "plain,zsh", "plain,fish"]),
        ("run --inspect scri", ["file,scri"]),
        ("run script.py pict", ["file,pict"]),
        ("render scene.usd pict", ["file,pict"]),
        ("verify _out", ["file,_out"]),
        ("generate --assets-root s", ["file,s"]),
        ("assets ge", ["plain,get"]),
        ("run --par", []),
    ],
)
def test_commands_options_choices_and_file_names_are_completed(monkeypatch, line, answers):
    words = f"usdsdg {line}"
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(words.count(" ")))
    assert BashComplete(app, {}, "usdsdg", "_USDSDG_COMPLETE").complete().splitlines() == answers
