"""`usdsdg verify DIR`: prove that a dataset's files say what was rendered, and agree with each other."""

from __future__ import annotations

import click
from click.exceptions import Exit

from usdsdg.cli.command import Command, argument
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.command_context import assets_root_option, command_context, device_option, quiet_option
from usdsdg.cli.options.report_options import json_option, limit_option, print_reports
from usdsdg.cli.options.values import PLACE
from usdsdg.errors import BadValue

RENDERED = 10  # frames, where none are named


@click.command(cls=Command, epilog=epilog("verify"))
@argument("folder", type=PLACE, help="A folder or URL that a writer wrote to, or one with several datasets.")
@click.option("--files", is_flag=True, help="Only compare the files with the journal, by size and hash.")
@click.option("--render", is_flag=True, help="Render frames again from the recorded stage.")
@click.option("--frames", help="Numbers of the frames to render again, as 0,12.", show_default="10 of them")
@json_option
@limit_option("faults of a dataset")
@assets_root_option
@device_option
@quiet_option
def verify(
    folder: str,
    files: bool,
    render: bool,
    frames: str | None,
    as_json: bool,
    limit: int,
    assets_root: str | None,
    device: str | None,
    quiet: bool,
) -> None:
    """Compare the files of a dataset with its journal; read it back through its format, and check its labels.

    The labels are compared with the record of each frame and with geometry.

    Prints a line for every fault, and one for each dataset in the folder; the exit code is 1 if there are any faults.
    """
    with command_context(assets_root=assets_root, device=device, quiet=quiet or as_json, keeps_files=False):
        from usdsdg.datasets.on_disk import on_disk
        from usdsdg.session.progress import report as progress
        from usdsdg.verify import verify_all

        if files and (render or frames is not None):
            raise BadValue("--files reads no images, and --render compares them: give only one of them")
        chosen = _chosen(render, frames)
        with on_disk(folder) as dataset:
            dataset.fetch()
            reports = verify_all(dataset.path, labels=not files, render=chosen, progress=progress)
            for each in reports:
                each.folder = dataset.named(each.folder)
    print_reports(folder, reports, as_json=as_json, limit=limit)
    if not all(each.is_clean for each in reports):
        raise Exit(1)


def _chosen(render: bool, frames: str | None) -> list[int] | int | None:
    """Return the frames to render again: numbers, how many, or None for none."""
    if frames is None:
        return RENDERED if render else None
    try:
        return [int(part) for part in frames.split(",")]
    except ValueError:
        raise BadValue(f"--frames {frames!r}: give numbers of frames with commas, such as 0,12") from None
