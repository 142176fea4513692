"""`usdsdg compat [SCRIPT...]`: what scripts use of Isaac Sim and Omniverse, and how much of it is here."""

from pathlib import Path

import click
from click.exceptions import Exit

from usdsdg.cli.command import Command, argument
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.command_context import command_context
from usdsdg.cli.options.file_kinds import no_file
from usdsdg.cli.options.values import PATH
from usdsdg.errors import ConfigError
from usdsdg.session.endings.failures import tell


@click.command(cls=Command, epilog=epilog("compat"))
@argument("scripts", nargs=-1, type=PATH, metavar="[SCRIPT]...", help="Python scripts, which are read and not run.")
@click.option("--json", is_flag=True, help="Print JSON, for machines.")
@click.option("--all", "every", is_flag=True, help="Print supported names as well.")
def compat(scripts: tuple[Path, ...], json: bool, every: bool) -> None:
    """Print which names of Isaac Sim and Omniverse scripts use: supported, partial, missing or out of scope.

    Scripts are read, with the modules beside them that they import, and not run. Without scripts, the board of all
    known names is printed. The exit code is 1 if a script uses a name that is missing, or a file cannot be
    read.
    """
    with command_context(quiet=True):
        from usdsdg.compat.coverage import board
        from usdsdg.compat.coverage.used_names import uses_of
        from usdsdg.compat.coverage.verdicts import MISSING

        if not scripts:
            print(board.board_json() if json else board.board_text())
            return
        if missing := next((each for each in scripts if not each.is_file()), None):
            raise ConfigError(no_file(missing))
        unread: dict[Path, ConfigError] = {}
        rows = board.rows_of(uses_of(scripts, unread))
        if not unread.keys() >= {*scripts}:
            print(board.report_json(rows) if json else board.report_text(rows, supported=every))
        for error in unread.values():
            tell(error)
    if unread or any(row.state == MISSING for row in rows):
        raise Exit(1)
