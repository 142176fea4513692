"""`usdsdg verify DIR`: prove that a dataset's files say what was rendered, and agree with each other."""

import json
from pathlib import Path
from typing import Annotated

import typer

from usdsdg.cli.command_context import AssetsRoot, Device, Quiet, command_context
from usdsdg.errors import BadValue

RENDERED = 10  # frames, where none are named


def verify(
    folder: Annotated[Path, typer.Argument(help="A folder that a writer wrote to.")],
    render: Annotated[bool, typer.Option("--render", help="Render frames again from the recorded stage.")] = False,
    frames: Annotated[
        str | None, typer.Option(help="Numbers of the frames to render again, as 0,12.", show_default="10 of them")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print everything as JSON.")] = False,
    limit: Annotated[int, typer.Option(min=1, help="Print at most this many faults.")] = 200,
    assets_root: AssetsRoot = None,
    device: Device = None,
    quiet: Quiet = False,
) -> None:
    """Read a dataset back through its format, and compare it with its record and with geometry.

    Prints a line for every fault; the exit code is 1 if there are any.
    """
    with command_context(assets_root=assets_root, device=device, quiet=quiet or as_json):
        from usdsdg.session.progress import report as progress
        from usdsdg.verify import verify as run

        report = run(folder, render=_chosen(render, frames), progress=progress)
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


def _chosen(render: bool, frames: str | None) -> list[int] | int | None:
    """Return the frames to render again: numbers, how many, or None for none."""
    if frames is None:
        return RENDERED if render else None
    try:
        return [int(part) for part in frames.split(",")]
    except ValueError:
        raise BadValue(f"--frames {frames!r}: give numbers of frames with commas, such as 0,12") from None
