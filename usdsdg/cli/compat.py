"""`usdsdg compat [SCRIPT...]`: what scripts use of Isaac Sim and Omniverse, and how much of it is here."""

from pathlib import Path
from typing import Annotated

import typer

from usdsdg.cli.options.command_context import command_context


def compat(
    scripts: Annotated[
        list[Path] | None,
        typer.Argument(metavar="SCRIPT...", help="Python scripts, which are read and not run.", show_default=False),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON, for machines.")] = False,
    every: Annotated[bool, typer.Option("--all", help="Print supported names as well.")] = False,
) -> None:
    """Print which names of Isaac Sim and Omniverse scripts use: supported, partial, missing or out of scope.

    Scripts are read, with the modules beside them that they import, and not run. Without scripts, the board of all
    known names is printed. The exit code is 1 if a script uses a name that is missing.
    """
    with command_context(quiet=True):
        from usdsdg.compat.coverage import board
        from usdsdg.compat.coverage.used_names import uses_of
        from usdsdg.compat.coverage.verdicts import MISSING

        if not scripts:
            print(board.board_json() if json else board.board_text())
            return
        rows = board.rows_of(uses_of(scripts))
        print(board.report_json(rows) if json else board.report_text(rows, supported=every))
    if any(row.state == MISSING for row in rows):
        raise typer.Exit(1)
