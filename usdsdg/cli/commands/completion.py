"""`usdsdg completion SHELL`: the script that lets a shell complete commands, options, their values and file names."""

import enum

import click
from click.shell_completion import get_completion_class

from usdsdg.cli.command import Command, argument
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.values import Member

PROGRAM = "usdsdg"


class Shell(enum.StrEnum):
    """A shell that click knows."""

    BASH = "bash"
    ZSH = "zsh"
    FISH = "fish"


@click.command(cls=Command, epilog=epilog("completion"))
@argument("shell", type=Member(Shell), help="The shell that is to complete.")
@click.pass_context
def completion(context: click.Context, shell: Shell) -> None:
    """Print the script that lets a shell complete commands, options, their values and file names.

    Keep it in a file, which a line in the file that the shell reads at its start brings to every new shell:

    \b
    bash:
        usdsdg completion bash > ~/.usdsdg_completion.bash
        in ~/.bashrc: source ~/.usdsdg_completion.bash
    zsh:
        usdsdg completion zsh > ~/.usdsdg_completion.zsh
        in ~/.zshrc, after compinit: source ~/.usdsdg_completion.zsh
    fish, which needs no line:
        usdsdg completion fish > ~/.config/fish/completions/usdsdg.fish

    bash must be 4.4 or later, which that of macOS is not.
    """
    kind = get_completion_class(shell.value)
    assert kind is not None
    # The variable is the one that click itself looks for when it runs the program of this name.
    print(kind(context.find_root().command, {}, PROGRAM, f"_{PROGRAM.upper()}_COMPLETE").source())
