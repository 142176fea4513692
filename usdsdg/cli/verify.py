"""`usdsdg verify DIR`: prove that a dataset's files say what was rendered, and agree with each other."""

import json
from pathlib import Path
from typing import Annotated

import typer

from usdsdg.cli.command_context import Quiet, command_context


def verify(
    folder: Annotated[Path, typer.Argument(help="A folder that a writer wrote to.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print everything as JSON.")] = False,
    limit: Annotated[int, typer.Option(min=1, help="Print at most this many faults.")] = 200,
    quiet: Quiet = False,
) -> None:
    """Read a dataset back through its format, and compare it with its record and with geometry.

    Prints a line for every fault; the exit code is 1 if there are any.
    """
    with command_context(quiet=quiet or as_json):
        from usdsdg.session.progress import report as progress
        from usdsdg.verify import verify as run

        report = run(folder, progress=progress)
    if as_json:
        print(json.dumps(report.values(), indent=1))
    else:
        for fault in report.faults[:limit]:
            print(fault.line())
        if len(report.faults) > limit:
            print(f"... and {len(report.faults) - limit} more (--limit)")
        for note in dict.fromkeys(report.notes):
            print(f"note: {note}")
        print(report.summary())
    if not report.is_clean:
        raise typer.Exit(1)
